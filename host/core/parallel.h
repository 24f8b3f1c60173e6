/* SPDX-License-Identifier: Apache-2.0 */
/* Loops of independent steps on all cores. */
#ifndef MCVISI_HOST_CORE_PARALLEL_H
#define MCVISI_HOST_CORE_PARALLEL_H

#include <stddef.h>

/*
 * Calls work(user, i) once for each i = 0 … count - 1, in any order, from as many threads as there
 * are cores; fewer where no more start. The calls must write to places apart, so that the outcome
 * does not depend on the threads.
 */
void mcv_in_parallel(size_t count, void (*work)(void *user, size_t i), void *user);

#endif
