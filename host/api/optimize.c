/* SPDX-License-Identifier: Apache-2.0 */
/* Optimisation of the public interface. */
#include "api/experiments.h"
#include "core/basics.h"
#include "verbs/optimize.h"

static mcv_result run_search(const mcv_experiment *experiment, const mcv_command *command,
                             char **report, mcv_error *error) {
    const mcv_optimization_asked asked = mcv_optimize_asked(command, experiment);
    const double begun = mcv_seconds();
    mcv_optimization o;
    mcv_result result = mcv_optimization_run(&asked, &o, error);
    if (result == MCV_OK && report)
        result = (command->json ? mcv_optimize_json : mcv_optimize_text)(&o, mcv_seconds() - begun,
                                                                         report, error);
    mcv_optimization_free(&o);
    return result;
}

mcv_result mcv_session_optimize(mcv_session *session, const mcv_rig *rig, const char *options,
                                mcv_told_call *told, void *user, char **report, mcv_error *error) {
    return mcv_session_experiment(session, rig, MCV_VERB_OPTIMIZE, options, run_search, told, user,
                                  report, error);
}
