/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which way the rays of a stage go through the hierarchy in the tile schedule, chosen once for the renderer and for what measures it:
 * rays from the sensor run side by side and are bundled; those that have been scattered take turns where the scene is large. The shadow
 * rays that must meet their emitter first run within its narrow cone; those to a place on an emitter diverge.
 */
#ifndef MCVISI_WAYS_H
#define MCVISI_WAYS_H

#include "bundle.h"

#define MCV_CLOSEST_FIRST mcv_intersect_closest_bundles
#if MCV_WITH_INTERLEAVE
#define MCV_CLOSEST_LATER mcv_intersect_closest_turns
#define MCV_CLOSEST_SHADOW mcv_intersect_closest_turns
#define MCV_ANY_SHADOW mcv_intersect_any_turns
#else
#define MCV_CLOSEST_LATER mcv_intersect_closest_bundles
#define MCV_CLOSEST_SHADOW mcv_intersect_closest_bundles
#define MCV_ANY_SHADOW mcv_intersect_any_alone
#endif

/* One ray after the other; parameters as of mcv_take_turns. */
static inline void mcv_intersect_any_alone(__global const mcv_node *nodes, __global const mcv_leaf *leaves, mcv_rows origins,
                                           mcv_rows directions, const uint *indices, uint count, mcv_hit *hits) {
    if (mcv_is_flat(nodes)) {
        mcv_intersect_any_bundles(nodes, leaves, origins, directions, indices, count, hits);
        return;
    }
    for (uint i = 0; i < count; ++i) {
        const mcv_vec3 origin = mcv_row(origins, indices[i]), direction = mcv_row(directions, indices[i]);
        if (mcv_intersect_any_ray(nodes, leaves, origin, direction, hits[i].t)) hits[i].triangle = 0;
    }
}

#endif
