/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The origin of the ray that leaves a hit, with error bounds instead of an epsilon (Pharr, Jakob
 * and Humphreys, Physically Based Rendering, "Managing Rounding Error"). u = 2^-24, γ(n) = n u / (1
 * - n u).
 */
#ifndef MCVISI_OFFSET_H
#define MCVISI_OFFSET_H

#include "mcvisi/vector.h"

#define MCV_UNIT_ROUNDOFF 5.9604644775390625e-8f
#define MCV_GAMMA(n) ((n)*MCV_UNIT_ROUNDOFF / (1.0f - (n)*MCV_UNIT_ROUNDOFF))

/*
 * The point with barycentric weights u of b and v of c on the triangle (a, b, c). *error gets a
 * bound, per coordinate, of its distance from the triangle's plane. The weights add up to 1 within
 * 2u, which moves the point by at most 2u Σ|b_i p_i|; products and sums round three times. The
 * bound is the book's γ(7) Σ|b_i p_i|, which is larger and leaves room for transformed vertices.
 */
MCV_FUNCTION mcv_vec3 mcv_hit_point(mcv_vec3 a, mcv_vec3 b, mcv_vec3 c, float u, float v,
                                    mcv_vec3 *error) {
    const float w = 1.0f - u - v;
    const float g = MCV_GAMMA(7);
    *error = mcv_vec(g * (mcv_abs(w * a.x) + mcv_abs(u * b.x) + mcv_abs(v * c.x)),
                     g * (mcv_abs(w * a.y) + mcv_abs(u * b.y) + mcv_abs(v * c.y)),
                     g * (mcv_abs(w * a.z) + mcv_abs(u * b.z) + mcv_abs(v * c.z)));
    return mcv_along(mcv_along(mcv_scale(a, w), u, b), v, c);
}

/* x + offset, and from there the next float in the direction of the offset. */
MCV_LOOP_FUNCTION float mcv_step_aside(float x, float offset) {
    const float moved = x + offset;
    /* A larger bit pattern is a number further from 0. */
    const uint away =
        as_uint(moved) + (((as_uint(moved) ^ as_uint(offset)) >> 31) != 0u ? 0xffffffffu : 1u);
    const uint next = moved == 0.0f ? (as_uint(offset) & 0x80000000u) | 1u : away;
    return offset == 0.0f ? moved : as_float(next);
}

/*
 * The origin of a ray that leaves a surface. The point moves along the unit geometric normal, to
 * the side of the direction, until its error box lies wholly on that side. The last step to the
 * next float covers the rounding of the sum.
 */
MCV_LOOP_FUNCTION mcv_vec3 mcv_offset_origin(mcv_vec3 point, mcv_vec3 error, mcv_vec3 normal,
                                             mcv_vec3 direction) {
    const float reach =
        mcv_abs(normal.x) * error.x + mcv_abs(normal.y) * error.y + mcv_abs(normal.z) * error.z;
    const float distance = mcv_dot(direction, normal) < 0.0f ? -reach : reach;
    return mcv_vec(mcv_step_aside(point.x, distance * normal.x),
                   mcv_step_aside(point.y, distance * normal.y),
                   mcv_step_aside(point.z, distance * normal.z));
}

#endif
