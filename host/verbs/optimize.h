/* SPDX-License-Identifier: Apache-2.0 */
/* The optimisation of `mcvisi optimize` by its options, and what is told of it. */
#ifndef MCVISI_HOST_VERBS_OPTIMIZE_H
#define MCVISI_HOST_VERBS_OPTIMIZE_H

#include "optimize/study.h"
#include "options/command.h"

/* The optimisation that the options tell, on an experiment that they have set up. Texts are the
 * command's. */
mcv_optimization_asked mcv_optimize_asked(const mcv_command *command,
                                          const mcv_experiment *experiment);

/* The whole in the end: JSON on one line, in SI units; or for people. The caller frees it. `spent`:
 * seconds. */
mcv_result mcv_optimize_json(const mcv_optimization *o, double spent, char **text,
                             mcv_error *error);
mcv_result mcv_optimize_text(const mcv_optimization *o, double spent, char **text,
                             mcv_error *error);

#endif
