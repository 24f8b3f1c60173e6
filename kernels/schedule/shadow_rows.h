/* SPDX-License-Identifier: Apache-2.0 */
/* Stage of the tile schedule: intersect_shadow over a slice. */
#ifndef MCVISI_KERNELS_SHADOW_ROWS_H
#define MCVISI_KERNELS_SHADOW_ROWS_H

#include "schedule/tile.h"

#include "schedule/intersect_rows.h"
#include "stage/intersect_shadow.h"

#if MCV_WITH_NEXT_EVENT
/*
 * mcv_shadow_past_solids of the paths first … last - 1: what their shadow rays hit, of triangles
 * (the given hits) and exact surfaces. A ray that ends at -INFINITY is none.
 */
MCV_BATCH void mcv_shadows_past_solids(mcv_world world, const uint *paths, uint first, uint last,
                                       int any, mcv_hits hits) {
    MCV_ALIGNED uint rows[8 * MCV_ROW];
    float lengths[MCV_ROW];
    const uint count = last - first;
    const mcv_hits exact = mcv_hits_in(rows + 4 * MCV_ROW, MCV_ROW);
    const uint *ways = paths + MCV_PATH_shadow_direction * MCV_ROW + first,
               *origin_surfaces = paths + MCV_PATH_shadow_origin_surface * MCV_ROW + first;
    const mcv_ray_rows rays = {paths + MCV_PATH_shadow_origin * MCV_ROW + first, rows,
                               rows + 3 * MCV_ROW};
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const mcv_vec3 way = mcv_one_of(ways, i);
        const float length = mcv_sqrt(mcv_dot(way, way));
        const mcv_vec3 unit = mcv_scale(way, 1.0f / length);
        const float end = as_float(hits.t[first + i]);
        const uint primitive = hits.primitive[first + i];
        rows[i] = as_uint(unit.x);
        rows[MCV_ROW + i] = as_uint(unit.y);
        rows[2 * MCV_ROW + i] = as_uint(unit.z);
        rows[3 * MCV_ROW + i] = end > -INFINITY ? origin_surfaces[i] : MCV_NONE;
        lengths[i] = length;
        exact.t[i] = as_uint((any & (primitive != MCV_NONE)) ? -INFINITY : end * length);
        exact.u[i] = hits.u[first + i];
        exact.v[i] = hits.v[first + i];
        exact.primitive[i] = primitive;
    }
    mcv_intersect_solid_rows(world, rays, count, exact);
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const int closer = exact.primitive[i] != hits.primitive[first + i];
        hits.t[first + i] = closer ? as_uint(as_float(exact.t[i]) / lengths[i]) : hits.t[first + i];
        hits.u[first + i] = closer ? exact.u[i] : hits.u[first + i];
        hits.v[first + i] = closer ? exact.v[i] : hits.v[first + i];
        hits.primitive[first + i] = exact.primitive[i];
    }
}

/* No hits of the paths first … last - 1, and no rays. */
MCV_BATCH void mcv_begin_shadows(mcv_hits hits, uint first, uint last) {
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(last - first); ++i)
        mcv_put_hit(hits, first + i, mcv_miss(-INFINITY));
}

MCV_LOOP_FUNCTION int mcv_is_lit(mcv_hit hit, int any) {
    return (hit.t > -INFINITY) & (!any | (hit.primitive == MCV_NONE));
}

#if MCV_WITH_RECORDS
MCV_BATCH uint mcv_count_lit(uint *paths, uint first, uint last, int any, mcv_hits hits) {
    uint lit = 0;
    MCV_EACH_PATH (slot, paths, first, first + mcv_fill_lanes(last - first))
        lit += (uint)mcv_is_lit(mcv_hit_of(hits, slot.index), any);
    return lit;
}
#endif

#if MCV_HAS_TARGET_IMAGES
/* mcv_apply_target_image of those listed paths whose shadow rays have hit their target. */
MCV_BATCH void mcv_apply_target_images(mcv_world world, uint *paths, const uint *listed, uint count,
                                       mcv_hits hits) {
    uint flags[MCV_SLOTS], chosen[MCV_SLOTS];
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i)
        flags[i] = (mcv_hit_of(hits, listed[i]).t > -INFINITY) &
                   mcv_target_has_image(world, mcv_slot_at(paths, listed[i]));
    const uint chosen_count = mcv_compact_row(flags, listed, count, chosen);
    MCV_VECTORIZE_MASKED
    for (uint i = 0; i < chosen_count; ++i)
        mcv_apply_target_image(world, mcv_slot_at(paths, chosen[i]), mcv_hit_of(hits, chosen[i]));
}
#endif

/* Adds the light of the shadow rays that arrive: where any hit blocks they have none, else they
 * have hit their target. */
MCV_BATCH void mcv_add_shadow_lights(mcv_world world, uint *paths, uint first, uint last, int any,
                                     mcv_hits hits) {
    uint place = 0;
#if MCV_WITH_RECORDS
    place = mcv_reserve_records(world, mcv_count_lit(paths, first, last, any, hits));
#endif
#if !MCV_WITH_RECORDS
    MCV_VECTORIZE
#endif
    MCV_EACH_PATH (slot, paths, first, first + mcv_fill_lanes(last - first)) {
        const mcv_hit hit = mcv_hit_of(hits, slot.index);
        const int lit = mcv_is_lit(hit, any);
        mcv_add_shadow_light(world, slot, hit, lit, place);
        if (MCV_WITH_RECORDS) place += (uint)lit;
    }
}

/* mcv_intersect_shadow of the listed paths, in ascending order. */
static void mcv_intersect_shadows(mcv_world world, uint *paths, const uint *listed, uint count) {
    const mcv_rows origins = MCV_ROWS(paths, shadow_origin),
                   directions = MCV_ROWS(paths, shadow_direction);
    MCV_ALIGNED uint rows[4 * MCV_ROW];
    const mcv_hits hits = mcv_hits_in(rows, MCV_ROW);
    for (int any = !MCV_HAS_TARGETS; any < 2; ++any) {
        const uint *chosen = listed;
        uint flags[MCV_SLOTS], of_either[MCV_SLOTS], chosen_count = count;
        if (MCV_HAS_TARGETS) {
            for (uint i = 0; i < count; ++i)
                flags[i] = mcv_shadow_is_any(mcv_slot_at(paths, listed[i])) == any;
            chosen = of_either;
            chosen_count = mcv_compact_row(flags, listed, count, of_either);
        }
        if (chosen_count == 0u) continue;
        const uint first = chosen[0], last = chosen[chosen_count - 1u] + 1u;
        mcv_begin_shadows(hits, first, last);
        for (uint i = 0; i < chosen_count; ++i)
            hits.t[chosen[i]] = as_uint(mcv_shadow_end(mcv_slot_at(paths, chosen[i])));
        if (any)
            mcv_intersect_any_rays(world.nodes, world.leaves, origins, directions, chosen,
                                   chosen_count, hits);
        else
            mcv_intersect_closest_rays(world.nodes, world.leaves, origins, directions, chosen,
                                       chosen_count, hits);
#if MCV_WITH_MOVING
        for (uint i = 0; i < chosen_count; ++i)
            mcv_put_hit(hits, chosen[i],
                        mcv_shadow_past_moving(world, mcv_slot_at(paths, chosen[i]),
                                               mcv_hit_of(hits, chosen[i])));
#endif
        if (MCV_WITH_SURFACES) mcv_shadows_past_solids(world, paths, first, last, any, hits);
        for (uint i = 0; i < chosen_count && !any; ++i)
            if (!mcv_hits_target(world, mcv_slot_at(paths, chosen[i]), mcv_hit_of(hits, chosen[i])))
                hits.t[chosen[i]] = as_uint(-INFINITY);
#if MCV_HAS_TARGET_IMAGES
        if (!any) mcv_apply_target_images(world, paths, chosen, chosen_count, hits);
#endif
        mcv_add_shadow_lights(world, paths, first, last, any, hits);
    }
}
#endif

#endif
