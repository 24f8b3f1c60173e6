/* SPDX-License-Identifier: Apache-2.0 */
/* Many rays against the exact surfaces (geometry/solids.h), one solid after the other: the same
 * functions as for one ray, so the same bits. */
#ifndef MCVISI_KERNELS_SOLID_ROWS_H
#define MCVISI_KERNELS_SOLID_ROWS_H

#include "schedule/tile.h"

#include "geometry/solids.h"
#include "schedule/compact.h"
#include "schedule/vectorize.h"
#include "traverse/closest.h"
#include "traverse/rows.h"

/* Rays side by side: rows of MCV_ROW words for each component. The directions are unit. */
typedef struct mcv_ray_rows {
    const uint *origin, *direction, *origin_surface;
} mcv_ray_rows;

MCV_LOOP_FUNCTION mcv_vec3 mcv_one_of(const uint *rows, uint i) {
    return mcv_vec(as_float(rows[i]), as_float(rows[MCV_ROW + i]), as_float(rows[2 * MCV_ROW + i]));
}

MCV_LOOP_FUNCTION mcv_solid_ray mcv_solid_ray_of(mcv_world world, uint number, mcv_ray_rows rays,
                                                 uint i) {
    return mcv_make_solid_ray(world, number, mcv_one_of(rays.origin, i),
                              mcv_one_of(rays.direction, i), rays.origin_surface[i]);
}

/* The shape is known to the compiler. */
MCV_LOOP_FUNCTION void mcv_intersect_shape_row(mcv_world world, mcv_ray_rows rays, uint number,
                                               uint shape, uint count, uint *t, uint *pieces) {
    __global const mcv_device_solid *solid = world.solids + number;
    MCV_VECTORIZE_MASKED
    for (uint i = 0; i < count; ++i) {
        const mcv_piece_hit hit =
            mcv_intersect_shape(solid, shape, mcv_solid_ray_of(world, number, rays, i));
        t[i] = as_uint(hit.t);
        pieces[i] = hit.piece;
    }
}

/* Where the rays hit a solid, and which piece of it. */
MCV_BATCH void mcv_intersect_solid_row(mcv_world world, mcv_ray_rows rays, uint number, uint shape,
                                       uint count, uint *t, uint *pieces) {
#define MCV_CASE(SHAPE) \
    case SHAPE: \
        mcv_intersect_shape_row(world, rays, number, SHAPE, count, t, pieces); \
        break;
    switch (shape) {
        MCV_CASE(MCV_SHAPE_DISC)
        MCV_CASE(MCV_SHAPE_BALL)
        MCV_CASE(MCV_SHAPE_BOX)
        MCV_CASE(MCV_SHAPE_CONICS)
    default:
        for (uint i = 0; i < count; ++i) {
            const mcv_solid_ray ray = mcv_solid_ray_of(world, number, rays, i);
            const mcv_piece_hit hit = mcv_intersect_other(world.solids + number, &ray);
            t[i] = as_uint(hit.t);
            pieces[i] = hit.piece;
        }
    }
#undef MCV_CASE
}

/* Which rays may hit a solid; returns how many. */
MCV_BATCH uint mcv_find_approaching(mcv_world world, mcv_ray_rows rays, uint count, uint number,
                                    mcv_hits hits, uint *reaches) {
    __global const mcv_device_solid *solid = world.solids + number;
    uint near = 0;
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const int comes = mcv_reaches_solid(solid, mcv_one_of(rays.origin, i),
                                            mcv_one_of(rays.direction, i), as_float(hits.t[i]));
        reaches[i] = (uint)(comes & (i < count));
        near += reaches[i];
    }
    return near;
}

/* mcv_take_exact_hit of the rays that may hit a solid; hits at the same distance, of solids in
 * contact, are rare and taken one by one. */
MCV_BATCH void mcv_take_exact_hits(mcv_world world, const uint *t, const uint *pieces, uint number,
                                   uint count, const uint *reaches, mcv_hits hits) {
    uint tied[MCV_ROW], ties = 0;
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const float before = as_float(hits.t[i]), here = as_float(t[i]);
        const uint primitive = hits.primitive[i];
        const int closer = (reaches[i] != 0u) & (here < before);
        tied[i] = (reaches[i] != 0u) & (here == before) & mcv_is_exact(primitive) &
                  (primitive != MCV_NONE);
        ties += tied[i];
        hits.t[i] = as_uint(closer ? here : before);
        hits.u[i] = closer ? 0u : hits.u[i];
        hits.v[i] = closer ? 0u : hits.v[i];
        hits.primitive[i] = closer ? mcv_exact_hit(number, pieces[i]) : primitive;
    }
    for (uint i = 0; ties > 0 && i < count; ++i) {
        if (!tied[i]) continue;
        mcv_hit hit = mcv_hit_of(hits, i);
        mcv_take_exact_hit(world, as_float(t[i]), number, pieces[i], &hit);
        mcv_put_hit(hits, i, hit);
    }
}

/* mcv_intersect_solids of many rays: replaces the given hits, or misses with their t_max, by closer
 * ones. */
MCV_BATCH void mcv_intersect_solid_rows(mcv_world world, mcv_ray_rows rays, uint count,
                                        mcv_hits hits) {
    uint reaches[MCV_ROW], t[MCV_ROW], pieces[MCV_ROW], near_t[MCV_ROW], near_pieces[MCV_ROW],
        rows[7 * MCV_ROW];
    const mcv_ray_rows near_rays = {rows, rows + 3 * MCV_ROW, rows + 6 * MCV_ROW};
    for (uint number = 0; number < world.frame->solid_count; ++number) {
        const uint shape = mcv_shape(world.solids + number),
                   near = mcv_find_approaching(world, rays, count, number, hits, reaches);
        if (near == 0u) continue;
        if (shape != MCV_SHAPE_OTHER && 2u * near >= count) {
            mcv_intersect_solid_row(world, rays, number, shape, count, t, pieces);
        } else {
            /* Fewer than half of the rays, or long iterations: only those that may hit it. */
            mcv_compact_rows(reaches, rays.origin, 3, MCV_ROW, count, rows);
            mcv_compact_rows(reaches, rays.direction, 3, MCV_ROW, count, rows + 3 * MCV_ROW);
            mcv_compact_row(reaches, rays.origin_surface, count, rows + 6 * MCV_ROW);
            mcv_intersect_solid_row(world, near_rays, number, shape, near, near_t, near_pieces);
            mcv_expand_row(reaches, near_t, count, t);
            mcv_expand_row(reaches, near_pieces, count, pieces);
        }
        mcv_take_exact_hits(world, t, pieces, number, count, reaches, hits);
    }
}

#endif
