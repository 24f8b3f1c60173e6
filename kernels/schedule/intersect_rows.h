/* SPDX-License-Identifier: Apache-2.0 */
/* Stage of the tile schedule: intersect_closest over a slice, exact surfaces first, then triangles
 * in packets. */
#ifndef MCVISI_KERNELS_INTERSECT_ROWS_H
#define MCVISI_KERNELS_INTERSECT_ROWS_H

#include "schedule/tile.h"

#include "schedule/solid_rows.h"
#include "stage/intersect_closest.h"
#include "traverse/trace_packet.h"

/* A vector's rows, as traverse/packet.h reads them. */
#define MCV_ROWS(paths, field) \
    { (paths) + MCV_PATH_##field *MCV_ROW, 1u, MCV_ROW }

MCV_FUNCTION float mcv_least_lane(float8 lanes) {
    const float4 four = min(lanes.lo, lanes.hi);
    const float2 two = min(four.lo, four.hi);
    return min(two.x, two.y);
}

MCV_FUNCTION float mcv_most_lane(float8 lanes) { return -mcv_least_lane(-lanes); }

/* The rays that enter the box of all triangles before they end; returns how many. */
MCV_BATCH uint mcv_list_near_triangles(mcv_world world, uint *paths, uint count, uint *chosen) {
    uint enters[MCV_ROW];
    float low[3], high[3];
    const float extent = world.nodes->extent;
    for (uint axis = 0; axis < 3; ++axis) {
        low[axis] = mcv_least_lane(*(__global const float8 *)world.nodes->bounds[axis][0]);
        high[axis] = mcv_most_lane(*(__global const float8 *)world.nodes->bounds[axis][1]);
    }
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, paths, 0, mcv_fill_lanes(count)) {
        const mcv_vec3 o = MCV_LOAD_3(slot, origin), d = MCV_LOAD_3(slot, direction);
        enters[slot.index] = (uint)mcv_enters_box(low, high, extent, o, d, MCV_LOAD(slot, hit, 0));
    }
    return mcv_compact_indices(enters, count, chosen);
}

/* mcv_intersect_closest of the paths in the slots 0 … count - 1. */
MCV_BATCH void mcv_intersect_paths(mcv_world world, uint *paths, uint count) {
    const mcv_rows origins = MCV_ROWS(paths, origin), directions = MCV_ROWS(paths, direction);
    const mcv_hits hits = mcv_hits_in(paths + MCV_PATH_hit * MCV_ROW, MCV_ROW);
    uint chosen[MCV_ROW];
    uint listed = count;
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        mcv_put_hit(hits, i, mcv_miss(INFINITY));
        chosen[i] = i;
    }
    if (MCV_WITH_SURFACES) {
        const mcv_ray_rows rays = {origins.base, directions.base,
                                   paths + MCV_PATH_origin_surface * MCV_ROW};
        mcv_intersect_solid_rows(world, rays, count, hits);
        /* The triangles of two leaves take no longer than the box that holds them. */
        if (!mcv_is_flat(world.nodes) || world.nodes->child[2] != MCV_NONE)
            listed = mcv_list_near_triangles(world, paths, count, chosen);
    }
    mcv_intersect_closest_rays(world.nodes, world.leaves, origins, directions, chosen, listed,
                               hits);
#if MCV_WITH_MOVING
    /* Rays of different times have nothing in common. */
    MCV_EACH_PATH (slot, paths, 0, count)
        mcv_put_hit(hits, slot.index,
                    mcv_closest_moving(mcv_at_time(world, slot), MCV_LOAD_3(slot, origin),
                                       MCV_LOAD_3(slot, direction), mcv_hit_of(hits, slot.index)));
#endif
    if (!MCV_WITH_ABSORPTION) return;
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, paths, 0, count) mcv_absorb(world, slot);
}

#endif
