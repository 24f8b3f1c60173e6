/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi sweep: an experiment from the command line or from a file. */
#include "cli/client.h"
#include "cli/interrupt.h"
#include "cli/verbs.h"
#include "core/basics.h"
#include "core/json.h"
#include "core/output_file.h"

#include <errno.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* With --json only what is odd is shown before the end. */
static bool on_told(void *user, const char *report) {
    const mcv_command *command = user;
    if (report && command->json) {
        mcv_client_notes(report);
    } else if (report) {
        mcv_client_text(report);
        fflush(stdout);
    }
    return mcv_interrupt == 0;
}

/* F.json beside the table must not replace the file that the experiment is read from. */
static mcv_result check_experiment(const mcv_command *c, const char *file, mcv_error *error) {
    char *sidecar;
    MCV_TRY(mcv_client_name(c->table, ".json", &sidecar, error));
    const mcv_result result =
        mcv_same_file(sidecar, file)
            ? mcv_fail(error, MCV_USAGE, "%s is the experiment: give the table another name by -o",
                       sidecar)
            : MCV_OK;
    free(sidecar);
    return result;
}

/* `file`: what the table is named after, the rig or the file of the experiment. */
static mcv_result run(const mcv_command *c, const char *rig, const char *file, mcv_error *error) {
    mcv_client client = {NULL};
    char *report = NULL;
    mcv_result result = check_experiment(c, file, error);
    if (result == MCV_OK) result = mcv_client_open(c, rig, &client, error);
    mcv_interrupt_watch(false);
    if (result == MCV_OK)
        result = mcv_session_sweep(client.session, client.rig, client.options, on_told, (void *)c,
                                   &report, error);
    if (report && c->json)
        puts(report);
    else if (report)
        mcv_client_text(report);
    mcv_text_free(report);
    mcv_client_close(&client);
    return result == MCV_INTERRUPTED ? mcv_interrupt_result() : result;
}

/* The table of --output, or FILE-sweep.csv. */
static mcv_result sweep_command(const mcv_command *c, const char *rig, const char *file,
                                mcv_error *error) {
    mcv_command named = *c;
    char *name = NULL;
    if (!c->table) MCV_TRY(mcv_client_name(file, "-sweep.csv", &name, error));
    if (name) named.table = name;
    const mcv_result result = run(&named, rig, file, error);
    free(name);
    return result;
}

/* The scene of an experiment file, relative to its folder. */
static mcv_result read_rig(const json_t *document, const char *path, char rig[PATH_MAX],
                           mcv_error *error) {
    char copy[PATH_MAX];
    const char *name = json_string_value(json_object_get(document, "rig"));
    snprintf(copy, sizeof copy, "%s", path);
    if (!name)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: rig: is missing: the scene, as in \"rig\": \"part.gltf\"", path);
    if (snprintf(rig, PATH_MAX, "%s%s%s", name[0] == '/' ? "" : dirname(copy),
                 name[0] == '/' ? "" : "/", name) >= PATH_MAX)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: rig: the path is too long", path);
    return MCV_OK;
}

/* {"rig": "part.gltf", "vary": […], …}: options by name, before those of the command line. */
static mcv_result sweep_file(const mcv_command *given, const char *path, mcv_error *error) {
    char rig[PATH_MAX];
    json_error_t wrong;
    mcv_arguments arguments = {0};
    mcv_command command;
    json_t *document = json_load_file(path, JSON_REJECT_DUPLICATES, &wrong);
    if (!document)
        return wrong.line > 0
                   ? mcv_fail(error, MCV_BAD_INPUT, "%s: line %d column %d is not JSON: %s", path,
                              wrong.line, wrong.column, mcv_json_wrong(&wrong))
                   : mcv_fail(error, MCV_BAD_INPUT, "%s: %s", path, strerror(errno));
    mcv_result result = read_rig(document, path, rig, error);
    json_object_del(document, "rig");
    json_object_del(document, "fingerprint");
    if (result == MCV_OK)
        result = mcv_arguments_read(document, path, given, path, &arguments, error);
    json_decref(document);
    if (result == MCV_OK) {
        mcv_error detail = {""};
        result = mcv_command_parse(arguments.count, arguments.items, &command, &detail);
        if (result != MCV_OK) result = mcv_fail(error, result, "%s: %s", path, detail.text);
        if (result == MCV_OK) result = sweep_command(&command, rig, path, error);
        mcv_command_free(&command);
    }
    mcv_arguments_free(&arguments);
    return result;
}

mcv_result mcv_verb_sweep(const mcv_command *command, mcv_error *error) {
    return mcv_ends_in(command->argument, ".json")
               ? sweep_file(command, command->argument, error)
               : sweep_command(command, command->argument, command->argument, error);
}
