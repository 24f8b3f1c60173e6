/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi pod: from which size on defects are found, of a table or of an experiment, which is
 * rendered first. */
#include "cli/client.h"
#include "cli/interrupt.h"
#include "cli/verbs.h"
#include "core/basics.h"
#include "core/json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static mcv_result study_table(const mcv_command *command, mcv_error *error) {
    static const char *const without[] = {"allow-exec", NULL};
    char *options = NULL, *report = NULL;
    MCV_TRY(mcv_client_options(command, without, &options, error));
    mcv_result result = mcv_pod_table(command->argument, options, &report, error);
    free(options);
    if (result == MCV_OK) result = mcv_client_print(report, command->json, error);
    return result;
}

/* --- experiments --- */

/* Renders what the table does not have yet, and studies it. `experiment`: options of the library.
 */
static mcv_result run(const mcv_command *c, const char *rig_path, const json_t *experiment,
                      mcv_error *error) {
    mcv_session *session = NULL;
    mcv_rig *rig = NULL;
    char *report = NULL, *options = json_dumps(experiment, JSON_REAL_PRECISION(17));
    mcv_result result = options ? mcv_session_open(NULL, &session, error)
                                : mcv_fail(error, MCV_FAILED, "no memory for the options");
    if (result == MCV_OK) result = mcv_rig_open(rig_path, &rig, error);
    mcv_interrupt_watch(false);
    if (result == MCV_OK)
        result = mcv_session_pod(session, rig, options, mcv_client_told, (void *)c, &report, error);
    if (result == MCV_OK) result = mcv_client_print(report, c->json, error);
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

/* The options of the command line stand before those of the file; outputs are named after it. */
static mcv_result complete(const mcv_command *c, json_t *document, mcv_error *error) {
    static const char *const without[] = {"allow-exec", NULL};
    json_t *study = json_object_get(document, "pod");
    char *own = NULL, *table = NULL, *page = NULL;
    MCV_TRY(mcv_client_options(c, without, &own, error));
    json_t *above = json_loads(own, 0, NULL);
    free(own);
    mcv_result result = mcv_client_name(c->argument, "-sweep.csv", &table, error);
    if (result == MCV_OK) result = mcv_client_name(c->argument, "-pod.html", &page, error);
    if (result == MCV_OK) {
        json_object_update(study, above);
        if (!json_object_get(study, "output"))
            json_object_set_new(study, "output", json_string(page));
        json_object_del(document, "rig");
        json_object_del(document, "fingerprint");
        json_object_set_new(document, "output", json_string(table));
        json_object_set_new(document, "resume", json_true());
        json_object_set_new(document, "json", json_boolean(c->json));
        if (c->allow_exec) json_object_set_new(document, "allow-exec", json_true());
    }
    json_decref(above);
    free(table);
    free(page);
    return result;
}

static mcv_result study_document(const mcv_command *c, json_t *document, mcv_error *error) {
    char rig[PATH_MAX];
    MCV_TRY(check(document, c->argument, error));
    MCV_TRY(mcv_client_rig(document, c->argument, rig, error));
    MCV_TRY(complete(c, document, error));
    return run(c, rig, document, error);
}

static mcv_result study_experiment(const mcv_command *c, mcv_error *error) {
    json_t *document;
    MCV_TRY(mcv_json_file_read(c->argument, &document, error));
    const mcv_result result = study_document(c, document, error);
    json_decref(document);
    return result;
}

mcv_result mcv_verb_pod(const mcv_command *command, mcv_error *error) {
    return mcv_ends_in(command->argument, ".json") ? study_experiment(command, error)
                                                   : study_table(command, error);
}
