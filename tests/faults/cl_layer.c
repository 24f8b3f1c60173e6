/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A layer of OpenCL (OPENCL_LAYERS of ocl-icd): fails the call MCV_CL_AT of the function
 * MCV_CL_FAULT, counted from 1, with the code MCV_CL_ERROR. MCV_CL_STAYS: that call and all calls
 * of every function but the releases from then on, as of a device that is lost. A release that
 * fails has released: what it would keep is no leak of the program.
 *
 * At the end it writes to MCV_CL_COUNT how often each function was called ("call NAME COUNT") and
 * how many references to each kind of object are left ("left KIND COUNT").
 */
#include "cl_layer.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Objects, and the functions that count them. */
#define KINDS(X) X(context) X(queue) X(memory) X(program) X(kernel) X(event)

/* name, parameters, arguments: neither make nor release an object */
#define PLAIN(X) \
    X(clGetPlatformIDs, (cl_uint n, cl_platform_id * out, cl_uint * count), (n, out, count)) \
    X(clGetPlatformInfo, \
      (cl_platform_id p, cl_platform_info i, size_t n, void *out, size_t *size), \
      (p, i, n, out, size)) \
    X(clGetDeviceIDs, \
      (cl_platform_id p, cl_device_type t, cl_uint n, cl_device_id * out, cl_uint * count), \
      (p, t, n, out, count)) \
    X(clGetDeviceInfo, (cl_device_id d, cl_device_info i, size_t n, void *out, size_t *size), \
      (d, i, n, out, size)) \
    X(clBuildProgram, \
      (cl_program p, cl_uint n, const cl_device_id *d, const char *o, \
       void(CL_CALLBACK * f)(cl_program, void *), void *u), \
      (p, n, d, o, f, u)) \
    X(clGetProgramInfo, (cl_program p, cl_program_info i, size_t n, void *out, size_t *size), \
      (p, i, n, out, size)) \
    X(clGetProgramBuildInfo, \
      (cl_program p, cl_device_id d, cl_program_build_info i, size_t n, void *out, size_t *size), \
      (p, d, i, n, out, size)) \
    X(clGetKernelInfo, (cl_kernel k, cl_kernel_info i, size_t n, void *out, size_t *size), \
      (k, i, n, out, size)) \
    X(clSetKernelArg, (cl_kernel k, cl_uint i, size_t n, const void *value), (k, i, n, value)) \
    X(clGetEventProfilingInfo, \
      (cl_event e, cl_profiling_info i, size_t n, void *out, size_t *size), (e, i, n, out, size)) \
    X(clWaitForEvents, (cl_uint n, const cl_event *e), (n, e)) \
    X(clFlush, (cl_command_queue q), (q)) \
    X(clFinish, (cl_command_queue q), (q))

#define WAIT cl_uint waits, const cl_event *wait, cl_event *event
#define WAITED waits, wait, event
/* name, parameters, arguments: may make an event */
#define ENQUEUE(X) \
    X(clEnqueueReadBuffer, \
      (cl_command_queue q, cl_mem m, cl_bool b, size_t at, size_t n, void *p, WAIT), \
      (q, m, b, at, n, p, WAITED)) \
    X(clEnqueueWriteBuffer, \
      (cl_command_queue q, cl_mem m, cl_bool b, size_t at, size_t n, const void *p, WAIT), \
      (q, m, b, at, n, p, WAITED)) \
    X(clEnqueueUnmapMemObject, (cl_command_queue q, cl_mem m, void *p, WAIT), (q, m, p, WAITED)) \
    X(clEnqueueNDRangeKernel, \
      (cl_command_queue q, cl_kernel k, cl_uint d, const size_t *o, const size_t *g, \
       const size_t *l, WAIT), \
      (q, k, d, o, g, l, WAITED))

/* kind, name, type, parameters, arguments: the last argument takes the code */
#define MAKE(X) \
    X(context, clCreateContext, cl_context, \
      (const cl_context_properties *o, cl_uint n, const cl_device_id *d, \
       void(CL_CALLBACK * f)(const char *, const void *, size_t, void *), void *u, cl_int *code), \
      (o, n, d, f, u, code)) \
    X(queue, clCreateCommandQueue, cl_command_queue, \
      (cl_context c, cl_device_id d, cl_command_queue_properties o, cl_int * code), \
      (c, d, o, code)) \
    X(memory, clCreateBuffer, cl_mem, \
      (cl_context c, cl_mem_flags f, size_t n, void *p, cl_int *code), (c, f, n, p, code)) \
    X(program, clCreateProgramWithSource, cl_program, \
      (cl_context c, cl_uint n, const char **text, const size_t *size, cl_int *code), \
      (c, n, text, size, code)) \
    X(program, clCreateProgramWithBinary, cl_program, \
      (cl_context c, cl_uint n, const cl_device_id *d, const size_t *size, \
       const unsigned char **bytes, cl_int *status, cl_int *code), \
      (c, n, d, size, bytes, status, code)) \
    X(kernel, clCreateKernel, cl_kernel, (cl_program p, const char *name, cl_int *code), \
      (p, name, code))

/* kind, name, type, what it adds to the count */
#define REFERENCES(X) \
    X(context, clRetainContext, cl_context, 1) \
    X(context, clReleaseContext, cl_context, -1) \
    X(queue, clReleaseCommandQueue, cl_command_queue, -1) \
    X(memory, clReleaseMemObject, cl_mem, -1) \
    X(program, clRetainProgram, cl_program, 1) \
    X(program, clReleaseProgram, cl_program, -1) \
    X(kernel, clReleaseKernel, cl_kernel, -1) \
    X(event, clReleaseEvent, cl_event, -1)

/* Of other shapes: clEnqueueFillBuffer, whose type in cl_icd.h says nothing, and
 * clEnqueueMapBuffer. */
#define PLAIN_NAME(name, parameters, arguments) {#name, 0},
#define MADE_NAME(kind, name, type, parameters, arguments) {#name, 0},
#define REFERENCE_NAME(kind, name, type, change) {#name, 0},
static struct {
    const char *name;
    atomic_long calls;
} functions[] = {PLAIN(PLAIN_NAME) ENQUEUE(PLAIN_NAME) MAKE(MADE_NAME) REFERENCES(REFERENCE_NAME) //
                 {"clEnqueueFillBuffer", 0},
                 {"clEnqueueMapBuffer", 0}};
enum { FUNCTIONS = sizeof functions / sizeof functions[0] };

#define KIND_INDEX(kind) KIND_##kind,
#define KIND_NAME(kind) #kind,
enum { KINDS(KIND_INDEX) KIND_COUNT };
static const char *const kind_names[] = {KINDS(KIND_NAME)};
static atomic_long left[KIND_COUNT];

static const struct _cl_icd_dispatch *next;
static struct _cl_icd_dispatch ours;
static const char *fault;
static long fault_at;
static cl_int code_of_fault;
static bool stays;
static atomic_bool lost;

/* Counts a call; its code, or CL_SUCCESS where it does not fail. */
static cl_int called(const char *name) {
    const bool releases = strncmp(name, "clRelease", 9) == 0;
    for (int i = 0; i < FUNCTIONS; ++i) {
        if (strcmp(functions[i].name, name) != 0) continue;
        const long count = atomic_fetch_add(&functions[i].calls, 1) + 1;
        const bool hit = fault && count == fault_at && strcmp(fault, name) == 0;
        if (hit && stays) atomic_store(&lost, true);
        if (hit || (atomic_load(&lost) && !releases)) return code_of_fault;
    }
    return CL_SUCCESS;
}

#define PLAIN_FUNCTION(name, parameters, arguments) \
    static cl_int CL_API_CALL layer_##name parameters { \
        const cl_int failed = called(#name); \
        return failed != CL_SUCCESS ? failed : next->name arguments; \
    }
PLAIN(PLAIN_FUNCTION)

static cl_int enqueued(cl_int code, const cl_event *event) {
    if (code == CL_SUCCESS && event) ++left[KIND_event];
    return code;
}

#define ENQUEUE_FUNCTION(name, parameters, arguments) \
    static cl_int CL_API_CALL layer_##name parameters { \
        const cl_int failed = called(#name); \
        return failed != CL_SUCCESS ? failed : enqueued(next->name arguments, event); \
    }
ENQUEUE(ENQUEUE_FUNCTION)

#define MAKE_FUNCTION(kind, name, type, parameters, arguments) \
    static type CL_API_CALL layer_##name parameters { \
        const cl_int failed = called(#name); \
        if (failed != CL_SUCCESS) { \
            if (code) *code = failed; \
            return NULL; \
        } \
        type made = next->name arguments; \
        if (made) ++left[KIND_##kind]; \
        return made; \
    }
MAKE(MAKE_FUNCTION)

#define REFERENCE_FUNCTION(kind, name, type, change) \
    static cl_int CL_API_CALL layer_##name(type object) { \
        const cl_int failed = called(#name); \
        if (failed != CL_SUCCESS && (change) > 0) return failed; \
        const cl_int code = next->name(object); \
        if (code == CL_SUCCESS) left[KIND_##kind] += (change); \
        return failed != CL_SUCCESS ? failed : code; \
    }
REFERENCES(REFERENCE_FUNCTION)

static cl_int CL_API_CALL layer_clEnqueueFillBuffer(cl_command_queue q, cl_mem m, const void *p,
                                                    size_t width, size_t offset, size_t n, WAIT) {
    typedef cl_int(CL_API_CALL * fill)(cl_command_queue, cl_mem, const void *, size_t, size_t,
                                       size_t, cl_uint, const cl_event *, cl_event *);
    const cl_int failed = called("clEnqueueFillBuffer");
    if (failed != CL_SUCCESS) return failed;
    return enqueued(((fill)next->clEnqueueFillBuffer)(q, m, p, width, offset, n, WAITED), event);
}

static void *CL_API_CALL layer_clEnqueueMapBuffer(cl_command_queue q, cl_mem m, cl_bool b,
                                                  cl_map_flags f, size_t offset, size_t n, WAIT,
                                                  cl_int *code) {
    const cl_int failed = called("clEnqueueMapBuffer");
    if (failed != CL_SUCCESS) {
        if (code) *code = failed;
        return NULL;
    }
    return next->clEnqueueMapBuffer(q, m, b, f, offset, n, WAITED, code);
}

static long number_of(const char *variable, long otherwise) {
    const char *text = getenv(variable);
    return text ? strtol(text, NULL, 10) : otherwise;
}

const struct _cl_icd_dispatch *layer_begin(const struct _cl_icd_dispatch *target) {
    fault = getenv("MCV_CL_FAULT");
    fault_at = number_of("MCV_CL_AT", 0);
    code_of_fault = (cl_int)number_of("MCV_CL_ERROR", CL_OUT_OF_RESOURCES);
    stays = getenv("MCV_CL_STAYS") != NULL;
    next = target;
    ours = *target;
#define PLAIN_ENTRY(name, parameters, arguments) ours.name = layer_##name;
#define MAKE_ENTRY(kind, name, type, parameters, arguments) ours.name = layer_##name;
#define REFERENCE_ENTRY(kind, name, type, change) ours.name = layer_##name;
    PLAIN(PLAIN_ENTRY)
    ENQUEUE(PLAIN_ENTRY)
    MAKE(MAKE_ENTRY)
    REFERENCES(REFERENCE_ENTRY)
    ours.clEnqueueFillBuffer = (void *)layer_clEnqueueFillBuffer;
    ours.clEnqueueMapBuffer = layer_clEnqueueMapBuffer;
    return &ours;
}

__attribute__((destructor)) static void finish(void) {
    const char *path = getenv("MCV_CL_COUNT");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) return;
    for (int i = 0; i < FUNCTIONS; ++i)
        if (functions[i].calls > 0)
            fprintf(file, "call %s %ld\n", functions[i].name, functions[i].calls);
    for (int i = 0; i < KIND_COUNT; ++i) fprintf(file, "left %s %ld\n", kind_names[i], left[i]);
    fclose(file);
}
