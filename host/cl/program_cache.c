/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/program_cache.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { KEPT_PROGRAMS = 4 };

typedef struct kept_program {
    const char *source; /* the library's own text */
    char options[MCV_MAX_BUILD_OPTIONS];
    cl_program program;
} kept_program;

static struct {
    pthread_mutex_t lock;
    cl_device_id device;
    cl_context context;
    kept_program programs[KEPT_PROGRAMS];
    unsigned next;
} kept = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void forget_device(void) {
    for (int i = 0; i < KEPT_PROGRAMS; ++i) {
        if (kept.programs[i].program) clReleaseProgram(kept.programs[i].program);
        kept.programs[i].program = NULL;
    }
    if (kept.context) clReleaseContext(kept.context);
    kept.context = NULL;
}

cl_context mcv_kept_context(cl_device_id device, cl_int *code) {
    *code = CL_SUCCESS;
    pthread_mutex_lock(&kept.lock);
    if (kept.device != device) forget_device();
    if (!kept.context) kept.context = clCreateContext(NULL, 1, &device, NULL, NULL, code);
    kept.device = device;
    cl_context context = kept.context;
    if (context) clRetainContext(context);
    pthread_mutex_unlock(&kept.lock);
    return context;
}

cl_program mcv_kept_program(cl_context context, const char *source, const char *options) {
    cl_program found = NULL;
    pthread_mutex_lock(&kept.lock);
    for (int i = 0; i < KEPT_PROGRAMS && context == kept.context && !found; ++i) {
        const kept_program *k = &kept.programs[i];
        if (k->program && k->source == source && strcmp(k->options, options) == 0)
            found = k->program;
    }
    if (found) clRetainProgram(found);
    pthread_mutex_unlock(&kept.lock);
    return found;
}

void mcv_keep_program(cl_context context, const char *source, const char *options,
                      cl_program program) {
    pthread_mutex_lock(&kept.lock);
    if (context == kept.context) {
        kept_program *k = &kept.programs[kept.next++ % KEPT_PROGRAMS];
        if (k->program) clReleaseProgram(k->program);
        clRetainProgram(program);
        k->program = program;
        k->source = source;
        snprintf(k->options, sizeof k->options, "%s", options);
    }
    pthread_mutex_unlock(&kept.lock);
}
