/* SPDX-License-Identifier: Apache-2.0 */
#include "device/hierarchy.h"

#include <stdlib.h>
#include <string.h>

/* The hierarchy of the triangles that move, or of the others. */
static mcv_result build_part(const mcv_packed *packed, bool moves, uint32_t threads, mcv_bvh *bvh,
                             mcv_error *error) {
    const size_t all = packed->triangle_count;
    uint32_t *indices = malloc(3 * all * sizeof *indices + 1),
             *numbers = malloc(all * sizeof *numbers + 1), count = 0;
    mcv_result result = MCV_OK;
    if (indices && numbers) {
        for (uint32_t t = 0; t < all; ++t) {
            if ((packed->instances[packed->triangles[4 * (size_t)t + 3]].moves != 0) != moves)
                continue;
            memcpy(indices + 3 * (size_t)count, packed->indices + 3 * (size_t)t,
                   3 * sizeof *indices);
            numbers[count++] = t;
        }
        result = mcv_bvh_build(packed->positions, indices, count, threads, bvh, error);
    } else {
        result = mcv_fail(error, MCV_FAILED, "no memory for the acceleration structure");
    }
    for (uint32_t i = 0; result == MCV_OK && i < bvh->leaf_count; ++i)
        for (uint32_t lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane) {
            uint32_t *triangle = bvh->leaves[i].triangle + lane;
            if (*triangle != MCV_NONE) *triangle = numbers[*triangle];
        }
    free(indices);
    free(numbers);
    return result;
}

/* The second array behind the first; NULL without memory. Both are freed. */
static void *join(void *first, size_t first_bytes, void *second, size_t second_bytes) {
    char *both = aligned_alloc(128, (first_bytes + second_bytes + 127) / 128 * 128);
    if (both) {
        memcpy(both, first, first_bytes);
        memcpy(both + first_bytes, second, second_bytes);
    }
    free(first);
    free(second);
    return both;
}

mcv_result mcv_build_hierarchy(const mcv_packed *packed, uint32_t threads, mcv_bvh *bvh,
                               uint32_t begins[2], mcv_error *error) {
    mcv_bvh moving = {0};
    begins[0] = begins[1] = 0;
    if (!packed->moves)
        return mcv_bvh_build(packed->positions, packed->indices, packed->triangle_count, threads,
                             bvh, error);
    mcv_result result = build_part(packed, false, threads, bvh, error);
    if (result == MCV_OK) result = build_part(packed, true, threads, &moving, error);
    if (result != MCV_OK) {
        mcv_bvh_free(bvh);
        return result;
    }
    begins[0] = bvh->node_count;
    begins[1] = bvh->leaf_count;
    bvh->nodes = join(bvh->nodes, bvh->node_count * sizeof *bvh->nodes, moving.nodes,
                      moving.node_count * sizeof *bvh->nodes);
    bvh->leaves = join(bvh->leaves, bvh->leaf_count * sizeof *bvh->leaves, moving.leaves,
                       moving.leaf_count * sizeof *bvh->leaves);
    bvh->node_count += moving.node_count;
    bvh->leaf_count += moving.leaf_count;
    if (bvh->nodes && bvh->leaves) return MCV_OK;
    mcv_bvh_free(bvh);
    return mcv_fail(error, MCV_FAILED, "no memory for the acceleration structure");
}
