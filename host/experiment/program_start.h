/* SPDX-License-Identifier: Apache-2.0 */
/* The process of a program (experiment/program.h). */
#ifndef MCVISI_HOST_EXPERIMENT_PROGRAM_START_H
#define MCVISI_HOST_EXPERIMENT_PROGRAM_START_H

#include "experiment/program.h"

/* Starts it. MCV_FAILED with what follows its name in a sentence. */
mcv_result mcv_program_start(mcv_program *program, mcv_error *error);

/* Kills its process group, if it runs, and closes our ends. */
void mcv_program_stop(mcv_program *program);

#endif
