/* SPDX-License-Identifier: Apache-2.0 */
/* Uncertainties of the public interface. */
#include "api/experiments.h"
#include "core/basics.h"
#include "verbs/uncertainty.h"

static mcv_result run_study(const mcv_experiment *experiment, const mcv_command *command,
                            char **report, mcv_error *error) {
    const mcv_study_asked asked = mcv_uncertainty_asked(command, experiment);
    const double begun = mcv_seconds();
    mcv_study study;
    mcv_result result = mcv_study_run(&asked, &study, error);
    if (result == MCV_OK && report)
        result = (command->json ? mcv_uncertainty_json : mcv_uncertainty_text)(
            &study, mcv_seconds() - begun, report, error);
    if (result == MCV_OK) result = mcv_experiment_finished(&study.sweep, error);
    mcv_study_free(&study);
    return result;
}

mcv_result mcv_session_uncertainty(mcv_session *session, const mcv_rig *rig, const char *options,
                                   mcv_told_call *told, void *user, char **report,
                                   mcv_error *error) {
    return mcv_session_experiment(session, rig, MCV_VERB_UNCERTAINTY, options, run_study, told,
                                  user, report, error);
}
