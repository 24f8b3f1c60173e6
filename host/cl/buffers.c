/* SPDX-License-Identifier: Apache-2.0 */
/* Buffers and launches. */
#include "cl/cl.h"

#include <stdint.h>
#include <stdio.h>
#include <sys/mman.h>

/*
 * Asks the system for large pages before a buffer is first touched. A hierarchy of 140 MB has 35
 * 000 small pages, and every random ray waits for their page tables. It has no effect if the device
 * keeps its buffers elsewhere.
 */
static void prefer_large_pages(mcv_cl *cl, cl_mem buffer, size_t size) {
    const uintptr_t page = (uintptr_t)2 << 20;
    if (!cl->cpu || size < 2 * page) return;
    char *start =
        clEnqueueMapBuffer(cl->queue, buffer, CL_TRUE, CL_MAP_WRITE, 0, size, 0, NULL, NULL, NULL);
    if (!start) return;
    const uintptr_t first = ((uintptr_t)start + page - 1) / page * page,
                    last = ((uintptr_t)start + size) / page * page;
    madvise((void *)first, last - first, MADV_HUGEPAGE);
    clEnqueueUnmapMemObject(cl->queue, buffer, start, 0, NULL, NULL);
}

mcv_result mcv_cl_check(const mcv_cl *cl, cl_int code, const char *what, mcv_error *error) {
    if (code == CL_SUCCESS) return MCV_OK;
    return mcv_fail(error, MCV_DEVICE,
                    "%s failed on %s with %s: try again, or take another device (`mcvisi devices`)",
                    what, cl->name, mcv_cl_error_name(code));
}

mcv_result mcv_cl_buffer(mcv_cl *cl, const char *what, size_t bytes, const void *data,
                         cl_mem *buffer, mcv_error *error) {
    const size_t size = bytes < 16 ? 16 : bytes;
    cl_int code;
    *buffer = NULL;
    if (size > cl->largest_allocation) {
        return mcv_fail(error, MCV_DEVICE,
                        "%s: %.1f MiB needed, but %s allows %.1f MiB in one buffer", what,
                        (double)size / 0x1p20, cl->name, (double)cl->largest_allocation / 0x1p20);
    }
    *buffer = clCreateBuffer(cl->context, CL_MEM_READ_WRITE, size, NULL, &code);
    if (code == CL_SUCCESS) prefer_large_pages(cl, *buffer, size);
    if (code == CL_SUCCESS && data && bytes > 0)
        code = clEnqueueWriteBuffer(cl->queue, *buffer, CL_TRUE, 0, bytes, data, 0, NULL, NULL);
    if (code == CL_SUCCESS) return MCV_OK;
    mcv_cl_release(buffer);
    return mcv_fail(error, MCV_DEVICE, "%s: a buffer of %.1f MiB on %s failed with %s", what,
                    (double)size / 0x1p20, cl->name, mcv_cl_error_name(code));
}

mcv_result mcv_cl_read(mcv_cl *cl, cl_mem buffer, size_t offset, size_t bytes, void *data,
                       mcv_error *error) {
    if (bytes == 0) return MCV_OK;
    return mcv_cl_check(
        cl, clEnqueueReadBuffer(cl->queue, buffer, CL_TRUE, offset, bytes, data, 0, NULL, NULL),
        "reading from the device", error);
}

mcv_result mcv_cl_write(mcv_cl *cl, cl_mem buffer, size_t offset, size_t bytes, const void *data,
                        mcv_error *error) {
    if (bytes == 0) return MCV_OK;
    return mcv_cl_check(
        cl, clEnqueueWriteBuffer(cl->queue, buffer, CL_TRUE, offset, bytes, data, 0, NULL, NULL),
        "writing to the device", error);
}

mcv_result mcv_cl_finish(mcv_cl *cl, mcv_error *error) {
    return mcv_cl_check(cl, clFinish(cl->queue), "waiting for the device", error);
}

mcv_result mcv_cl_clear(mcv_cl *cl, cl_mem buffer, size_t bytes, mcv_error *error) {
    const cl_uint nothing = 0;
    return mcv_cl_check(
        cl,
        clEnqueueFillBuffer(cl->queue, buffer, &nothing, sizeof nothing, 0, bytes, 0, NULL, NULL),
        "clearing a buffer on the device", error);
}

void mcv_cl_release(cl_mem *buffer) {
    if (*buffer) clReleaseMemObject(*buffer);
    *buffer = NULL;
}

mcv_result mcv_cl_launch(mcv_cl *cl, cl_kernel kernel, size_t global, size_t local,
                         const mcv_arg *arguments, size_t count, cl_event *event,
                         mcv_error *error) {
    const size_t padded = (global + local - 1) / local * local;
    cl_int code = CL_SUCCESS;
    for (size_t i = 0; i < count && code == CL_SUCCESS; ++i) {
        code = clSetKernelArg(kernel, (cl_uint)i, arguments[i].size, arguments[i].value);
    }
    if (code == CL_SUCCESS && padded > 0) {
        code = clEnqueueNDRangeKernel(cl->queue, kernel, 1, NULL, &padded, &local, 0, NULL, event);
    }
    if (code == CL_SUCCESS) return MCV_OK;
    char name[128] = "";
    clGetKernelInfo(kernel, CL_KERNEL_FUNCTION_NAME, sizeof name, name, NULL);
    char what[192];
    snprintf(what, sizeof what, "the launch of kernel %s", name);
    return mcv_cl_check(cl, code, what, error);
}

double mcv_cl_seconds(cl_event event) {
    cl_ulong begin = 0;
    cl_ulong end = 0;
    clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START, sizeof begin, &begin, NULL);
    clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof end, &end, NULL);
    clReleaseEvent(event);
    return end > begin ? 1e-9 * (double)(end - begin) : 0;
}
