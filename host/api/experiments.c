/* SPDX-License-Identifier: Apache-2.0 */
/* Experiments of the public interface: sweeps and what else renders many sets. */
#include "api/experiments.h"

#include "core/basics.h"
#include "core/json.h"
#include "verbs/sweep.h"

#include <stdlib.h>

/* A sweep while it runs, for its callback. */
typedef struct running {
    mcv_told_call *call;
    void *user;
    locale_t host;
    double told; /* when it was last asked whether to go on */
    bool stopped, json;
} running;

static void ask(running *r, const char *report) {
    r->told = mcv_seconds();
    mcv_border_leave(r->host);
    r->stopped = !r->call(r->user, report) || r->stopped;
    r->host = mcv_border_enter();
}

static void tell_row(void *user, const mcv_sweep *sweep, const double *row, const char *message) {
    running *r = user;
    char *text = (r->json ? mcv_sweep_row_json : mcv_sweep_row_text)(sweep, row, message);
    if (text) ask(r, text);
    free(text);
}

static void warn(void *user, const char *sentence) {
    running *r = user;
    mcv_report report;
    mcv_error none = {""};
    char *text = NULL;
    if (mcv_report_keep(&report, r->json, &none) != MCV_OK) return;
    mcv_report_tell(&report, "warning", sentence);
    if (mcv_report_take(&report, &text, &none) == MCV_OK) ask(r, text);
    free(text);
}

static mcv_result interrupted(void *user) {
    running *r = user;
    if (!r->stopped && mcv_seconds() - r->told > 0.1) ask(r, NULL);
    return r->stopped ? MCV_INTERRUPTED : MCV_OK;
}

mcv_result mcv_experiment_finished(const mcv_sweep *s, mcv_error *error) {
    const size_t failed = mcv_table_failed(&s->table);
    return failed > 0 && failed == s->table.row_count
               ? mcv_fail(error, MCV_FAILED, "all %zu sets failed, the first one: %s", failed,
                          s->table.messages[0])
               : MCV_OK;
}

static mcv_result run_sweep(const mcv_experiment *experiment, const mcv_command *command,
                            char **report, mcv_error *error) {
    const double begun = mcv_seconds();
    mcv_sweep s;
    mcv_result result = mcv_experiment_plan(experiment, &s, error);
    if (result == MCV_OK) result = mcv_experiment_open_table(&s, error);
    if (result == MCV_OK) result = mcv_experiment_run(&s, error);
    if (result == MCV_OK && report)
        result = (command->json ? mcv_sweep_json : mcv_sweep_text)(&s, mcv_seconds() - begun,
                                                                   report, error);
    if (result == MCV_OK) result = mcv_experiment_finished(&s, error);
    mcv_experiment_free(&s);
    return result;
}

/* What was changed in the rig belongs to the experiment: with the file it gives the same scene. */
static json_t *make_settings(const mcv_command *command, const mcv_rig *rig) {
    const mcv_overrides changes = mcv_rig_changes(rig);
    json_t *settings = mcv_sweep_settings(command), *set = json_array();
    const json_t *more = json_object_get(settings, "set");
    bool whole = set != NULL;
    for (size_t i = 0; i < changes.count; ++i)
        whole = json_array_append_new(set, json_string(changes.items[i])) == 0 && whole;
    if (more) whole = json_array_extend(set, (json_t *)more) == 0 && whole;
    if (!whole || json_array_size(set) > 0)
        mcv_json_put(&settings, "set", whole ? json_incref(set) : NULL);
    json_decref(set);
    return settings;
}

static mcv_result run_rig(mcv_session *session, const mcv_rig *rig, const mcv_command *command,
                          mcv_experiment_work *work, running *r, char **report, mcv_error *error) {
    mcv_experiment experiment;
    MCV_TRY(mcv_sweep_experiment(command, &experiment, error));
    if (!experiment.render_with)
        MCV_TRY(mcv_session_renderer(session, command->device, &experiment.renderer, error));
    experiment.rig = rig->document.path;
    experiment.document = &rig->document;
    experiment.assets = session->assets;
    experiment.memory = (uint64_t)command->memory;
    experiment.table = command->table;
    experiment.settings = make_settings(command, rig);
    if (!experiment.settings) return mcv_fail(error, MCV_FAILED, "no memory for the experiment");
    if (r->call)
        experiment.calls = (mcv_sweep_calls){
            .warning = warn, .row = tell_row, .interrupted = interrupted, .user = r};
    const mcv_result result = work(&experiment, command, report, error);
    json_decref(experiment.settings);
    return result;
}

static mcv_result run_options(mcv_session *session, const mcv_rig *rig, unsigned verb,
                              const char *options, mcv_experiment_work *work, running *r,
                              char **report, mcv_error *error) {
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, session->defaults, verb, arguments, NULL, &given, error));
    r->json = given.command.json;
    const mcv_result result = run_rig(session, rig, &given.command, work, r, report, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_session_experiment(mcv_session *session, const mcv_rig *rig, unsigned verb,
                                  const char *options, mcv_experiment_work *work,
                                  mcv_told_call *told, void *user, char **report,
                                  mcv_error *error) {
    if (report) *report = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    MCV_TRY(mcv_session_begin(session, error));
    running r = {.call = told, .user = user, .told = mcv_seconds()};
    r.host = mcv_border_enter();
    const mcv_result result = run_options(session, rig, verb, options, work, &r, report, error);
    mcv_border_leave(r.host);
    mcv_session_end(session);
    return result;
}

mcv_result mcv_session_sweep(mcv_session *session, const mcv_rig *rig, const char *options,
                             mcv_told_call *told, void *user, char **report, mcv_error *error) {
    return mcv_session_experiment(session, rig, MCV_VERB_SWEEP, options, run_sweep, told, user,
                                  report, error);
}
