/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the process keeps, for all threads, of the device that was opened last. The context: PoCL
 * reads its library of built-in functions, for half a second, once per context that compiles. The
 * latest programs: even one that a driver has on disk takes 40 ms.
 */
#ifndef MCVISI_HOST_CL_PROGRAM_CACHE_H
#define MCVISI_HOST_CL_PROGRAM_CACHE_H

#include <CL/cl.h>

enum { MCV_MAX_BUILD_OPTIONS = 2048 };

/* The device's context, which the caller releases; NULL with an error code if there is none. */
cl_context mcv_cached_context(cl_device_id device, cl_int *code);

/* The program with this text and these options, which the caller releases; NULL if it is not
 * cached. `source` must exist as long as the process. */
cl_program mcv_cached_program(cl_context context, const char *source, const char *options);
void mcv_keep_program(cl_context context, const char *source, const char *options,
                      cl_program program);

#endif
