/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rough surfaces as microfacets. Their normals have the GGX distribution (Walter, Marschner, Li and
 * Torrance 2007; Trowbridge and Reitz 1975). They mask and shadow each other by Smith's
 * height-correlated function (Heitz 2014). Visible normals are sampled (Dupuy and Benyoub 2023). α
 * = roughness²; an anisotropic surface has one α along the tangent and another across.
 *
 * Vectors are given in the frame (tangent, bitangent, normal) of the surface.
 */
#ifndef MCVISI_MATERIALS_MICROFACET_H
#define MCVISI_MATERIALS_MICROFACET_H

#include "mcvisi/elementary.h"
#include "mcvisi/materials/material.h"

/*
 * The smallest α. A direction in float32 has an error of about 1e-7; below this α, its effect on a
 * microfacet's slope would exceed 1e-4.
 */
#define MCV_LEAST_ALPHA 1e-3f

/* Rows of a table of albedos: cosines μ = (row/(rows - 1))². The azimuths are for anisotropic
 * surfaces, the roughnesses for textured ones. */
#define MCV_ALBEDO_COSINES 64
#define MCV_ALBEDO_AZIMUTHS 17
#define MCV_ALBEDO_ROUGHNESSES 17

/*
 * Sizes of a table of multiple scattering. Rows and columns are cosines μ, at equal steps of √μ/(√μ
 * + √(1 - μ)) from 0 to 1. Angles φ between azimuths are at equal steps of c (1 + k)/(c + k), with
 * c = |cos φ/2| and k the sum of the two cosines and of this. Then words of an entry, and
 * roughnesses.
 */
#define MCV_MULTIPLE_COSINES 23
#define MCV_MULTIPLE_AZIMUTHS 8
#define MCV_MULTIPLE_LEAST 0.02f
#define MCV_MULTIPLE_WORDS 4
#define MCV_MULTIPLE_ROUGHNESSES 9

/*
 * Rough glass also sends much light back towards where it came from, in narrower directions: it has
 * more cosines and azimuths (mcv_interface_turn). Its words are fourth roots of what they stand
 * for, between which lines follow the steep and the empty ranges better.
 */
#define MCV_INTERFACE_COSINES 32
#define MCV_INTERFACE_AZIMUTHS 20

typedef struct mcv_alpha {
    float x, y; /* along the tangent, across */
} mcv_alpha;

/*
 * The place of an angle φ, from 0 to 1, on the axis of azimuths of rough glass, by c = |cos φ/2|
 * and s = |sin φ/2|: half the one of other tables, half 1 - s, which parts small angles. k: the sum
 * of the two cosines and of MCV_MULTIPLE_LEAST.
 */
MCV_LOOP_FUNCTION float mcv_interface_turn(float c, float s, float k) {
    return 0.5f * (c * ((1.0f + k) / (c + k)) + 1.0f - s);
}

/* Smith's Λ of a direction, on either side. */
MCV_LOOP_FUNCTION float mcv_ggx_lambda(mcv_alpha alpha, mcv_vec3 w) {
    const float x = alpha.x * w.x;
    const float y = alpha.y * w.y;
    const float slope = mcv_fma(x, x, y * y);
    const float z = mcv_abs(w.z);
    return 0.5f * slope / (z * (z + mcv_sqrt(mcv_fma(z, z, slope))));
}

/*
 * The masking of two directions on opposite sides with these Λ: the mean visibility from both over
 * the heights of the microfacet, ∫ u^a (1 - u)^b du (Heitz and others 2016). This is Euler's B(1 +
 * a, 1 + b), computed by Stirling's series for arguments larger by 2. Relative error below 2e-6 (1
 * + a + b).
 */
MCV_LOOP_FUNCTION float mcv_opposite_masking(float a, float b) {
    const float x = (a < 1e9f ? a : 1e9f) + 1.0f;
    const float y = (b < 1e9f ? b : 1e9f) + 1.0f;
    const float s = x + y;
    const float step =
        (s / x) * ((s + 1.0f) / (x + 1.0f)) * ((s + 2.0f) / y) * ((s + 3.0f) / (y + 1.0f));
    const float p = x + 2.0f;
    const float q = y + 2.0f;
    const float r = s + 4.0f;
    const float u = 1.0f / p;
    const float v = 1.0f / q;
    const float w = 1.0f / r;
    const float series = mcv_fma(
        mcv_fma(u * u, mcv_fma(u * u, 7.9365079e-4f, -2.7777778e-3f), 8.3333333e-2f), u,
        mcv_fma(mcv_fma(v * v, mcv_fma(v * v, 7.9365079e-4f, -2.7777778e-3f), 8.3333333e-2f), v,
                -mcv_fma(w * w, mcv_fma(w * w, 7.9365079e-4f, -2.7777778e-3f), 8.3333333e-2f) * w));
    const float powers =
        mcv_fma(p - 0.5f, mcv_log_1_plus(q * u), (q - 0.5f) * mcv_log_1_plus(p * v));
    return step * mcv_exp_minus(powers - series) * (2.5066283f / mcv_sqrt(r)); /* √2π */
}

/* The density D(h) of microfacet normals, per area of the surface [1/sr]. */
MCV_LOOP_FUNCTION float mcv_ggx_density(mcv_alpha alpha, mcv_vec3 h) {
    const float x = h.x / alpha.x;
    const float y = h.y / alpha.y;
    const float s = mcv_fma(x, x, mcv_fma(y, y, h.z * h.z));
    return 1.0f / (MCV_PI * alpha.x * alpha.y * s * s);
}

/* A microfacet normal with the density D(h) max(0, o·h)/((1 + Λ(o)) o_z); o_z > 0. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_ggx_sample(mcv_alpha alpha, mcv_vec3 o, float xi, float eta) {
    const mcv_vec3 s = mcv_normalize(mcv_vec(alpha.x * o.x, alpha.y * o.y, o.z));
    float cosine, sine;
    const float r = mcv_disk(xi, eta, &cosine, &sine);
    const float q = r * r * (1.0f + s.z);
    const float around = q < 2.0f ? mcv_sqrt(q * (2.0f - q)) : 0.0f;
    const float z = mcv_fma(-r, r, 1.0f) * (1.0f + s.z);
    return mcv_normalize(
        mcv_vec(alpha.x * mcv_fma(around, cosine, s.x), alpha.y * mcv_fma(around, sine, s.y), z));
}

/* Schlick's (1 - c)^5. */
MCV_LOOP_FUNCTION float mcv_schlick(float c) {
    const float m = c < 1.0f ? 1.0f - c : 0.0f;
    return (m * m) * (m * m) * m;
}

/* The reflectance of a metal of complex index n - ik, relative to the medium before it, for
 * unpolarised light. */
MCV_LOOP_FUNCTION float mcv_conductor_fresnel(float n, float k, float cosine) {
    const float c2 = cosine * cosine;
    const float s2 = 1.0f - c2;
    const float real = mcv_fma(n - k, n + k, -s2);
    const float twice = 2.0f * n * k;
    const float size = mcv_sqrt(mcv_fma(real, real, twice * twice));
    const float a = mcv_sqrt(0.5f * (size + real > 0.0f ? size + real : 0.0f));
    const float sum = size + c2;
    const float cross = 2.0f * a * cosine;
    if (!(sum + cross > 0.0f)) return 1.0f;
    const float r_s = (sum - cross) / (sum + cross);
    const float p_sum = mcv_fma(c2, size, s2 * s2);
    const float p_cross = cross * s2;
    const float reflected = 0.5f * r_s * (1.0f + (p_sum - p_cross) / (p_sum + p_cross));
    return reflected < 1.0f ? reflected : 1.0f;
}

#endif
