/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi sweep, uncertainty and optimize: an experiment from the command line or from a file. */
#include "cli/client.h"
#include "cli/interrupt.h"
#include "cli/verbs.h"
#include "core/basics.h"
#include "core/json.h"
#include "core/output_file.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What the verbs differ in. */
typedef struct experiment {
    const char *ending; /* of the table by default */
    mcv_result (*run)(mcv_session *session, const mcv_rig *rig, const char *options,
                      mcv_told_call *told, void *user, char **report, mcv_error *error);
} experiment;

/* F.json beside the table must not replace the file that the experiment is read from. */
static mcv_result check_experiment(const mcv_command *c, const char *file, mcv_error *error) {
    char *sidecar;
    MCV_TRY(mcv_client_name(c->table, ".json", &sidecar, error));
    const bool resumes = c->resume && access(c->table, F_OK) == 0; /* it stays as it is then */
    const mcv_result result =
        mcv_same_file(sidecar, file) && !resumes
            ? mcv_fail(error, MCV_USAGE, "%s is the experiment: give the table another name by -o",
                       sidecar)
            : MCV_OK;
    free(sidecar);
    return result;
}

/* `file`: what the table is named after, the rig or the file of the experiment. */
static mcv_result run(const experiment *e, const mcv_command *c, const char *rig, const char *file,
                      mcv_error *error) {
    mcv_client client = {NULL};
    char *report = NULL;
    mcv_result result = check_experiment(c, file, error);
    if (result == MCV_OK) result = mcv_client_open(c, rig, &client, error);
    mcv_interrupt_watch(false);
    if (result == MCV_OK)
        result = e->run(client.session, client.rig, client.options, mcv_client_told, (void *)c,
                        &report, error);
    if (report && c->json)
        mcv_client_line(report);
    else if (report)
        mcv_client_text(report);
    mcv_text_free(report);
    mcv_client_close(&client);
    return result == MCV_INTERRUPTED ? mcv_interrupt_result() : result;
}

/* The table of --output, or FILE-VERB.csv; of a part I of N with .I-of-N before its ending. */
static mcv_result run_command(const experiment *e, const mcv_command *c, const char *rig,
                              const char *file, mcv_error *error) {
    mcv_command named = *c;
    named.allow_exec = true; /* what stands on the command line, or was allowed there */
    char *name = NULL, *whole = NULL, ending[64];
    const char *slash = c->share ? strchr(c->share, '/') : NULL;
    if (!c->table) MCV_TRY(mcv_client_name(file, e->ending, &whole, error));
    if (whole) named.table = whole;
    mcv_result result = MCV_OK;
    if (slash && !strchr(slash + 1, '/')) {
        snprintf(ending, sizeof ending, ".%.*s-of-%.16s.csv", (int)(slash - c->share), c->share,
                 slash + 1);
        result = mcv_client_name(named.table, ending, &name, error);
        if (name) named.table = name;
    }
    if (result == MCV_OK) result = run(e, &named, rig, file, error);
    free(name);
    free(whole);
    return result;
}

/* Whether a file's metrics run programs. */
static bool has_programs(const json_t *document) {
    const json_t *metrics = json_object_get(document, "metric");
    const size_t count = json_is_array(metrics) ? json_array_size(metrics) : 1;
    for (size_t i = 0; i < count; ++i) {
        const char *text =
            json_string_value(json_is_array(metrics) ? json_array_get(metrics, i) : metrics);
        const char *assigned = text ? strstr(text, ":=") : NULL;
        const char *expression = assigned ? assigned + 2 : text;
        if (expression &&
            (strncmp(expression, "exec(", 5) == 0 || strncmp(expression, "worker(", 7) == 0))
            return true;
    }
    return false;
}

/* Who hands a file on must not thereby run programs on another's machine. */
static mcv_result check_programs(const json_t *document, const mcv_command *given, const char *path,
                                 mcv_error *error) {
    if (json_object_get(document, "allow-exec"))
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: allow-exec: is not for files: give --allow-exec on the command line",
                        path);
    return has_programs(document) && !given->allow_exec
               ? mcv_fail(error, MCV_USAGE,
                          "%s: metric: runs a program: read it, and allow it by --allow-exec", path)
               : MCV_OK;
}

/* {"rig": "part.gltf", "vary": […], …}: options by name, before those of the command line. */
static mcv_result run_file(const experiment *e, const mcv_command *given, const char *path,
                           mcv_error *error) {
    char rig[PATH_MAX];
    mcv_arguments arguments = {0};
    mcv_command command;
    json_t *document;
    MCV_TRY(mcv_json_file_read(path, &document, error));
    mcv_result result = mcv_client_rig(document, path, rig, error);
    if (result == MCV_OK) result = check_programs(document, given, path, error);
    json_object_del(document, "rig");
    json_object_del(document, "fingerprint");
    json_object_del(document, "pod"); /* what `mcvisi pod` makes of the table */
    if (result == MCV_OK)
        result = mcv_arguments_read(document, path, given, path, &arguments, error);
    json_decref(document);
    if (result == MCV_OK) {
        mcv_error detail = {""};
        result = mcv_command_parse(arguments.count, arguments.items, &command, &detail);
        if (result != MCV_OK) result = mcv_fail(error, result, "%s: %s", path, detail.text);
        if (result == MCV_OK) result = run_command(e, &command, rig, path, error);
        mcv_command_free(&command);
    }
    mcv_arguments_free(&arguments);
    return result;
}

static mcv_result run_verb(const experiment *e, const mcv_command *command, mcv_error *error) {
    return mcv_ends_in(command->argument, ".json")
               ? run_file(e, command, command->argument, error)
               : run_command(e, command, command->argument, command->argument, error);
}

mcv_result mcv_verb_sweep(const mcv_command *command, mcv_error *error) {
    static const experiment sweep = {"-sweep.csv", mcv_session_sweep};
    return run_verb(&sweep, command, error);
}

mcv_result mcv_verb_optimize(const mcv_command *command, mcv_error *error) {
    static const experiment optimize = {"-optimize.csv", mcv_session_optimize};
    return run_verb(&optimize, command, error);
}

mcv_result mcv_verb_uncertainty(const mcv_command *command, mcv_error *error) {
    static const experiment uncertainty = {"-uncertainty.csv", mcv_session_uncertainty};
    return run_verb(&uncertainty, command, error);
}
