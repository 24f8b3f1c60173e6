/* SPDX-License-Identifier: Apache-2.0 */
/* Building the acceleration structure of mcvisi/accel.h. */
#ifndef MCVISI_HOST_ACCEL_BVH_H
#define MCVISI_HOST_ACCEL_BVH_H

#include "mcvisi/accel.h"
#include "core/error.h"

/* Both arrays are aligned to 128 bytes, so that an OpenCL device may use them in place. */
typedef struct mcv_bvh {
    mcv_node *nodes; /* at least the root */
    mcv_leaf *leaves;
    uint32_t node_count, leaf_count;
} mcv_bvh;

/*
 * Builds the hierarchy over triangles. positions are 3 finite floats per vertex in the frame of the
 * rays [m]; indices are 3 vertices per triangle; triangle i is the i-th triple. Both are only read
 * during the call. threads = 0 means one per processor; the result does not depend on it. A scene
 * without triangles is valid, and no ray hits it. Triangles without area are included and never
 * hit. Fails without memory or with more than 2^28 triangles; *bvh is then empty. Free it with
 * mcv_bvh_free.
 *
 * The method is the surface area heuristic with spatial splits (host/accel/split.h), counting
 * blocks of four triangles, into a binary hierarchy. Its nodes are gathered into nodes of eight at
 * the least cost. A triangle may lie in several leaves, at most 1.7 references per triangle in all.
 */
mcv_result mcv_bvh_build(const float *positions, const uint32_t *indices, uint32_t triangle_count,
                         uint32_t threads, mcv_bvh *bvh, mcv_error *error);
void mcv_bvh_free(mcv_bvh *bvh);

/*
 * Moves the vertices; the triangles and their indices stay. The hierarchy stays, and the boxes
 * above moved triangles are updated to the whole triangles. Rays find the same hits as in a new
 * hierarchy, but not always as fast: see mcv_bvh_cost.
 */
mcv_result mcv_bvh_refit(mcv_bvh *bvh, const float *positions, const uint32_t *indices,
                         mcv_error *error);

/* The expected number of boxes that a random ray through the whole box hits: the sum of the areas
 * of all boxes over that of the whole. */
double mcv_bvh_cost(const mcv_bvh *bvh);

#endif
