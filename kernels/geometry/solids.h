/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ray against exact surfaces (mcvisi/surfaces/solid.h).
 *
 * Most solids are discs, balls, boxes and cylinders with conics as caps. Their functions choose
 * between values and do not jump, so that the tile schedule tests many rays at once.
 */
#ifndef MCVISI_KERNELS_SOLIDS_H
#define MCVISI_KERNELS_SOLIDS_H

#include "geometry/caps.h"
#include "geometry/solid_ray.h"

enum { MCV_SHAPE_DISC, MCV_SHAPE_BALL, MCV_SHAPE_BOX, MCV_SHAPE_CONICS, MCV_SHAPE_OTHER };

MCV_FUNCTION uint mcv_shape(__global const mcv_device_solid *solid) {
    if (solid->side == MCV_SIDE_SPHERE) return MCV_SHAPE_BALL;
    if (solid->side == MCV_SIDE_OPEN && solid->cap[0].terms == 0u &&
        solid->cap[0].curvature == 0.0f)
        return MCV_SHAPE_DISC;
    if (solid->side == MCV_SIDE_BOX) return MCV_SHAPE_BOX;
    if (solid->side == MCV_SIDE_CYLINDER && solid->cap[0].terms == 0u && solid->cap[1].terms == 0u)
        return MCV_SHAPE_CONICS;
    return MCV_SHAPE_OTHER;
}

/* A disc is a plane: of all there is to know of it little is needed, and stops stand in the way of
 * most rays. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_disc(__global const mcv_device_solid *solid,
                                                   mcv_solid_ray ray) {
    mcv_piece_hit met;
    const float at = (solid->cap[0].z - ray.p.z) / ray.d.z;
    const mcv_vec3 there = mcv_along(ray.p, at, ray.d);
    const float squared = mcv_fma(there.x, there.x, there.y * there.y);
    const int ahead = !ray.on[0] & (at > -ray.shift) & (at < INFINITY);
    const int within =
        (squared <= solid->radius * solid->radius) & (squared >= solid->hole * solid->hole);
    met.t = (ahead & within) ? ray.shift + at : INFINITY;
    met.piece = MCV_PIECE_FIRST_CAP;
    return met;
}

/* A ball is all side. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_ball(__global const mcv_device_solid *solid,
                                                   mcv_solid_ray ray) {
    const mcv_span side = mcv_sphere_span(solid->radius, ray.p, ray.d, ray.on[2], ray.up);
    const float start = -ray.shift;
    const int enters = ray.on[2] ? side.enter >= start : side.enter > start,
              leaves = ray.on[2] ? side.exit >= start : side.exit > start;
    const float first = enters ? side.enter : leaves ? side.exit : INFINITY;
    const int misses = ray.away | !(side.enter <= side.exit);
    mcv_piece_hit met;
    met.t = misses ? INFINITY : ray.shift + (ray.inside ? mcv_span_end(side) : first);
    met.piece = MCV_PIECE_SIDE;
    return met;
}

/* Two conics within a side. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_conics(__global const mcv_device_solid *solid,
                                                     mcv_solid_ray ray, mcv_span side) {
    const float within = mcv_within(side, solid->bound);
    const mcv_span first = mcv_conic_above(solid->cap, mcv_from_vertex(ray.p, solid->cap), ray.d,
                                           within, ray.on[0], ray.up);
    const mcv_span second = mcv_conic_above(solid->cap + 1, mcv_from_vertex(ray.p, solid->cap + 1),
                                            ray.d, within, ray.on[1], ray.up);
    return mcv_intersect_spans(ray, first, mcv_span_of(second.exit, second.enter), side);
}

MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_shape(__global const mcv_device_solid *solid,
                                                    uint shape, mcv_solid_ray ray) {
    if (shape == MCV_SHAPE_DISC) return mcv_intersect_disc(solid, ray);
    if (shape == MCV_SHAPE_BALL) return mcv_intersect_ball(solid, ray);
    if (shape == MCV_SHAPE_BOX)
        return mcv_intersect_conics(solid, ray,
                                    mcv_box_span(solid->extent, ray.p, ray.d, ray.on[2], ray.up));
    return mcv_intersect_conics(solid, ray,
                                mcv_cylinder_span(solid->radius, ray.p, ray.d, ray.on[2], ray.up));
}

/* Replaces *hit by a closer one; one at the same distance on the same surface is kept beside it:
 * the two bodies are in contact. */
MCV_FUNCTION void mcv_take_exact_hit(mcv_world world, float t, uint number, uint piece,
                                     mcv_hit *hit) {
    const uint here = mcv_exact_hit(number, piece);
    if (t < hit->t) {
        hit->t = t;
        hit->u = hit->v = 0.0f;
        hit->primitive = here;
    } else if (t == hit->t && hit->primitive != MCV_NONE && hit->primitive >= MCV_EXACT &&
               mcv_exact_surface(world, hit->primitive) == mcv_exact_surface(world, here)) {
        hit->u = (float)(number + 1u);
    }
}

/* A curved surface by itself: both places where a ray meets its cap may lie within the side. */
MCV_FUNCTION mcv_piece_hit mcv_intersect_open(__global const mcv_device_solid *solid,
                                              const mcv_solid_ray *ray, mcv_span side) {
    mcv_piece_hit met;
    const mcv_span above = mcv_cap_above(solid, 0u, ray, side);
    const float at[2] = {above.enter, above.exit};
    const float start = -ray->shift;
    met.t = INFINITY;
    met.piece = MCV_PIECE_FIRST_CAP;
    for (int k = 0; k < 2; ++k) {
        const mcv_vec3 there = mcv_along(ray->p, at[k], ray->d);
        if (!(mcv_abs(at[k]) < INFINITY) || !(ray->on[0] ? at[k] >= start : at[k] > start) ||
            !mcv_span_holds(side, at[k]))
            continue;
        if (mcv_fma(there.x, there.x, there.y * there.y) < solid->hole * solid->hole) continue;
        if (ray->shift + at[k] < met.t) met.t = ray->shift + at[k];
    }
    return met;
}

MCV_FUNCTION mcv_piece_hit mcv_intersect_other(__global const mcv_device_solid *solid,
                                               const mcv_solid_ray *ray) {
    const mcv_span side = mcv_cylinder_span(solid->radius, ray->p, ray->d, ray->on[2], ray->up);
    if (ray->away || !(side.enter <= side.exit)) {
        const mcv_piece_hit none = {INFINITY, 0u};
        return none;
    }
    if (solid->side == MCV_SIDE_OPEN) return mcv_intersect_open(solid, ray, side);
    const mcv_span above = mcv_cap_above(solid, 0u, ray, side);
    const mcv_span second = mcv_cap_above(solid, 1u, ray, side);
    return mcv_intersect_spans(*ray, above, mcv_span_of(second.exit, second.enter), side);
}

MCV_FUNCTION void mcv_intersect_solid(mcv_world world, uint number, mcv_vec3 origin,
                                      mcv_vec3 direction, uint origin_surface, mcv_hit *hit) {
    __global const mcv_device_solid *solid = world.solids + number;
    if (!mcv_reaches_solid(solid, origin, direction, hit->t)) return;
    const mcv_solid_ray ray = mcv_make_solid_ray(world, number, origin, direction, origin_surface);
    const uint shape = mcv_shape(solid);
    const mcv_piece_hit met = shape == MCV_SHAPE_OTHER ? mcv_intersect_other(solid, &ray)
                                                       : mcv_intersect_shape(solid, shape, ray);
    mcv_take_exact_hit(world, met.t, number, met.piece, hit);
}

/* The closer of a hit (or miss, with its t_max) on triangles and one on exact surfaces. */
static inline __attribute__((noinline)) mcv_hit
mcv_intersect_solids(mcv_world world, mcv_vec3 origin, mcv_vec3 direction, uint origin_surface,
                     mcv_hit hit) {
    for (uint i = 0; i < world.frame->solid_count; ++i)
        mcv_intersect_solid(world, i, origin, direction, origin_surface, &hit);
    return hit;
}

/* The same along a way of any length, in which distances are. */
MCV_FUNCTION mcv_hit mcv_intersect_solids_along(mcv_world world, mcv_vec3 origin, mcv_vec3 way,
                                                uint origin_surface, mcv_hit hit) {
    const float length = mcv_sqrt(mcv_dot(way, way));
    mcv_hit unit = hit;
    unit.t *= length;
    unit = mcv_intersect_solids(world, origin, mcv_scale(way, 1.0f / length), origin_surface, unit);
    if (unit.primitive != hit.primitive) {
        hit = unit;
        hit.t /= length;
    }
    return hit;
}

#endif
