/* SPDX-License-Identifier: Apache-2.0 */
/*
 * OpenCL on the host: devices, programs, buffers, launches. Every error message names the call, the
 * OpenCL error and, for programs, the build log.
 */
#ifndef MCVISI_HOST_CL_CL_H
#define MCVISI_HOST_CL_CL_H

#define CL_USE_DEPRECATED_OPENCL_1_2_APIS
#include <CL/cl.h>

#include "core/error.h"

typedef struct mcv_cl {
    cl_platform_id platform;
    cl_device_id device;
    cl_context context;
    cl_command_queue queue; /* in order */
    char name[256];         /* "platform: device" */
    char
        version[256]; /* driver and device version, part of cache keys and of the output's header */
    bool cpu;
    bool correct_divide_sqrt; /* -cl-fp32-correctly-rounded-divide-sqrt is supported */
    cl_ulong memory, largest_allocation;
    cl_uint units;
    bool probed; /* the device has passed the probe */
} mcv_cl;

/*
 * Opens a device. `which` is NULL (a GPU if there is one, else the first device), a number of
 * `mcvisi devices`, or "PLATFORM:TYPE:NAME" with case-insensitive substrings (TYPE cpu, gpu or
 * empty). The environment variable MCVISI_OPENCL_DEVICE replaces NULL.
 */
mcv_result mcv_cl_open(const char *which, mcv_cl *cl, mcv_error *error);

/* Its two steps: which device it is; its context and queue. */
mcv_result mcv_cl_find(const char *which, mcv_cl *cl, mcv_error *error);
mcv_result mcv_cl_start(mcv_cl *cl, mcv_error *error);

enum { MCV_MOST_DEVICES = 16 };

/* Finds the devices of a list "A,B" of such names. MCV_DEVICE for a name without a device, and for
 * a device that is named twice. */
mcv_result mcv_cl_find_all(const char *which, mcv_cl devices[MCV_MOST_DEVICES], uint32_t *count,
                           mcv_error *error);
void mcv_cl_close(mcv_cl *cl);

/* Calls told(user, index, text) for each device, in the order of their numbers. */
mcv_result mcv_cl_list(void (*told)(void *user, unsigned index, const mcv_cl *device), void *user,
                       mcv_error *error);

/*
 * Builds kernels/<name>.cl with the given -D options (such as "-DMCV_CHANNELS=1
 * -DMCV_SENSOR_telecentric"). The source is in the library; if MCVISI_KERNEL_DIR names the root of
 * the repository, the files there are used. With the first program the device is probed; one
 * without correct fma, IEEE division and square root, or denormals is refused.
 */
mcv_result mcv_cl_build(mcv_cl *cl, const char *name, const char *options, cl_program *program,
                        mcv_error *error);
mcv_result mcv_cl_kernel(cl_program program, const char *name, cl_kernel *kernel, mcv_error *error);

/* Makes a buffer of at least 16 bytes. data may be NULL; `what` is its name in messages ("the nodes
 * of the acceleration structure"). */
mcv_result mcv_cl_buffer(mcv_cl *cl, const char *what, size_t bytes, const void *data,
                         cl_mem *buffer, mcv_error *error);
mcv_result mcv_cl_read(mcv_cl *cl, cl_mem buffer, size_t offset, size_t bytes, void *data,
                       mcv_error *error); /* waits */
mcv_result mcv_cl_write(mcv_cl *cl, cl_mem buffer, size_t offset, size_t bytes, const void *data,
                        mcv_error *error); /* waits */
mcv_result mcv_cl_finish(mcv_cl *cl, mcv_error *error);
/* Fills the first `bytes`, a multiple of 4, with zeros, without waiting. */
mcv_result mcv_cl_clear(mcv_cl *cl, cl_mem buffer, size_t bytes, mcv_error *error);
void mcv_cl_release(cl_mem *buffer); /* NULL is fine; nulls it */

/* A kernel argument: MCV_ARG(x) takes any lvalue (cl_mem, cl_uint, a struct). */
typedef struct mcv_arg {
    size_t size;
    const void *value;
} mcv_arg;
#define MCV_ARG(x) ((mcv_arg){sizeof(x), &(x)})

/*
 * Enqueues a one-dimensional launch without waiting; global is rounded up to a multiple of local.
 * If `event` is not NULL, the caller owns *event; mcv_cl_seconds gives the launch's time.
 */
mcv_result mcv_cl_launch(mcv_cl *cl, cl_kernel kernel, size_t global, size_t local,
                         const mcv_arg *arguments, size_t count, cl_event *event, mcv_error *error);
#define MCV_LAUNCH(cl, kernel, global, local, error, ...) \
    mcv_cl_launch((cl), (kernel), (global), (local), (const mcv_arg[]){__VA_ARGS__}, \
                  sizeof((const mcv_arg[]){__VA_ARGS__}) / sizeof(mcv_arg), NULL, (error))

/* The seconds that a finished launch took on the device. Releases the event. */
double mcv_cl_seconds(cl_event event);

/* "CL_OUT_OF_RESOURCES" for -5, and so on. */
const char *mcv_cl_error_name(cl_int code);

/* MCV_DEVICE with a sentence unless the code of an OpenCL call is CL_SUCCESS; `what` is what it did
 * ("reading from the device"). */
mcv_result mcv_cl_check(const mcv_cl *cl, cl_int code, const char *what, mcv_error *error);

#endif
