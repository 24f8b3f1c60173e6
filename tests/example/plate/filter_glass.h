/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Filter glass (type "filterGlass"): the example of "A plate" in docs/adding-an-element.md.
 *
 * A plane plate of coloured or neutral glass before a lens or a light. Its thickness is left out:
 * light goes straight on. A data sheet gives the internal transmittance τ_i along the normal,
 * without what the two surfaces reflect. At the angle θ the way through the glass is longer, with
 * sinθ = n sinθ':
 *
 *     τ = τ_i^(1/cosθ')
 *     T = (1 - R)² τ/(1 - R² τ²)        what passes
 *     R (1 + T τ)                       what is reflected, by the front and through the glass
 *
 * with Fresnel's R of one surface for unpolarised light. Both count all reflections within. In
 * contrast, the transmittance of the sheet (type "sheet") is the same at all angles.
 *
 *     {"type": "filterGlass", "ior": 1.52, "internalTransmittance": [0.01, 0.9, 0.1]}
 */
#ifndef MCVISI_MATERIALS_FILTER_GLASS_H
#define MCVISI_MATERIALS_FILTER_GLASS_H

#include "mcvisi/elementary.h"
#include "mcvisi/materials/material.h"

/* X(kind, key, default, min, max, "doc [unit]"): parser, ranges, units, --set, check, help and
 * schema follow (mcvisi/params.h). */
#define MCV_FILTER_GLASS_PARAMS(X) \
    X(number, ior, 1.5, 1, 10, "refractive index n") \
    X(spectrum, internalTransmittance, MCV_REQUIRED, 0, 1, \
      "share τ_i that passes the glass along the normal, without what its surfaces reflect")

/* What the device needs: words of 4 bytes, at most 8. */
typedef struct mcv_filter_glass {
    float eta;           /* 1/n */
    float delta;         /* (n - 1)(n + 1)/n² */
    float absorbance[3]; /* -ln τ_i */
} mcv_filter_glass;

/* What one channel reflects and passes. R: of one surface; c2: the cosine of θ', 0 under total
 * reflection. Host and device compile it. */
MCV_FUNCTION float mcv_filter_glass_shares(float absorbance, float once, float c2, float *passed) {
    const float tau = c2 > 0.0f ? mcv_exp_minus(absorbance / c2) : 0.0f;
    const float through = 1.0f - once, round = once * tau;
    *passed = through > 0.0f ? through * through * tau / mcv_fma(-round, round, 1.0f) : 0.0f;
    return once * mcv_fma(*passed, tau, 1.0f);
}

#endif
