/* SPDX-License-Identifier: Apache-2.0 */
/*
 * LED (type "led"): the example of "A light without extent" in
 * docs/adding-an-element.md.
 *
 * A light without extent at its node's origin, along the node's -z. At the angle θ from the axis it
 * has the radiant intensity
 *
 *     I cos^n θ        up to 90°, nothing beyond;        Φ = 2π I/(n + 1)
 *
 * n = 1 is Lambertian; a lens on the chip makes n larger. The half-power angle of a data sheet is
 * arccos 2^(-1/n): 60° for n = 1, 33° for n = 4, 14° for n = 24. Source: I. Moreno and C.-C. Sun,
 * Optics Express 16 (2008) 1808-1819. Distance and `range` count as for the point light.
 *
 *     {"type": "led", "intensity": 0.2, "exponent": 4}
 */
#ifndef MCVISI_EMITTERS_LED_H
#define MCVISI_EMITTERS_LED_H

#include "mcvisi/emitters/emitter.h"

/* X(kind, key, default, min, max, "doc [unit]"): parser, ranges, units, --set, check, help and
 * schema follow (mcvisi/params.h). MCV_INTENSITY_PARAMS has intensity, power and range. */
#define MCV_LED_PARAMS(X) \
    MCV_INTENSITY_PARAMS(X) \
    X(integer, exponent, 1, 1, 127, "exponent n of the cosine: the larger, the narrower")

/* What the device needs beside position and axis: words of 4 bytes, at most 3. */
typedef struct mcv_led {
    uint exponent;
} mcv_led;

/* The intensity, over I, at q = sin²(θ/2), so that cosθ = 1 - 2q; no light from q = edge on. Host
 * and device compile it; a loop over paths calls it, so it has no branches. The power is by
 * squaring.
 */
MCV_LOOP_FUNCTION float mcv_led_profile(MCV_GLOBAL const mcv_led *light, float edge, float q) {
    float square = 1.0f - 2.0f * q, power = 1.0f;
    for (uint bit = 1; bit < 128u; bit *= 2u) {
        power *= light->exponent & bit ? square : 1.0f;
        square *= square;
    }
    return q < edge ? power : 0.0f;
}

#endif
