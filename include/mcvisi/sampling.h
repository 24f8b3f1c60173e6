/* SPDX-License-Identifier: Apache-2.0 */
/* Warps of the unit square that sensors, emitters and materials share. ξ, η lie in [0, 1). */
#ifndef MCVISI_SAMPLING_H
#define MCVISI_SAMPLING_H

#include "mcvisi/vector.h"

#define MCV_PI 3.14159265358979323846f

/* The cell of `count` that holds x in [0, 1]; 1 itself belongs to the last. What rounding puts outside belongs to the nearest. */
MCV_FUNCTION uint mcv_cell(float x, uint count) {
    const float at = x * (float)count;
    const uint i = at > 0.0f ? (uint)at : 0u;
    return i < count ? i : count - 1u;
}

/* sin and cos for |x| <= π/4: Taylor polynomials, absolute error below 8e-8 (no library function: same bits everywhere). */
MCV_FUNCTION float mcv_sin_octant(float x) {
    const float x2 = x * x;
    float p = mcv_fma(x2, 2.7557319e-6f, -1.9841270e-4f);
    p = mcv_fma(x2, p, 8.3333333e-3f);
    p = mcv_fma(x2, p, -1.6666667e-1f);
    return mcv_fma(x * x2, p, x);
}

MCV_FUNCTION float mcv_cos_octant(float x) {
    const float x2 = x * x;
    float p = mcv_fma(x2, 2.4801587e-5f, -1.3888889e-3f);
    p = mcv_fma(x2, p, 4.1666667e-2f);
    p = mcv_fma(x2, p, -0.5f);
    return mcv_fma(x2, p, 1.0f);
}

/*
 * The unit square to the unit disk by area, neighbours staying neighbours (Shirley and Chiu 1997). Writes cos and sin of
 * the angle, returns the radius in [0, 1].
 */
MCV_LOOP_FUNCTION float mcv_disk(float xi, float eta, float *cosine, float *sine) {
    const float a = mcv_fma(2.0f, xi, -1.0f);
    const float b = mcv_fma(2.0f, eta, -1.0f);
    const int wide = mcv_abs(a) > mcv_abs(b);
    const float radius = wide ? a : b;
    const float ratio = radius != 0.0f ? (wide ? b : a) / radius : 0.0f;
    const float angle = 0.25f * MCV_PI * ratio;
    const float near = mcv_cos_octant(angle);
    const float off = mcv_sin_octant(angle);
    const float sign = radius < 0.0f ? -1.0f : 1.0f;
    *cosine = sign * (wide ? near : off);
    *sine = sign * (wide ? off : near);
    return mcv_abs(radius);
}

/* A direction about +z with density cosθ/π. */
MCV_FUNCTION mcv_vec3 mcv_sample_cosine(float xi, float eta) {
    float cosine, sine;
    const float r = mcv_disk(xi, eta, &cosine, &sine);
    return mcv_vec(r * cosine, r * sine, mcv_sqrt(mcv_fma(-r, r, 1.0f)));
}

/*
 * A direction about +z, uniform in the solid angle 4π sin²(β/2) of a cone of half-angle β; sin_half = sin(β/2).
 * Stable down to the smallest cones: a float32 cosine cannot tell 0.02° from 0.
 */
MCV_FUNCTION mcv_vec3 mcv_sample_cone(float sin_half, float xi, float eta) {
    float cosine, sine;
    const float s = sin_half * mcv_disk(xi, eta, &cosine, &sine);
    const float sin_theta = 2.0f * s * mcv_sqrt(mcv_fma(-s, s, 1.0f));
    return mcv_vec(sin_theta * cosine, sin_theta * sine, mcv_fma(-2.0f * s, s, 1.0f));
}

#endif
