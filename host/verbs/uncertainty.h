/* SPDX-License-Identifier: Apache-2.0 */
/* The study of `mcvisi uncertainty` by its options, and what is told of it. */
#ifndef MCVISI_HOST_VERBS_UNCERTAINTY_H
#define MCVISI_HOST_VERBS_UNCERTAINTY_H

#include "options/command.h"
#include "uncertainty/study.h"

/* The study that the options tell, on an experiment that they have set up. Texts are the
 * command's. */
mcv_study_asked mcv_uncertainty_asked(const mcv_command *command, const mcv_experiment *experiment);

/* The whole in the end: JSON on one line, in SI units; or for people. The caller frees it. `spent`:
 * seconds. */
mcv_result mcv_uncertainty_json(const mcv_study *study, double spent, char **text,
                                mcv_error *error);
mcv_result mcv_uncertainty_text(const mcv_study *study, double spent, char **text,
                                mcv_error *error);

#endif
