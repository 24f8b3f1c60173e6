/* SPDX-License-Identifier: Apache-2.0 */
/* Mixed precision (geometry/precise.h): where a ray meets a surface, in double. */
#ifndef MCVISI_KERNELS_PRECISE_SURFACE_H
#define MCVISI_KERNELS_PRECISE_SURFACE_H

#include "geometry/double.h"
#include "geometry/interaction.h"

#if MCV_WITH_MIXED
/* Where a ray meets a surface. */
typedef struct mcv_precise_interaction {
    mcv_dvec point, ng, ns; /* [m]; normals unit, on the ray's side */
    double distance;        /* from the ray's origin [m] */
    int found;
} mcv_precise_interaction;

MCV_FUNCTION mcv_dvec mcv_whole_vertex(__global const float *vectors, __global const float *rests,
                                       uint vertex) {
    return mcv_whole(mcv_vertex_vector(vectors, vertex), mcv_vertex_vector(rests, vertex));
}

/* With its plane; the weights of the corners reach beyond it by as much as the ray in floats is
 * beside the precise one. */
static mcv_precise_interaction
mcv_intersect_triangle_precisely(mcv_world world, const mcv_surface *surface, mcv_precise_ray ray) {
    mcv_precise_interaction met;
    const mcv_corners corners = surface->corners;
    const mcv_dvec a = mcv_whole_vertex(world.positions, world.position_lows, corners.x);
    const mcv_dvec b =
        mcv_sub_d(mcv_whole_vertex(world.positions, world.position_lows, corners.y), a);
    const mcv_dvec c =
        mcv_sub_d(mcv_whole_vertex(world.positions, world.position_lows, corners.z), a);
    const mcv_dvec doubled = mcv_cross_d(b, c);
    met.distance = mcv_dot_d(mcv_sub_d(a, ray.origin), doubled) / mcv_dot_d(ray.direction, doubled);
    met.found = fabs(met.distance) < (double)INFINITY;
    met.point = mcv_along_d(ray.origin, met.distance, ray.direction);
    met.ng = mcv_normalize_d(doubled);
    met.ns = met.ng;
#if MCV_WITH_NORMALS
    const mcv_dvec from = mcv_sub_d(met.point, a);
    const double squared = mcv_dot_d(doubled, doubled);
    const double u = mcv_dot_d(mcv_cross_d(from, c), doubled) / squared;
    const double v = mcv_dot_d(mcv_cross_d(b, from), doubled) / squared;
    mcv_dvec n =
        mcv_scale_d(mcv_whole_vertex(world.normals, world.normal_lows, corners.x), 1.0 - u - v);
    n = mcv_along_d(n, u, mcv_whole_vertex(world.normals, world.normal_lows, corners.y));
    n = mcv_along_d(n, v, mcv_whole_vertex(world.normals, world.normal_lows, corners.z));
    if (mcv_dot_d(n, n) > 0.0) met.ns = mcv_normalize_d(n);
#endif
    return met;
}

/* How far p is outside of a piece, times the length of the gradient, which leads outwards; to first
 * order. */
MCV_FUNCTION double mcv_precise_gradient(mcv_world world, uint number, uint piece, mcv_dvec p,
                                         mcv_dvec *gradient) {
    __global const mcv_device_solid *solid = world.solids + number;
    __global const mcv_precise_solid *precise = world.precise_solids + number;
    if (piece == MCV_PIECE_SIDE && solid->side == MCV_SIDE_BOX) {
        const double x = fabs(p.x) - precise->extent[0], y = fabs(p.y) - precise->extent[1];
        *gradient = x > y ? mcv_dvec_of(p.x < 0.0 ? -1.0 : 1.0, 0.0, 0.0)
                          : mcv_dvec_of(0.0, p.y < 0.0 ? -1.0 : 1.0, 0.0);
        return x > y ? x : y;
    }
    if (piece == MCV_PIECE_SIDE) {
        const double z = solid->side == MCV_SIDE_SPHERE ? p.z : 0.0, r = precise->radius;
        *gradient = mcv_dvec_of(p.x / r, p.y / r, z / r);
        return 0.5 * fma(p.x, p.x, fma(p.y, p.y, fma(z, z, -r * r))) / r;
    }
    __global const mcv_precise_cap *cap = precise->cap + piece;
    const double sign = piece == MCV_PIECE_FIRST_CAP ? 1.0 : -1.0;
    const double w = (double)solid->cap[piece].across, c = cap->curvature, e = 1.0 + cap->conic;
    const double z = p.z - cap->z;
    const double r2 = fma(w * p.x, p.x, p.y * p.y);
    const uint terms = solid->cap[piece].terms;
    if (terms == 0u) {
        *gradient = mcv_dvec_of(sign * c * w * p.x, sign * c * p.y, sign * fma(e * c, z, -1.0));
        return sign * fma(0.5 * c, fma(e * z, z, r2), -z);
    }
    const double under = fma(-e * c * c, r2, 1.0);
    const double root = sqrt(under > 0.0 ? under : 0.0), u = cap->scale * r2;
    double value = 0.0, slope = 0.0;
    for (uint i = terms; i > 0; --i) {
        slope = fma(slope, u, (double)(i + 1u) * cap->term[i - 1u]);
        value = fma(value, u, cap->term[i - 1u]);
    }
    slope = 2.0 * fma(slope * u, cap->scale, 0.5 * c / root);
    *gradient = mcv_dvec_of(sign * slope * w * p.x, sign * slope * p.y, -sign);
    return sign * (c * r2 / (1.0 + root) + value * u * u - z);
}

MCV_FUNCTION mcv_dvec mcv_into_frame_d(__global const double *m, mcv_dvec v) {
    return mcv_dvec_of(mcv_dot_d(mcv_dvec_of(m[0], m[1], m[2]), v),
                       mcv_dot_d(mcv_dvec_of(m[3], m[4], m[5]), v),
                       mcv_dot_d(mcv_dvec_of(m[6], m[7], m[8]), v));
}

MCV_FUNCTION mcv_dvec mcv_out_of_frame_d(__global const double *m, mcv_dvec v) {
    const mcv_dvec x = mcv_scale_d(mcv_dvec_of(m[0], m[1], m[2]), v.x);
    return mcv_along_d(mcv_along_d(x, v.y, mcv_dvec_of(m[3], m[4], m[5])), v.z,
                       mcv_dvec_of(m[6], m[7], m[8]));
}

/*
 * Newton's steps from where the ray in floats meets it: each squares the error, of 2^-20 or so
 * before the first. Found is what lies on the surface but for the rounding of the place, the sum of
 * a few products of numbers up to `reach`.
 */
#define MCV_NEWTON_STEPS 4
MCV_FUNCTION mcv_precise_interaction mcv_intersect_solid_precisely(mcv_world world, uint primitive,
                                                                   mcv_precise_ray ray,
                                                                   double near) {
    mcv_precise_interaction met;
    const uint number = mcv_solid_of(primitive), piece = mcv_piece_of(primitive);
    __global const mcv_precise_solid *solid = world.precise_solids + number;
    const mcv_dvec origin = mcv_dvec_of(solid->origin[0], solid->origin[1], solid->origin[2]);
    const mcv_dvec from = mcv_into_frame_d(solid->axes, mcv_sub_d(ray.origin, origin));
    const mcv_dvec d = mcv_into_frame_d(solid->axes, ray.direction);
    const double reach = fabs(from.x) + fabs(from.y) + fabs(from.z) + fabs(near) +
                         (double)world.solids[number].bound;
    mcv_dvec gradient, p;
    met.found = 0;
    met.distance = near;
    for (int i = 0; i <= MCV_NEWTON_STEPS; ++i) {
        p = mcv_along_d(from, met.distance, d);
        const double outside = mcv_precise_gradient(world, number, piece, p, &gradient);
        met.found = outside * outside <= 0x1p-96 * reach * reach * mcv_dot_d(gradient, gradient);
        if (met.found) break;
        met.distance -= outside / mcv_dot_d(gradient, d);
    }
    met.point = mcv_add_d(origin, mcv_out_of_frame_d(solid->axes, p));
    met.ns = met.ng = mcv_normalize_d(mcv_out_of_frame_d(solid->axes, gradient));
    return met;
}

/* t: of the ray in floats, whose origin is `low` before the precise one. */
static mcv_precise_interaction mcv_intersect_precisely(mcv_world world,
                                                       const mcv_interaction *interaction,
                                                       mcv_precise_ray ray, mcv_vec3 low, float t) {
    mcv_precise_interaction met;
    if (mcv_is_exact(interaction->surface.primitive))
        met = mcv_intersect_solid_precisely(world, interaction->surface.primitive, ray,
                                            (double)t - mcv_dot_d(mcv_widen(low), ray.direction));
    else
        met = mcv_intersect_triangle_precisely(world, &interaction->surface, ray);
    const uint back_face = mcv_dot_d(ray.direction, met.ng) > 0.0;
    const double sign = back_face ? -1.0 : 1.0;
    met.found = met.found && back_face == interaction->back_face;
    met.ng = mcv_scale_d(met.ng, sign);
    met.ns = mcv_scale_d(met.ns, sign);
    if (!(mcv_dot_d(ray.direction, met.ns) < 0.0)) met.ns = met.ng;
    return met;
}
#endif

#endif
