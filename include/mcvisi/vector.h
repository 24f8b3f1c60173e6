/* SPDX-License-Identifier: Apache-2.0 */
/* Vectors of three floats for device and host. The members are scalars, because a float3 of OpenCL
 * has four lanes and another layout than the host's. */
#ifndef MCVISI_VECTOR_H
#define MCVISI_VECTOR_H

#include "mcvisi/dialect.h"

typedef struct mcv_vec3 {
    float x, y, z;
} mcv_vec3;

MCV_FUNCTION mcv_vec3 mcv_vec(float x, float y, float z) {
    mcv_vec3 v;
    v.x = x;
    v.y = y;
    v.z = z;
    return v;
}

MCV_FUNCTION mcv_vec3 mcv_add(mcv_vec3 a, mcv_vec3 b) {
    return mcv_vec(a.x + b.x, a.y + b.y, a.z + b.z);
}

MCV_FUNCTION mcv_vec3 mcv_sub(mcv_vec3 a, mcv_vec3 b) {
    return mcv_vec(a.x - b.x, a.y - b.y, a.z - b.z);
}

MCV_FUNCTION mcv_vec3 mcv_scale(mcv_vec3 a, float s) { return mcv_vec(a.x * s, a.y * s, a.z * s); }

/* a or b, by components; a conditional jump would prevent vectorisation. */
MCV_FUNCTION mcv_vec3 mcv_either(int condition, mcv_vec3 a, mcv_vec3 b) {
    return mcv_vec(condition ? a.x : b.x, condition ? a.y : b.y, condition ? a.z : b.z);
}

/* a + s b */
MCV_FUNCTION mcv_vec3 mcv_along(mcv_vec3 a, float s, mcv_vec3 b) {
    return mcv_vec(mcv_fma(s, b.x, a.x), mcv_fma(s, b.y, a.y), mcv_fma(s, b.z, a.z));
}

MCV_FUNCTION float mcv_dot(mcv_vec3 a, mcv_vec3 b) {
    return mcv_fma(a.x, b.x, mcv_fma(a.y, b.y, a.z * b.z));
}

/* a b - c d with a relative error of at most 2 u and an exact sign (Kahan; Jeannerod, Louvet and
 * Muller 2013). */
MCV_FUNCTION float mcv_difference_of_products(float a, float b, float c, float d) {
    const float cd = c * d;
    return mcv_fma(a, b, -cd) + mcv_fma(-c, d, cd);
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_cross(mcv_vec3 a, mcv_vec3 b) {
    return mcv_vec(mcv_difference_of_products(a.y, b.z, a.z, b.y),
                   mcv_difference_of_products(a.z, b.x, a.x, b.z),
                   mcv_difference_of_products(a.x, b.y, a.y, b.x));
}

/* v / |v|; the zero vector stays as it is. */
MCV_FUNCTION mcv_vec3 mcv_normalize(mcv_vec3 v) {
    const float squared = mcv_dot(v, v);
    return mcv_scale(v, squared > 0.0f ? 1.0f / mcv_sqrt(squared) : 1.0f);
}

/* Normalises a vector whose length differs from 1 only by rounding, without the bias of a division
 * by a length near 1. */
MCV_FUNCTION mcv_vec3 mcv_renormalize(mcv_vec3 v) {
    return mcv_along(v, mcv_fma(-0.5f, mcv_dot(v, v), 0.5f), v);
}

/*
 * Two unit vectors x and y that form a right-handed frame with the unit vector n: x cross y = n.
 * They are continuous except at n.z = 0 (Duff et al., Building an Orthonormal Basis, Revisited,
 * JCGT 2017).
 */
MCV_FUNCTION void mcv_basis(mcv_vec3 n, mcv_vec3 *x, mcv_vec3 *y) {
    const float sign = n.z < 0.0f ? -1.0f : 1.0f;
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    *x = mcv_vec(mcv_fma(sign * a, n.x * n.x, 1.0f), sign * b, -sign * n.x);
    *y = mcv_vec(b, mcv_fma(a, n.y * n.y, sign), -n.y);
}

/* v given in the frame (x, y, n) of a unit normal n. */
MCV_FUNCTION mcv_vec3 mcv_from_frame(mcv_vec3 v, mcv_vec3 n) {
    mcv_vec3 x, y;
    mcv_basis(n, &x, &y);
    return mcv_along(mcv_along(mcv_scale(n, v.z), v.y, y), v.x, x);
}

#endif
