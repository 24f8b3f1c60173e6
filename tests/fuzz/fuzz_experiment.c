/* SPDX-License-Identifier: Apache-2.0 */
/* Experiments of sweep, uncertainty and optimize, by the first byte: planned up to their first
 * render, or through 100 sets that have none. Nothing is written, and no program is run. */
#include "fuzz.h"

#include "loader/load.h"
#include "verbs/optimize.h"
#include "verbs/sweep.h"
#include "verbs/uncertainty.h"

/* An input asks for up to 100 000 sets, and one after the other may be refused. */
static int sets_left;

static mcv_result go_on(void *user) {
    (void)user;
    return --sets_left > 0 ? MCV_OK : MCV_INTERRUPTED;
}

static mcv_result stop(const mcv_scene *scene, uint32_t sensor, const mcv_render_options *options,
                       mcv_film *film, mcv_render_stats *stats, mcv_error *error) {
    (void)scene, (void)sensor, (void)options, (void)stats;
    memset(film, 0, sizeof *film);
    sets_left = 0;
    return mcv_fail(error, MCV_INTERRUPTED, "stopped");
}

static mcv_result plan_sweep(const mcv_command *command, const mcv_experiment *experiment,
                             mcv_error *error) {
    mcv_sweep sweep;
    (void)command;
    mcv_result result = mcv_experiment_plan(experiment, &sweep, error);
    if (result == MCV_OK) result = mcv_experiment_open_table(&sweep, error);
    if (result == MCV_OK) result = mcv_experiment_run(&sweep, error);
    mcv_experiment_free(&sweep);
    return result;
}

static mcv_result plan_study(const mcv_command *command, const mcv_experiment *experiment,
                             mcv_error *error) {
    const mcv_study_asked asked = mcv_uncertainty_asked(command, experiment);
    mcv_study study;
    const mcv_result result = mcv_study_run(&asked, &study, error);
    mcv_study_free(&study);
    return result;
}

static mcv_result plan_search(const mcv_command *command, const mcv_experiment *experiment,
                              mcv_error *error) {
    const mcv_optimization_asked asked = mcv_optimize_asked(command, experiment);
    mcv_optimization optimization;
    const mcv_result result = mcv_optimization_run(&asked, &optimization, error);
    mcv_optimization_free(&optimization);
    return result;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const struct {
        unsigned verb;
        mcv_result (*plan)(const mcv_command *, const mcv_experiment *, mcv_error *);
    } verbs[] = {{MCV_VERB_SWEEP, plan_sweep},
                 {MCV_VERB_UNCERTAINTY, plan_study},
                 {MCV_VERB_OPTIMIZE, plan_search}};
    static const char *const without[] = {"images", "output", "allow-exec", NULL};
    static const char *const arguments[2] = {"scene.gltf", NULL};
    static mcv_document document;
    mcv_options_given given;
    mcv_experiment experiment;
    mcv_error error = {""};
    if (size < 1) return 0;
    if (!document.root && mcv_document_read(MCV_SOURCE_DIR "/scenes/telecentric-edge.gltf",
                                            &document, &error) != MCV_OK)
        abort();
    const unsigned kind = data[0] % 3;
    char *text = calloc(1, size);
    if (!text) return 0;
    memcpy(text, data + 1, size - 1);
    mcv_result result =
        mcv_options_read(text, NULL, verbs[kind].verb, arguments, without, &given, &error);
    free(text);
    fuzz_sentence(result, &error);
    if (result != MCV_OK) return 0;
    result = mcv_sweep_experiment(&given.command, &experiment, &error);
    if (result == MCV_OK) {
        experiment.rig = document.path;
        experiment.document = &document;
        experiment.memory = 200000000;
        experiment.render_with = stop;
        experiment.calls.interrupted = go_on;
        sets_left = 100;
        result = verbs[kind].plan(&given.command, &experiment, &error);
    }
    fuzz_sentence(result, &error);
    mcv_options_free(&given);
    return 0;
}
