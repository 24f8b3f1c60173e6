/* SPDX-License-Identifier: Apache-2.0 */
#include "cl/program_cache.h"

#include "cl/pocl_cache.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { CACHED_PROGRAMS = 4 };

typedef struct cached_program {
    const char *source; /* the library's own text */
    char options[MCV_MAX_BUILD_OPTIONS];
    cl_program program;
} cached_program;

static struct {
    pthread_mutex_t lock;
    cl_device_id device;
    cl_context context;
    cached_program programs[CACHED_PROGRAMS];
    unsigned next;
} cache = {.lock = PTHREAD_MUTEX_INITIALIZER};

static void forget_device(void) {
    for (int i = 0; i < CACHED_PROGRAMS; ++i) {
        if (cache.programs[i].program) clReleaseProgram(cache.programs[i].program);
        cache.programs[i].program = NULL;
    }
    if (cache.context) clReleaseContext(cache.context);
    cache.context = NULL;
}

cl_context mcv_cached_context(cl_device_id device, cl_int *code) {
    *code = CL_SUCCESS;
    pthread_mutex_lock(&cache.lock);
    if (cache.device != device) forget_device();
    if (!cache.context) {
        mcv_pocl_mend(); /* once for each device: the driver reads its files from here on */
        cache.context = clCreateContext(NULL, 1, &device, NULL, NULL, code);
    }
    cache.device = device;
    cl_context context = cache.context;
    if (context && (*code = clRetainContext(context)) != CL_SUCCESS) context = NULL;
    pthread_mutex_unlock(&cache.lock);
    return context;
}

cl_program mcv_cached_program(cl_context context, const char *source, const char *options) {
    cl_program found = NULL;
    pthread_mutex_lock(&cache.lock);
    for (int i = 0; i < CACHED_PROGRAMS && context == cache.context && !found; ++i) {
        const cached_program *k = &cache.programs[i];
        if (k->program && k->source == source && strcmp(k->options, options) == 0)
            found = k->program;
    }
    if (found && clRetainProgram(found) != CL_SUCCESS) found = NULL;
    pthread_mutex_unlock(&cache.lock);
    return found;
}

void mcv_keep_program(cl_context context, const char *source, const char *options,
                      cl_program program) {
    pthread_mutex_lock(&cache.lock);
    if (context == cache.context && clRetainProgram(program) == CL_SUCCESS) {
        cached_program *k = &cache.programs[cache.next++ % CACHED_PROGRAMS];
        if (k->program) clReleaseProgram(k->program);
        k->program = program;
        k->source = source;
        snprintf(k->options, sizeof k->options, "%s", options);
    }
    pthread_mutex_unlock(&cache.lock);
}
