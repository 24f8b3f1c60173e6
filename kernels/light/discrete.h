/* SPDX-License-Identifier: Apache-2.0 */
/* Choosing by a discrete CDF, 2^31 = 1. */
#ifndef MCVISI_KERNELS_DISCRETE_H
#define MCVISI_KERNELS_DISCRETE_H

#include "mcvisi/sampling.h"

/*
 * Of all choices of an emitter these go by less than what it promises: among few emitters in equal
 * parts, by the light tree by power. What promises most may be hidden, and what rounding puts out
 * of reach is found all the same (a defensive mixture, Hesterberg 1995).
 */
#define MCV_DEFENSIVE_PROBABILITY 0.0625f
#define MCV_INFORMED_PROBABILITY (1.0f - MCV_DEFENSIVE_PROBABILITY)

/*
 * A number xi has 24 bits, too few for the triangles of a large mesh: 7 more are the last ones of
 * another number, whose first ones alone matter where that is used.
 */
MCV_LOOP_FUNCTION uint mcv_cdf_bits(float xi, float other) {
    return (uint)(xi * 2147483648.0f) | ((uint)(other * 16777216.0f) & 127u);
}

/*
 * The i with cdf[i] <= bits < cdf[i + 1] is found from its highest binary digit down: from 0, by
 * one step for each digit from mcv_cdf_digit on.
 */
MCV_LOOP_FUNCTION uint mcv_cdf_digit(uint count) {
    uint digit = 1;
    while (2 * digit < count) digit *= 2;
    return digit;
}

MCV_LOOP_FUNCTION uint mcv_cdf_step(MCV_GLOBAL const uint *cdf, uint count, uint found, uint digit,
                                    uint bits) {
    const uint next = found + digit;
    const int exists = next < count;
    const int takes = exists & (cdf[exists ? next : 0u] <= bits);
    return takes ? next : found;
}

/* Where bits lies between cdf[found] and cdf[found + 1], in [0, 1). */
MCV_LOOP_FUNCTION float mcv_cdf_remainder(MCV_GLOBAL const uint *cdf, uint found, uint bits) {
    const uint low = cdf[found];
    const float remainder = (float)(bits - low) / (float)(cdf[found + 1u] - low);
    return remainder < 0.99999994f ? remainder : 0.99999994f;
}

MCV_FUNCTION uint mcv_search_cdf(MCV_GLOBAL const uint *cdf, uint count, uint bits) {
    uint found = 0;
    for (uint digit = mcv_cdf_digit(count); digit > 0; digit /= 2)
        found = mcv_cdf_step(cdf, count, found, digit, bits);
    return found;
}

#endif
