/* SPDX-License-Identifier: Apache-2.0 */
/* Warps of the unit square that sensors, emitters and materials share, ξ and η in [0, 1), and
 * hashes.
 */
#ifndef MCVISI_SAMPLING_H
#define MCVISI_SAMPLING_H

#include "mcvisi/vector.h"

#define MCV_PI 3.14159265358979323846f

/* A bijection of 32 bits without visible structure (Wellons' search, "lowbias32"). */
MCV_FUNCTION uint mcv_hash(uint x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

MCV_FUNCTION uint mcv_hash_2(uint a, uint b) { return mcv_hash(a ^ (mcv_hash(b) + 0x9e3779b9u)); }

/* The cell, of `count`, that contains x in [0, 1]; x = 1 belongs to the last one. Values that
 * rounding puts outside belong to the nearest cell. */
MCV_LOOP_FUNCTION uint mcv_cell(float x, uint count) {
    const float at = x * (float)count;
    const uint i = at > 0.0f ? (uint)at : 0u;
    return i < count ? i : count - 1u;
}

/* The probability of entry i of a discrete CDF, 2^31 = 1. */
MCV_LOOP_FUNCTION float mcv_cdf_pmf(MCV_GLOBAL const uint *cdf, uint i) {
    // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): tables have an entry i + 1
    return (float)(cdf[i + 1] - cdf[i]) * 4.656612873077393e-10f; /* 2^-31 */
}

/* sin and cos for |x| <= π/4 by Taylor polynomials; absolute error below 8e-8. Library functions
 * would not return the same bits everywhere. */
MCV_LOOP_FUNCTION float mcv_sin_octant(float x) {
    const float x2 = x * x;
    float p = mcv_fma(x2, 2.7557319e-6f, -1.9841270e-4f);
    p = mcv_fma(x2, p, 8.3333333e-3f);
    p = mcv_fma(x2, p, -1.6666667e-1f);
    return mcv_fma(x * x2, p, x);
}

MCV_LOOP_FUNCTION float mcv_cos_octant(float x) {
    const float x2 = x * x;
    float p = mcv_fma(x2, 2.4801587e-5f, -1.3888889e-3f);
    p = mcv_fma(x2, p, 4.1666667e-2f);
    p = mcv_fma(x2, p, -0.5f);
    return mcv_fma(x2, p, 1.0f);
}

/* sin and cos of an angle in turns, up to about one turn. */
MCV_LOOP_FUNCTION void mcv_sin_cos_turn(float turns, float *sine, float *cosine) {
    const float nearest = mcv_fma(4.0f, turns, 0.5f);
    int quarters = (int)nearest; /* floor() would prevent vectorisation */
    quarters -= (float)quarters > nearest;
    const float rest = 2.0f * MCV_PI * mcv_fma(-0.25f, (float)quarters, turns);
    const float s = mcv_sin_octant(rest);
    const float c = mcv_cos_octant(rest);
    const int crossed = quarters & 1;
    const float across = crossed ? c : s;
    const float along = crossed ? s : c;
    *sine = quarters & 2 ? -across : across;
    *cosine = (quarters + 1) & 2 ? -along : along;
}

/*
 * The angle of (x, y) from the x axis in [-π, π], within 4e-7. Near π/4 the argument is reduced by
 * tan(a - π/4) = (tan a - 1)/(tan a + 1). The polynomial interpolates (atan r/r - 1)/r² at
 * Chebyshev nodes of r <= tan(π/8), with an error of 7e-8 of the angle.
 */
MCV_LOOP_FUNCTION float mcv_atan2(float y, float x) {
    const float across = mcv_abs(x);
    const float up = mcv_abs(y);
    const int steep = up > across;
    const float large = steep ? up : across;
    const float small = steep ? across : up;
    const int turned = small > 0.41421356f * large;
    const float over = turned ? small - large : small;
    const float under = turned ? small + large : large;
    const float r = under > 0.0f ? over / under : 0.0f;
    const float r2 = r * r;
    float p = mcv_fma(r2, 8.52049217e-2f, -1.40241429e-1f);
    p = mcv_fma(r2, p, 1.99912384e-1f);
    p = mcv_fma(r2, p, -3.33332866e-1f);
    float angle = mcv_fma(r * r2, p, r) + (turned ? 0.25f * MCV_PI : 0.0f);
    angle = steep ? 0.5f * MCV_PI - angle : angle;
    angle = x < 0.0f ? MCV_PI - angle : angle;
    return y < 0.0f ? -angle : angle;
}

/*
 * Maps the unit square to the unit disk, preserving areas and neighbourhoods (Shirley and Chiu
 * 1997). Writes cosine and sine of the angle and returns the radius in [0, 1].
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

/* A direction about +z with the density cosθ/π. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_sample_cosine(float xi, float eta) {
    float cosine, sine;
    const float r = mcv_disk(xi, eta, &cosine, &sine);
    return mcv_vec(r * cosine, r * sine, mcv_sqrt(mcv_fma(-r, r, 1.0f)));
}

/*
 * A direction about +z, uniform in the solid angle 4π sin²(β/2) of a cone of half-angle β; sin_half
 * = sin(β/2). It is stable for the smallest cones, where a float32 cosine could not tell 0.02° from
 * 0.
 */
MCV_LOOP_FUNCTION mcv_vec3 mcv_sample_cone(float sin_half, float xi, float eta) {
    float cosine, sine;
    const float s = sin_half * mcv_disk(xi, eta, &cosine, &sine);
    const float sin_theta = 2.0f * s * mcv_sqrt(mcv_fma(-s, s, 1.0f));
    return mcv_vec(sin_theta * cosine, sin_theta * sine, mcv_fma(-2.0f * s, s, 1.0f));
}

#endif
