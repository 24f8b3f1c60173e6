/* SPDX-License-Identifier: Apache-2.0 */
/* The flattened OpenCL programs that the build puts into the library (kernels/<name>.cl). */
#ifndef MCVISI_HOST_CL_PROGRAMS_H
#define MCVISI_HOST_CL_PROGRAMS_H

#include <stddef.h>

typedef struct mcv_program {
    const char *name, *source;
} mcv_program;

extern const mcv_program mcv_programs[];
extern const size_t mcv_program_count;

#endif
