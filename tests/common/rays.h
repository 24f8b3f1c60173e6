/* SPDX-License-Identifier: Apache-2.0 */
/* Batches of rays through kernels/test/intersect.cl, for the tests and benchmarks of the
 * acceleration structure. */
#ifndef MCVISI_TESTS_RAYS_H
#define MCVISI_TESTS_RAYS_H

#include "accel/bvh.h"
#include "cl/cl.h"

/* The layout of mcv_batch_ray in kernels/test/intersect.cl. */
typedef struct batch_ray {
    float origin[3], t_max;
    float direction[3], unused;
} batch_ray;

typedef struct tracer {
    mcv_cl cl;
    cl_program program;
    cl_kernel closest, any, closest_alone, any_alone, closest_together, any_together, all, count;
    cl_mem nodes, leaves;
    cl_uint leaf_count;
} tracer;

enum { RAYS_PER_GROUP = 256 };

static inline mcv_result tracer_open(tracer *t, mcv_error *error) {
    *t = (tracer){0};
    MCV_TRY(mcv_cl_open(NULL, &t->cl, error));
    MCV_TRY(mcv_cl_build(&t->cl, "test/intersect", "", &t->program, error));
    MCV_TRY(mcv_cl_kernel(t->program, "intersect_closest", &t->closest, error));
    MCV_TRY(mcv_cl_kernel(t->program, "intersect_any", &t->any, error));
    MCV_TRY(mcv_cl_kernel(t->program, "intersect_closest_alone", &t->closest_alone, error));
    MCV_TRY(mcv_cl_kernel(t->program, "intersect_any_alone", &t->any_alone, error));
    MCV_TRY(mcv_cl_kernel(t->program, "intersect_closest_together", &t->closest_together, error));
    MCV_TRY(mcv_cl_kernel(t->program, "intersect_any_together", &t->any_together, error));
    MCV_TRY(mcv_cl_kernel(t->program, "intersect_all", &t->all, error));
    return mcv_cl_kernel(t->program, "count_hits", &t->count, error);
}

static inline void tracer_close(tracer *t) {
    const cl_kernel kernels[] = {
        t->closest,          t->any,          t->closest_alone, t->any_alone,
        t->closest_together, t->any_together, t->all,           t->count};
    for (size_t i = 0; i < sizeof kernels / sizeof kernels[0]; ++i) {
        if (kernels[i]) clReleaseKernel(kernels[i]);
    }
    if (t->program) clReleaseProgram(t->program);
    mcv_cl_release(&t->nodes);
    mcv_cl_release(&t->leaves);
    mcv_cl_close(&t->cl);
}

/* The scene of the next batches. */
static inline mcv_result tracer_load(tracer *t, const mcv_bvh *bvh, mcv_error *error) {
    mcv_cl_release(&t->nodes);
    mcv_cl_release(&t->leaves);
    t->leaf_count = bvh->leaf_count;
    MCV_TRY(mcv_cl_buffer(&t->cl, "the nodes", bvh->node_count * sizeof *bvh->nodes, bvh->nodes,
                          &t->nodes, error));
    return mcv_cl_buffer(&t->cl, "the leaves", bvh->leaf_count * sizeof *bvh->leaves, bvh->leaves,
                         &t->leaves, error);
}

/* Runs one of the kernels over rays; `out` takes an mcv_hit per ray from closest… and all, a cl_int
 * from the others. */
static inline mcv_result tracer_run(tracer *t, cl_kernel kernel, const batch_ray *rays,
                                    cl_uint count, void *out, mcv_error *error) {
    const bool through_nodes = kernel != t->all && kernel != t->count;
    const bool hits = kernel == t->closest || kernel == t->closest_alone ||
                      kernel == t->closest_together || kernel == t->all;
    const size_t bytes = count * (hits ? sizeof(mcv_hit) : sizeof(cl_int));
    const cl_uint slice = RAYS_PER_GROUP;
    const size_t groups = (count + slice - 1) / slice;
    cl_mem in, result;
    MCV_TRY(mcv_cl_buffer(&t->cl, "the rays", count * sizeof *rays, rays, &in, error));
    MCV_TRY(mcv_cl_buffer(&t->cl, "the hits", bytes, NULL, &result, error));
    if (through_nodes)
        MCV_TRY(MCV_LAUNCH(&t->cl, kernel, groups, 1, error, MCV_ARG(t->nodes), MCV_ARG(t->leaves),
                           MCV_ARG(in), MCV_ARG(result), MCV_ARG(count), MCV_ARG(slice)));
    else
        MCV_TRY(MCV_LAUNCH(&t->cl, kernel, groups, 1, error, MCV_ARG(t->leaves), MCV_ARG(in),
                           MCV_ARG(result), MCV_ARG(count), MCV_ARG(slice),
                           MCV_ARG(t->leaf_count)));
    MCV_TRY(mcv_cl_read(&t->cl, result, 0, bytes, out, error));
    mcv_cl_release(&in);
    mcv_cl_release(&result);
    return MCV_OK;
}

#endif
