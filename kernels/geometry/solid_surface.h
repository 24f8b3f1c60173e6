/* SPDX-License-Identifier: Apache-2.0 */
/* What lies where a ray hits an exact surface. */
#ifndef MCVISI_KERNELS_SOLID_SURFACE_H
#define MCVISI_KERNELS_SOLID_SURFACE_H

#include "geometry/solid_ray.h"
#include "geometry/surface.h"

/* The unit gradient of a piece's equation at p, outwards, and how far p lies outside of it; of a
 * conic, a cylinder or a ball. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_quadric_gradient(__global const mcv_device_solid *solid, uint piece,
                                                mcv_vec3 p, float *outside) {
    const int side = piece == MCV_PIECE_SIDE;
    const mcv_vec3 out = mcv_vec(p.x, p.y, solid->side == MCV_SIDE_SPHERE ? p.z : 0.0f);
    const float distance = mcv_sqrt(mcv_dot(out, out)) - solid->radius;
    __global const mcv_device_cap *cap = solid->cap + (side ? 0u : piece);
    const float w = cap->across, c = cap->curvature, e = 1.0f + cap->conic;
    const float z = p.z - cap->z;
    const mcv_vec3 down =
        mcv_vec(c * w * p.x, c * p.y, mcv_fma(e * c, z, -1.0f)); /* towards the height's fall */
    const float height = z - 0.5f * c * mcv_fma(w * p.x, p.x, mcv_fma(p.y, p.y, e * z * z));
    const float inverse = 1.0f / mcv_sqrt(mcv_dot(down, down));
    const float sign = piece == MCV_PIECE_FIRST_CAP ? inverse : -inverse;
    *outside = side ? distance : -height * sign;
    return mcv_either(side, mcv_normalize(out), mcv_scale(down, sign));
}

MCV_FUNCTION int mcv_is_quadric(__global const mcv_device_solid *solid, uint piece) {
    return piece == MCV_PIECE_SIDE ? solid->side != MCV_SIDE_BOX : solid->cap[piece].terms == 0u;
}

/* The same of any piece. */
MCV_FUNCTION mcv_vec3 mcv_piece_gradient(__global const mcv_device_solid *solid, uint piece,
                                         mcv_vec3 p, float *outside) {
    if (mcv_is_quadric(solid, piece)) return mcv_quadric_gradient(solid, piece, p, outside);
    if (piece == MCV_PIECE_SIDE) {
        const float x = mcv_abs(p.x) - solid->extent[0], y = mcv_abs(p.y) - solid->extent[1];
        *outside = fmax(x, y);
        return x > y ? mcv_vec(p.x < 0.0f ? -1.0f : 1.0f, 0.0f, 0.0f)
                     : mcv_vec(0.0f, p.y < 0.0f ? -1.0f : 1.0f, 0.0f);
    }
    __global const mcv_device_cap *cap = solid->cap + piece;
    float at;
    const float slope = 2.0f * mcv_cap_slope(cap, mcv_fma(cap->across * p.x, p.x, p.y * p.y), &at);
    const mcv_vec3 down = mcv_vec(slope * cap->across * p.x, slope * p.y, -1.0f);
    const float inverse = 1.0f / mcv_sqrt(mcv_dot(down, down));
    const float sign = piece == MCV_PIECE_FIRST_CAP ? inverse : -inverse;
    *outside = (at - (p.z - cap->z)) * sign;
    return mcv_scale(down, sign);
}

/* The place on a piece; where it is a quadric without conditional jumps. */
MCV_LOOP_FUNCTION mcv_surface mcv_exact_surface_on(mcv_world world, uint met, float u,
                                                   mcv_vec3 origin, mcv_vec3 direction, float t,
                                                   int quadric) {
    const uint number = mcv_solid_of(met), piece = mcv_piece_of(met);
    __global const mcv_device_solid *solid = world.solids + number;
    mcv_surface surface;
    float outside;
    mcv_vec3 p = mcv_into_frame(solid, mcv_along(mcv_from_middle(solid, origin), t, direction));
    mcv_vec3 normal = quadric ? mcv_quadric_gradient(solid, piece, p, &outside)
                              : mcv_piece_gradient(solid, piece, p, &outside);
    /* What t has rounded: back along the ray, or straight onto a surface that it grazes. */
    const mcv_vec3 d = mcv_into_frame(solid, direction);
    const float slant = mcv_dot(d, normal);
    p = mcv_either(mcv_abs(slant) > 0.25f, mcv_along(p, -outside / slant, d),
                   mcv_along(p, -outside, normal));
    normal = quadric ? mcv_quadric_gradient(solid, piece, p, &outside)
                     : mcv_piece_gradient(solid, piece, p, &outside);
    surface.point = mcv_add(mcv_vec(solid->origin[0], solid->origin[1], solid->origin[2]),
                            mcv_out_of_frame(solid, p));
    surface.error = mcv_vec(0.0f, 0.0f, 0.0f); /* a ray knows the surface that it starts on */
    surface.ng = surface.ns = mcv_renormalize(mcv_out_of_frame(solid, normal));
    surface.area = 0.0f;
    surface.primitive = met;
    surface.instance = solid->instance[piece];
    surface.u = u;
    surface.v = 0.0f;
    surface.corners.x = surface.corners.y = surface.corners.z = 0u;
    surface.corners.w = surface.instance;
    return surface;
}

MCV_FUNCTION mcv_surface mcv_exact_surface_at(mcv_world world, uint met, float u, mcv_vec3 origin,
                                              mcv_vec3 direction, float t) {
    return mcv_exact_surface_on(world, met, u, origin, direction, t, 0);
}

/* What a ray remembers that leaves a surface in this direction. */
MCV_LOOP_FUNCTION uint mcv_mark_origin_surface(mcv_world world, mcv_surface surface,
                                               mcv_vec3 direction) {
    if (!mcv_is_exact(surface.primitive)) return MCV_NONE;
    const uint outwards = mcv_dot(direction, surface.ng) > 0.0f;
    return mcv_exact_surface(world, surface.primitive) << 1 |
           (mcv_piece_of(surface.primitive) == MCV_PIECE_FIRST_CAP ? 1u - outwards : outwards);
}

#endif
