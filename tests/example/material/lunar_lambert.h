/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lunar-Lambert reflector (type "lunarLambert"): the example of "A scattering material" in
 * docs/adding-an-element.md.
 *
 * Powder and dust look flatter than a Lambertian surface does: a full moon is no darker towards its
 * edge. The model is the sum of the law of Lommel and Seeliger and of Lambert's. With the cosines
 * c_o of the direction to the viewer, c_i of that to the light and the weight l, `lunar`,
 *
 *     f(o, i) = reflectance/π (l/(2 (c_i + c_o)) + 1 - l)
 *
 * It is reciprocal. Of uniform light it sends to the viewer the share
 *
 *     A(o) = reflectance (l (1 - c_o ln((1 + c_o)/c_o)) + 1 - l)
 *
 * which is at most the reflectance. The sides are alike. Source: A. S. McEwen, Icarus 92 (1991)
 * 298-311, with a factor that keeps A below 1 at all angles.
 *
 *     {"type": "lunarLambert", "reflectance": 0.8, "lunar": 0.75}
 */
#ifndef MCVISI_MATERIALS_LUNAR_LAMBERT_H
#define MCVISI_MATERIALS_LUNAR_LAMBERT_H

#include "mcvisi/materials/material.h"

/* X(kind, key, default, min, max, "doc [unit]"): parser, ranges, units, --set, check, help and
 * schema follow (mcvisi/params.h). */
#define MCV_LUNAR_LAMBERT_PARAMS(X) \
    X(spectrum, reflectance, 0.5, 0, 1, "scale of the light that is reflected") \
    X(number, lunar, 1, 0, 1, "weight of the law of Lommel and Seeliger; 0: Lambert's alone")

/* What the device needs beside the reflectance: words of 4 bytes, at most 6. */
typedef struct mcv_lunar_lambert {
    float lunar;
} mcv_lunar_lambert;

/* f π/reflectance; both cosines are above 0. Host and device compile this. */
MCV_FUNCTION float mcv_lunar_lambert_factor(float lunar, float c_o, float c_i) {
    return mcv_fma(lunar, 0.5f / (c_i + c_o), 1.0f - lunar);
}

#endif
