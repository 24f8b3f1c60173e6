/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi sweep: runs an experiment (experiment/experiment.h) from the command line or from a
 * file. */
#include "cli/verbs.h"
#include "cli/interrupt.h"
#include "cli/tell.h"
#include "verbs/report.h"
#include "cli/sweep.h"
#include "core/basics.h"
#include "core/json.h"
#include "verbs/sweep.h"

#include <errno.h>
#include <libgen.h>
#include <stdio.h>
#include <string.h>

static mcv_result interrupted(void *user) {
    (void)user;
    return mcv_interrupt_result();
}

static void warn(void *user, const char *sentence) {
    (void)user;
    mcv_tell("warning", sentence);
}

/* The table of --output, or ARGUMENT-sweep.csv. */
static mcv_result name_table(const mcv_command *c, char table[PATH_MAX], mcv_error *error) {
    const char *given = c->argument, *dot = strrchr(given, '.'), *slash = strrchr(given, '/');
    const int stem =
        (int)(dot && dot > (slash ? slash : given) ? dot - given : (long)strlen(given));
    const int length = c->table ? snprintf(table, PATH_MAX, "%s", c->table)
                                : snprintf(table, PATH_MAX, "%.*s-sweep.csv", stem, given);
    return length < PATH_MAX ? MCV_OK
                             : mcv_fail(error, MCV_USAGE, "the path of the table is too long");
}

static mcv_result run(const mcv_command *c, const mcv_experiment *experiment, mcv_error *error) {
    const double begun = mcv_seconds();
    mcv_sweep s;
    mcv_result result = mcv_experiment_plan(experiment, &s, error);
    mcv_interrupt_watch(false);
    if (result == MCV_OK) result = mcv_experiment_open_table(&s, error);
    if (result == MCV_OK) result = mcv_experiment_run(&s, error);
    if (result == MCV_OK) result = mcv_sweep_report(&s, c->json, mcv_seconds() - begun, error);
    const size_t failed = mcv_table_failed(&s.table);
    if (result == MCV_OK && failed == s.table.row_count)
        result = mcv_fail(error, MCV_FAILED, "all %zu sets failed, the first one: %s", failed,
                          s.table.messages[0]);
    mcv_experiment_free(&s);
    return result;
}

static mcv_result sweep_command(const mcv_command *c, const char *rig, mcv_error *error) {
    char table[PATH_MAX];
    mcv_experiment experiment;
    MCV_TRY(mcv_sweep_experiment(c, &experiment, error));
    MCV_TRY(name_table(c, table, error));
    experiment.rig = rig;
    experiment.file = c->argument;
    experiment.table = table;
    experiment.settings = mcv_sweep_settings(c);
    experiment.calls = (mcv_sweep_calls){
        .warning = warn, .row = mcv_sweep_tell_row, .interrupted = interrupted, .user = (void *)c};
    const mcv_result result = run(c, &experiment, error);
    json_decref(experiment.settings);
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
        if (result == MCV_OK) result = sweep_command(&command, rig, error);
        mcv_command_free(&command);
    }
    mcv_arguments_free(&arguments);
    return result;
}

mcv_result mcv_verb_sweep(const mcv_command *command, mcv_error *error) {
    return mcv_ends_in(command->argument, ".json")
               ? sweep_file(command, command->argument, error)
               : sweep_command(command, command->argument, error);
}
