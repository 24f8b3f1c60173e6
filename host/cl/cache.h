/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compiled programs in $XDG_CACHE_HOME/mcvisi (or ~/.cache/mcvisi), for OpenCL drivers without a
 * cache. The key hashes source, options, device and driver. If the cache fails, programs are
 * compiled again.
 */
#ifndef MCVISI_HOST_CL_CACHE_H
#define MCVISI_HOST_CL_CACHE_H

#include "cl/cl.h"

/* True: *program is built from a stored binary. */
bool mcv_cache_load(mcv_cl *cl, const char *source, const char *options, cl_program *program);
void mcv_cache_store(mcv_cl *cl, const char *source, const char *options, cl_program program);

#endif
