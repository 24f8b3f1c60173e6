/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes of at most eight leaves: many rays against all triangles, without a hierarchy. */
#ifndef MCVISI_KERNELS_FLAT_H
#define MCVISI_KERNELS_FLAT_H

#include "traverse/lane_rays.h"

/* Whether all children of the root are leaves. */
static inline int mcv_is_flat(__global const mcv_node *root) {
    uint bits = MCV_CHILD_LEAF;
    for (uint i = 0; i < MCV_BVH_WIDTH; ++i) bits &= root->child[i]; /* MCV_NONE has it, too */
    return bits != 0u;
}

/* Writes the hits of rays that follow each other; those of `changed` are new. */
MCV_LOOP_FUNCTION void mcv_store_neighbours(const mcv_lanes *rays, mcv_uints before, uint first,
                                            int any, mcv_hits hits) {
    mcv_store_lanes(rays->primitive, hits.primitive + first);
    if (any) return;
    const mcv_ints met = rays->primitive != before;
    const mcv_uints u = mcv_as_uints(rays->b / rays->det), v = mcv_as_uints(rays->c / rays->det);
    mcv_store_lanes(mcv_as_uints(rays->t), hits.t + first);
    mcv_store_lanes(met ? u : mcv_load_lanes(hits.u + first), hits.u + first);
    mcv_store_lanes(met ? v : mcv_load_lanes(hits.v + first), hits.v + first);
}

/* The same of any rays. */
MCV_LOOP_FUNCTION void mcv_store_some(const mcv_lanes *rays, const uint *numbers, uint changed,
                                      int any, mcv_hits hits) {
    uint met[4][MCV_LANES];
    mcv_store_lanes(mcv_as_uints(rays->t), met[0]);
    mcv_store_lanes(mcv_as_uints(rays->b / rays->det), met[1]);
    mcv_store_lanes(mcv_as_uints(rays->c / rays->det), met[2]);
    mcv_store_lanes(rays->primitive, met[3]);
    do {
        const uint k = mcv_pop_bit(&changed), i = numbers[k];
        hits.primitive[i] = met[3][k];
        if (any) continue;
        hits.t[i] = met[0][k];
        hits.u[i] = met[1][k];
        hits.v[i] = met[2][k];
    } while (changed);
}

MCV_LOOP_FUNCTION void mcv_trace_flat(__global const mcv_node *root,
                                      __global const mcv_leaf *leaves, mcv_rows origins,
                                      mcv_rows directions, const uint *numbers, uint count, int any,
                                      mcv_hits hits) {
    __global const float *corners[MCV_BVH_WIDTH * MCV_LEAF_TRIANGLES];
    uint triangles[MCV_BVH_WIDTH * MCV_LEAF_TRIANGLES], triangle_count = 0;
    for (uint child = 0; child < MCV_BVH_WIDTH; ++child) {
        if (root->child[child] == MCV_NONE) continue;
        __global const mcv_leaf *leaf = leaves + (root->child[child] & ~MCV_CHILD_LEAF);
        for (uint lane = 0; lane < MCV_LEAF_TRIANGLES && leaf->triangle[lane] != MCV_NONE; ++lane) {
            corners[triangle_count] = MCV_CORNERS_OF(leaf, lane);
            triangles[triangle_count++] = leaf->triangle[lane];
        }
    }
    for (uint first = 0; first < count; first += MCV_LANES) {
        const uint *own = numbers + first;
        uint filled[MCV_LANES]; /* the last ray in place of those that are missing */
        mcv_lane_slabs slabs;
        mcv_lanes rays;
        mcv_uints before, t;
        if (count - first < MCV_LANES) {
            for (uint i = 0; i < MCV_LANES; ++i) filled[i] = numbers[min(first + i, count - 1u)];
            own = filled;
        }
        const int neighbours = origins.step == 1u && mcv_are_neighbours(own);
        mcv_lanes_setup(origins, directions, own, neighbours, root->extent, &slabs, &rays);
        MCV_TAKE_LANES(hits.t, 1u, own, neighbours, t);
        MCV_TAKE_LANES(hits.primitive, 1u, own, neighbours, before);
        rays.t = mcv_as_floats(t);
        rays.primitive = before;
        rays.b = rays.c = rays.det = (mcv_floats)(1.0f);
        uint changed = 0;
        for (uint i = 0; i < triangle_count; ++i)
            changed |= mcv_lanes_hit(corners[i], triangles[i], any, &rays);
        if (!changed) continue;
        if (neighbours)
            mcv_store_neighbours(&rays, before, own[0], any, hits);
        else
            mcv_store_some(&rays, own, changed, any, hits);
    }
}

#endif
