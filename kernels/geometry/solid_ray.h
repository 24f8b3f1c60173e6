/* SPDX-License-Identifier: Apache-2.0 */
/* A ray in a solid's frame, and the first of the pieces that it hits. */
#ifndef MCVISI_KERNELS_SOLID_RAY_H
#define MCVISI_KERNELS_SOLID_RAY_H

#include "geometry/caps.h"

MCV_LOOP_FUNCTION mcv_vec3 mcv_into_frame(__global const mcv_device_solid *solid, mcv_vec3 v) {
    __global const float *m = solid->axes;
    return mcv_vec(mcv_dot(mcv_vec(m[0], m[1], m[2]), v), mcv_dot(mcv_vec(m[3], m[4], m[5]), v),
                   mcv_dot(mcv_vec(m[6], m[7], m[8]), v));
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_out_of_frame(__global const mcv_device_solid *solid, mcv_vec3 v) {
    __global const float *m = solid->axes;
    return mcv_along(
        mcv_along(mcv_scale(mcv_vec(m[0], m[1], m[2]), v.x), v.y, mcv_vec(m[3], m[4], m[5])), v.z,
        mcv_vec(m[6], m[7], m[8]));
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_from_middle(__global const mcv_device_solid *solid, mcv_vec3 point) {
    return mcv_sub(point, mcv_vec(solid->origin[0], solid->origin[1], solid->origin[2]));
}

MCV_LOOP_FUNCTION uint mcv_surface_of_piece(__global const mcv_device_solid *solid, uint number,
                                            uint piece) {
    return piece == MCV_PIECE_SIDE ? 4u * number + piece : solid->cap[piece].surface;
}

/* The surface of the piece that a hit is on. */
MCV_LOOP_FUNCTION uint mcv_exact_surface(mcv_world world, uint hit) {
    const uint number = mcv_solid_of(hit);
    return mcv_surface_of_piece(world.solids + number, number, mcv_piece_of(hit));
}

/* A ray in a solid's frame: the place `shift` along it is p. */
typedef struct mcv_solid_ray {
    mcv_vec3 p, d;
    float shift;
    int on[MCV_PIECE_COUNT]; /* 1: it starts on that piece */
    int up;                  /* and goes to +z of a cap or out of the side */
    int inside;              /* it goes inwards from a piece */
    int away;                /* it cannot meet the solid again */
} mcv_solid_ray;

/* All solids of a lens take the ray from the same place: what they share is met at the same
 * distance, to the last bit. */
MCV_LOOP_FUNCTION mcv_solid_ray mcv_make_solid_ray(mcv_world world, uint number, mcv_vec3 origin,
                                                   mcv_vec3 direction, uint origin_surface) {
    __global const mcv_device_solid *solid = world.solids + number;
    mcv_solid_ray ray;
    const mcv_vec3 from = mcv_from_middle(solid, origin);
    const float nearest = -mcv_dot(from, direction);
    const uint started = origin_surface == MCV_NONE ? number : origin_surface >> 3;
    const int here = (origin_surface != MCV_NONE) & (world.solids[started].group == solid->group);
    ray.up = (int)(origin_surface & 1u);
    ray.on[0] = here & (origin_surface >> 1 == mcv_surface_of_piece(solid, number, 0u));
    ray.on[1] = here & (origin_surface >> 1 == mcv_surface_of_piece(solid, number, 1u));
    ray.on[2] = here & (origin_surface >> 1 == mcv_surface_of_piece(solid, number, 2u));
    ray.inside = (ray.on[0] & ray.up) | (ray.on[1] & !ray.up) | (ray.on[2] & !ray.up);
    ray.away = (solid->convex != 0u) &
               ((ray.on[0] & !ray.up) | (ray.on[1] & ray.up) | (ray.on[2] & ray.up));
    ray.shift = here ? 0.0f : nearest;
    ray.p = mcv_into_frame(solid, mcv_either(here, from, mcv_along(from, nearest, direction)));
    ray.d = mcv_into_frame(solid, direction);
    return ray;
}

/* Does a ray meet the ball that holds the solid, before it ends? */
MCV_LOOP_FUNCTION int mcv_reaches_solid(__global const mcv_device_solid *solid, mcv_vec3 origin,
                                        mcv_vec3 direction, float end) {
    const mcv_vec3 from = mcv_from_middle(solid, origin);
    const float nearest = -mcv_dot(from, direction);
    const mcv_vec3 foot = mcv_along(from, nearest, direction);
    const int misses =
        (mcv_dot(foot, foot) > solid->bound * solid->bound) | (nearest + solid->bound < 0.0f);
    return !(misses | (nearest - solid->bound > end));
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_from_vertex(mcv_vec3 p, __global const mcv_device_cap *cap) {
    return mcv_vec(p.x, p.y, p.z - cap->z);
}

/* A place on the ray within the side and the solid's ball. */
MCV_LOOP_FUNCTION float mcv_within(mcv_span side, float bound) {
    return 0.5f * ((side.enter > -2.0f * bound ? side.enter : -2.0f * bound) +
                   (side.exit < 2.0f * bound ? side.exit : 2.0f * bound));
}

MCV_FUNCTION mcv_span mcv_cap_above(__global const mcv_device_solid *solid, uint k,
                                    const mcv_solid_ray *ray, mcv_span side) {
    __global const mcv_device_cap *cap = solid->cap + k;
    const mcv_vec3 p = mcv_from_vertex(ray->p, cap);
    if (cap->terms == 0u)
        return mcv_conic_above(cap, p, ray->d, mcv_within(side, solid->bound), ray->on[k], ray->up);
    const float low = fmax(side.enter, fmax(-ray->shift, -solid->bound));
    const float high = fmin(side.exit, 2.0f * solid->bound);
    return mcv_asphere_above(cap, solid->bound, p, ray->d, low, high, ray->on[k], ray->up);
}

/* Where a ray meets a solid, and its piece; t is infinite where it does not. */
typedef struct mcv_piece_hit {
    float t;
    uint piece;
} mcv_piece_hit;

/* A crossing of one span's end where the two others hold, if it is the first one so far. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_earlier(mcv_piece_hit first, float at, uint piece, float start,
                                            int on, mcv_span a, mcv_span b) {
    const int ahead = on ? at >= start : at > start;
    const int counts = ahead & (at < first.t) & mcv_span_holds(a, at) & mcv_span_holds(b, at);
    first.t = counts ? at : first.t;
    first.piece = counts ? piece : first.piece;
    return first;
}

MCV_LOOP_FUNCTION mcv_piece_hit mcv_earlier_end(mcv_piece_hit first, mcv_span span, uint piece) {
    const float end = mcv_span_end(span);
    const int counts = end < first.t;
    first.t = counts ? end : first.t;
    first.piece = counts ? piece : first.piece;
    return first;
}

/* `above` the first cap, `below` the second one. */
MCV_LOOP_FUNCTION mcv_piece_hit mcv_intersect_spans(mcv_solid_ray ray, mcv_span above,
                                                    mcv_span below, mcv_span side) {
    const float start = -ray.shift;
    mcv_piece_hit none, first, end;
    none.t = INFINITY;
    none.piece = 0u;
    /* A ray that goes inwards from its surface is inside: it leaves where the first of them ends.
     */
    end = mcv_earlier_end(none, above, MCV_PIECE_FIRST_CAP);
    end = mcv_earlier_end(end, below, MCV_PIECE_SECOND_CAP);
    end = mcv_earlier_end(end, side, MCV_PIECE_SIDE);
    /* Where one begins and the others hold, or, from inside, where one ends. What is as thin as
     * rounding begins first. */
    first = mcv_earlier(none, above.enter, MCV_PIECE_FIRST_CAP, start, ray.on[0], below, side);
    first = mcv_earlier(first, below.enter, MCV_PIECE_SECOND_CAP, start, ray.on[1], side, above);
    first = mcv_earlier(first, side.enter, MCV_PIECE_SIDE, start, ray.on[2], above, below);
    first = mcv_earlier(first, above.exit, MCV_PIECE_FIRST_CAP, start, ray.on[0], below, side);
    first = mcv_earlier(first, below.exit, MCV_PIECE_SECOND_CAP, start, ray.on[1], side, above);
    first = mcv_earlier(first, side.exit, MCV_PIECE_SIDE, start, ray.on[2], above, below);
    const int misses = ray.away | !(side.enter <= side.exit);
    first.t = misses ? INFINITY : ray.shift + (ray.inside ? end.t : first.t);
    first.piece = ray.inside ? end.piece : first.piece;
    return first;
}

#endif
