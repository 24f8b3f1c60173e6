/* SPDX-License-Identifier: Apache-2.0 */
/* A plain peer of ours: a binary hierarchy of the same splits whose rays go alone, in scalar
 * arithmetic. Shared with bvh2.cl. */
#ifndef MCVISI_BENCH_BVH2_H
#define MCVISI_BENCH_BVH2_H

#include "mcvisi/dialect.h"

/* Splits halve from the 65th level on: 2^28 triangles have 28 more. */
#define BVH2_LEVELS 96
#define BVH2_LEAF 4 /* triangles at most */

typedef struct bvh2_node {
    float lower[3];
    uint first; /* of two children side by side, or of its triangles */
    float upper[3];
    uint count; /* of triangles; 0: an inner node */
} bvh2_node;

typedef struct bvh2_triangle {
    float corner[3], edges[2][3];
    uint number;
} bvh2_triangle;

#ifndef __OPENCL_VERSION__
#include "cl/cl.h"

typedef struct bvh2 {
    bvh2_node *nodes;
    bvh2_triangle *triangles;
    uint32_t node_count, triangle_count; /* spatial splits count a triangle more than once */
} bvh2;

mcv_result bvh2_build(const float *positions, const uint32_t *indices, uint32_t triangle_count,
                      bvh2 *made, mcv_error *error);
void bvh2_free(bvh2 *b);

/* Builds bvh2.cl from its source. */
mcv_result bvh2_program(const mcv_cl *cl, cl_program *program, mcv_error *error);
#endif

#endif
