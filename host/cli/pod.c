/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi pod: from which size on defects are found, of a table or of an experiment, which is
 * rendered first. */
#include "cli/client.h"
#include "cli/interrupt.h"
#include "cli/verbs.h"
#include "core/basics.h"
#include "core/json.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The study of a table: options of the command line stand before those of `given`, or NULL. */
static mcv_result study_table(const mcv_command *command, const char *table, const json_t *given,
                              mcv_error *error) {
    static const char *const without[] = {"allow-exec", NULL};
    char *own = NULL, *report = NULL;
    MCV_TRY(mcv_client_options(command, without, &own, error));
    json_t *options = given ? json_deep_copy(given) : json_object(),
           *above = json_loads(own, 0, NULL);
    json_object_update(options, above);
    json_object_del(options, "allow-exec");
    char *text = json_dumps(options, JSON_REAL_PRECISION(17));
    json_decref(above);
    json_decref(options);
    free(own);
    mcv_result result = text ? mcv_pod_table(table, text, &report, error)
                             : mcv_fail(error, MCV_FAILED, "no memory for the options");
    free(text);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    return result;
}

/* --- experiments --- */

/* Renders what the table does not have yet. `experiment`: the options of a sweep. */
static mcv_result render(const mcv_command *c, const char *rig_path, json_t *experiment,
                         const char *table, mcv_error *error) {
    mcv_session *session = NULL;
    mcv_rig *rig = NULL;
    json_object_set_new(experiment, "output", json_string(table));
    json_object_set_new(experiment, "resume", json_true());
    /* With common random numbers all defects would have one noise, and its spread were not seen. */
    if (!json_object_get(experiment, "noise"))
        json_object_set_new(experiment, "noise", json_string("own"));
    json_object_set_new(experiment, "json", json_boolean(c->json));
    if (c->allow_exec) json_object_set_new(experiment, "allow-exec", json_true());
    char *options = json_dumps(experiment, JSON_REAL_PRECISION(17));
    mcv_result result = options ? mcv_session_open(NULL, &session, error)
                                : mcv_fail(error, MCV_FAILED, "no memory for the options");
    if (result == MCV_OK) result = mcv_rig_open(rig_path, &rig, error);
    mcv_interrupt_watch(false);
    if (result == MCV_OK)
        result = mcv_session_sweep(session, rig, options, mcv_client_told, (void *)c, NULL, error);
    mcv_rig_free(rig);
    mcv_session_close(session);
    free(options);
    return result == MCV_INTERRUPTED ? mcv_interrupt_result() : result;
}

/* Who hands a file on must not thereby run programs on another's machine. */
static mcv_result check(const json_t *document, const char *path, mcv_error *error) {
    if (json_object_get(document, "allow-exec"))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: allow-exec: is not for files: give --allow-exec on the command line",
                        path);
    return json_is_object(json_object_get(document, "pod"))
               ? MCV_OK
               : mcv_fail(error, MCV_BAD_INPUT,
                          "%s: pod: is missing: what to tell, as in \"pod\": {\"size\": \"depth\", "
                          "\"signal\": \"contrast\", \"threshold\": \"5\"}",
                          path);
}

static mcv_result study_document(const mcv_command *c, json_t *document, mcv_error *error) {
    char rig[PATH_MAX], *table = NULL, *page = NULL;
    MCV_TRY(check(document, c->argument, error));
    MCV_TRY(mcv_client_rig(document, c->argument, rig, error));
    json_t *told = json_incref(json_object_get(document, "pod"));
    json_object_del(document, "pod");
    json_object_del(document, "rig");
    json_object_del(document, "fingerprint");
    mcv_result result = mcv_client_name(c->argument, "-sweep.csv", &table, error);
    if (result == MCV_OK) result = mcv_client_name(c->argument, "-pod.html", &page, error);
    if (result == MCV_OK && !json_object_get(told, "output"))
        json_object_set_new(told, "output", json_string(page));
    if (result == MCV_OK) result = render(c, rig, document, table, error);
    if (result == MCV_OK) result = study_table(c, table, told, error);
    json_decref(told);
    free(table);
    free(page);
    return result;
}

static mcv_result study_experiment(const mcv_command *c, mcv_error *error) {
    json_error_t wrong;
    json_t *document = json_load_file(c->argument, JSON_REJECT_DUPLICATES, &wrong);
    if (!document && wrong.line > 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: line %d column %d is not JSON: %s", c->argument,
                        wrong.line, wrong.column, mcv_json_wrong(&wrong));
    if (!document) return mcv_fail(error, MCV_BAD_INPUT, "%s: %s", c->argument, strerror(errno));
    const mcv_result result = study_document(c, document, error);
    json_decref(document);
    return result;
}

mcv_result mcv_verb_pod(const mcv_command *command, mcv_error *error) {
    return mcv_ends_in(command->argument, ".json")
               ? study_experiment(command, error)
               : study_table(command, command->argument, NULL, error);
}
