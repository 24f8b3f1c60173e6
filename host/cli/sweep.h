/* SPDX-License-Identifier: Apache-2.0 */
/* The reports of `mcvisi sweep`. */
#ifndef MCVISI_HOST_CLI_SWEEP_H
#define MCVISI_HOST_CLI_SWEEP_H

#include "options/command.h"
#include "experiment/experiment.h"

/* Prints a row when it is appended: the call `row` of mcv_sweep_calls, whose user is the
 * mcv_command. Prints nothing with --json. */
void mcv_sweep_tell_row(void *user, const mcv_sweep *sweep, const double *row, const char *message);

/* Prints the result: the largest and smallest value of each metric, and the files. `spent`:
 * seconds. */
mcv_result mcv_sweep_report(const mcv_sweep *sweep, bool json, double spent, mcv_error *error);

#endif
