/* SPDX-License-Identifier: Apache-2.0 */
/* Choosing from a table of cumulative shares, 2^31 = 1, and weighing what is chosen in two ways. */
#ifndef MCVISI_KERNELS_CHOOSE_H
#define MCVISI_KERNELS_CHOOSE_H

#include "mcvisi/dialect.h"

/*
 * A number xi has 24 bits, too few for the triangles of a large mesh: 7 more are the last ones of
 * another number, whose first ones alone matter where that is used.
 */
MCV_FUNCTION uint mcv_cdf_bits(float xi, float other) {
    return (uint)(xi * 2147483648.0f) | ((uint)(other * 16777216.0f) & 127u);
}

/* Where between two shares bits lies that is so far above the lower one, in [0, 1). */
MCV_FUNCTION float mcv_cdf_remainder(uint above, float width) {
    const float share = (float)above / width;
    return share < 0.99999994f ? share : 0.99999994f;
}

/* The i with cdf[i] <= bits < cdf[i + 1], and where between them bits lies. */
MCV_FUNCTION uint mcv_search_cdf(MCV_GLOBAL const uint *cdf, uint count, float xi, float other,
                                 float *remainder) {
    const uint bits = mcv_cdf_bits(xi, other);
    uint low = 0;
    uint high = count;
    while (high - low > 1) {
        const uint middle = (low + high) / 2;
        if (cdf[middle] <= bits)
            low = middle;
        else
            high = middle;
    }
    *remainder = mcv_cdf_remainder(bits - cdf[low], (float)(cdf[low + 1] - cdf[low]));
    return low;
}

/*
 * The weight of what was found by a choice of density `own` > 0 and could have been found by
 * another: the power heuristic of exponent 2 (Veach 1997, 9.2.4). The balance heuristic leaves a
 * share of small lights to the few paths that meet them by chance, and their noise with it.
 */
MCV_FUNCTION float mcv_power_heuristic(float own, float other) {
    const float ratio = other / own; /* whose square may be infinite: no weight */
    return 1.0f / mcv_fma(ratio, ratio, 1.0f);
}

#endif
