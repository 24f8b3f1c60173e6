/* SPDX-License-Identifier: Apache-2.0 */
/* Exponential and logarithm from +, -, *, / and fma alone. They return the same bits on every
 * device, and loops that call them are vectorised. */
#ifndef MCVISI_ELEMENTARY_H
#define MCVISI_ELEMENTARY_H

#include "mcvisi/dialect.h"

/* exp(-x) for x >= 0, by 2^(-x log2 e) with a polynomial: relative error below 3e-7. */
MCV_LOOP_FUNCTION float mcv_exp_minus(float x) {
    /* Below 2^-126 the result would be denormal; it is rounded to 0. */
    const int vanishes = !(x < 87.0f);
    x = vanishes ? 0.0f : x;
    const float scaled = x * 1.44269504f;
    const float whole = mcv_floor(scaled + 0.5f);
    /* x = whole ln 2 + rest. ln 2 is split in two so that rest keeps its digits. */
    const float rest = mcv_fma(whole, 2.12194440e-4f, mcv_fma(whole, -0.693359375f, x));
    const float r = -rest;
    float p = mcv_fma(r, 1.3888889e-3f, 8.3333333e-3f);
    p = mcv_fma(r, p, 4.1666667e-2f);
    p = mcv_fma(r, p, 1.6666667e-1f);
    p = mcv_fma(r, p, 0.5f);
    p = mcv_fma(r, p, 1.0f);
    p = mcv_fma(r, p, 1.0f);
    const float result = p * as_float((uint)(127 - (int)whole) << 23);
    return vanishes ? 0.0f : result;
}

/* ln(1 + x) for x >= 0, relative error below 4e-7. */
MCV_LOOP_FUNCTION float mcv_log_1_plus(float x) {
    const float y = 1.0f + x;
    /* y = 2^whole m with m from 0.7 to 1.4, ln m = 2 artanh(t). */
    const uint whole = (as_uint(y) - 0x3f333333u) >> 23;
    const float m = as_float(as_uint(y) - (whole << 23));
    const float t = (m - 1.0f) / (m + 1.0f);
    const float s = t * t;
    float p = mcv_fma(s, 0.22222222f, 0.28571429f);
    p = mcv_fma(s, p, 0.4f);
    p = mcv_fma(s, p, 0.66666667f);
    p = mcv_fma(s, p, 2.0f);
    const float log_y = mcv_fma((float)whole, 0.69314718f, t * p);
    return y > 1.0f ? log_y * (x / (y - 1.0f)) : x; /* corrects the rounding of y */
}

/* cos^n θ = exp(-n ln(1/cosθ)) for n >= 0; 0 from 90° on. */
MCV_LOOP_FUNCTION float mcv_cosine_power(float cosine, float n) {
    const float c = cosine > 0.0f ? (cosine < 1.0f ? cosine : 1.0f) : 1.0f;
    const float power = mcv_exp_minus(n * mcv_log_1_plus((1.0f - c) / c));
    return cosine > 0.0f ? power : 0.0f;
}

#endif
