/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Diffusing film (type "diffusingFilm"): the example of "A scattering material" that passes light,
 * in docs/adding-an-element.md.
 *
 * A thin film before a light, with a structure that spreads what passes: a holographic or lens
 * diffuser. It spreads the share `transmittance` about the straight way on, with the density of the
 * retroreflector (mcvisi/materials/retroreflector.h): within the angle `spread` to it, a its
 * tangent, lies half of the light,
 *
 *     p(δ) = a² cosδ/(π (a² cos²δ + sin²δ)²)
 *     f(o, i) = transmittance p(δ)/max(cosθ_o, cosθ_i)
 *
 * f is reciprocal, and the film sends out no more than the transmittance. It reflects nothing. The
 * sides are alike. The function is phenomenological.
 *
 *     {"type": "diffusingFilm", "transmittance": 0.85, "spread": "20deg"}
 */
#ifndef MCVISI_MATERIALS_DIFFUSING_FILM_H
#define MCVISI_MATERIALS_DIFFUSING_FILM_H

#include "mcvisi/materials/material.h"

/* X(kind, key, default, min, max, "doc [unit]"): parser, ranges, units, --set, check, help and
 * schema follow (mcvisi/params.h). */
#define MCV_DIFFUSING_FILM_PARAMS(X) \
    X(spectrum, transmittance, 1, 0, 1, "share of the light that passes") \
    X(angle, spread, MCV_REQUIRED, 0.01, 1.5, \
      "angle to the straight way on, within which half of the light lies [rad]")

/* What the device needs beside the transmittance: words of 4 bytes, at most 8. */
typedef struct mcv_diffusing_film {
    float spread; /* its tangent */
} mcv_diffusing_film;

#endif
