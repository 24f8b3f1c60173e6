/* SPDX-License-Identifier: Apache-2.0 */
/* Parallel loops of independent steps. */
#ifndef MCVISI_HOST_CORE_PARALLEL_H
#define MCVISI_HOST_CORE_PARALLEL_H

#include <stddef.h>

/*
 * Calls work(user, i) once for each i = 0 … count - 1, in any order, from one thread per core, or
 * from fewer if not all can be started. The calls must write to separate places, so that the result
 * does not depend on the threads.
 */
void mcv_in_parallel(size_t count, void (*work)(void *user, size_t i), void *user);

#endif
