/* SPDX-License-Identifier: Apache-2.0 */
/* The experiment of `mcvisi sweep` by its options, and what is told of it. */
#ifndef MCVISI_HOST_VERBS_SWEEP_H
#define MCVISI_HOST_VERBS_SWEEP_H

#include "experiment/experiment.h"
#include "options/command.h"

/* The experiment that the options tell, without a scene, files, settings and calls. Texts are the
 * command's. */
mcv_result mcv_sweep_experiment(const mcv_command *command, mcv_experiment *experiment,
                                mcv_error *error);

/* "I/N" with I below N, of at most a million parts: I and N. False if the text is none. */
bool mcv_read_share(const char *text, size_t share[2]);

/* What stands beside the scene in the experiment's file; NULL without memory. */
json_t *mcv_sweep_settings(const mcv_command *command);

/* What the reports of all experiments begin with: files, rows, seconds, fingerprint. NULL without
 * memory. */
json_t *mcv_sweep_json_head(const mcv_sweep *sweep, double spent);

/* The whole in the end, on one line; the caller frees it. `spent`: seconds. */
mcv_result mcv_sweep_json(const mcv_sweep *sweep, double spent, char **text, mcv_error *error);

/* A row as it is appended, as the public header describes it; NULL without memory. */
char *mcv_sweep_row_json(const mcv_sweep *sweep, const double *row, const char *message);

/* The same for people: where each metric is largest and smallest, and the files; a row, a line. */
mcv_result mcv_sweep_text(const mcv_sweep *sweep, double spent, char **text, mcv_error *error);
char *mcv_sweep_row_text(const mcv_sweep *sweep, const double *row, const char *message);

#endif
