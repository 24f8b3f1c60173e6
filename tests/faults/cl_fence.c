/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A layer of OpenCL (OPENCL_LAYERS of ocl-icd) for drivers whose device memory is the host's, such
 * as PoCL: each buffer ends where a page begins that nobody may touch, and begins behind another
 * one. A kernel that reads or writes beyond a buffer ends the process. What lies between the first
 * page and the buffer is checked at the end.
 *
 * It writes the number of buffers, and of those whose surroundings were written, to MCV_CL_COUNT.
 */
#include "cl_layer.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

enum { ALIGNMENT = 16, MOST = 4096, MARK = 0xa5 };

static const struct _cl_icd_dispatch *next;
static struct _cl_icd_dispatch ours;
static struct {                          /* never unmapped: a late write is found, too */
    uint8_t *first, *begin, *end, *last; /* marks, buffer, marks */
} fences[MOST];
static int count;

/* Memory that ends at a page of its own. NULL where there is none. */
static void *make_fence(size_t size) {
    const size_t page = (size_t)sysconf(_SC_PAGESIZE),
                 rounded = (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT,
                 inside = (rounded + page - 1) / page * page;
    if (count == MOST) return NULL;
    uint8_t *all = mmap(NULL, inside + 2 * page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (all == MAP_FAILED || mprotect(all + page, inside, PROT_READ | PROT_WRITE) != 0) return NULL;
    fences[count].first = all + page;
    fences[count].last = all + page + inside;
    fences[count].begin = fences[count].last - rounded;
    fences[count].end = fences[count].begin + size;
    for (uint8_t *at = fences[count].first; at < fences[count].begin; ++at) *at = MARK;
    for (uint8_t *at = fences[count].end; at < fences[count].last; ++at) *at = MARK;
    return fences[count++].begin;
}

static cl_mem CL_API_CALL fenced_buffer(cl_context context, cl_mem_flags flags, size_t size,
                                        void *host, cl_int *code) {
    const cl_mem_flags hosted = CL_MEM_USE_HOST_PTR | CL_MEM_ALLOC_HOST_PTR | CL_MEM_COPY_HOST_PTR;
    void *fence = flags & hosted ? NULL : make_fence(size);
    return fence ? next->clCreateBuffer(context, flags | CL_MEM_USE_HOST_PTR, size, fence, code)
                 : next->clCreateBuffer(context, flags, size, host, code);
}

const struct _cl_icd_dispatch *layer_begin(const struct _cl_icd_dispatch *target) {
    next = target;
    ours = *target;
    ours.clCreateBuffer = fenced_buffer;
    return &ours;
}

static int is_written(int i) {
    for (const uint8_t *at = fences[i].first; at < fences[i].begin; ++at)
        if (*at != MARK) return 1;
    for (const uint8_t *at = fences[i].end; at < fences[i].last; ++at)
        if (*at != MARK) return 1;
    return 0;
}

__attribute__((destructor)) static void finish(void) {
    const char *path = getenv("MCV_CL_COUNT");
    FILE *file = path ? fopen(path, "w") : NULL;
    int written = 0;
    if (!file) return;
    for (int i = 0; i < count; ++i) written += is_written(i);
    fprintf(file, "%d %d\n", count, written);
    fclose(file);
}
