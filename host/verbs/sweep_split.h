/* SPDX-License-Identifier: Apache-2.0 */
/* What is told of a program's settings, tuned on some scenes and validated on others. */
#ifndef MCVISI_HOST_VERBS_SWEEP_SPLIT_H
#define MCVISI_HOST_VERBS_SWEEP_SPLIT_H

#include "experiment/split.h"

/* Adds "validation" to the report, where there is one: for each metric its settings. */
mcv_result mcv_sweep_split_json(const mcv_sweep *sweep, json_t *document, mcv_error *error);

/* For people: the setting that is best on the scenes of tuning, and what it reaches on both. */
mcv_result mcv_sweep_split_text(const mcv_sweep *sweep, FILE *out, mcv_error *error);

#endif
