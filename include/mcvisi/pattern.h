/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sequences of patterns for structured light: the parameter `pattern` of a projector, in place of
 * `image`. `index` chooses the pattern that is shown, as in --set emitters/proj/index=3. Values are
 * linear, from 0 to 1. They change only across the stripes, from pixel to pixel of `resolution`, W
 * x H. Vertical stripes (the default) are a function of the column x of W, horizontal ones of the
 * row x of H.
 *
 * "phaseShift": N steps of P periods, I_k = ½ + ½ cos(2π P (x + ½)/W - 2π k/N), k = 0 … N - 1. The
 * measured values I_k give 2π P (x + ½)/W = atan2(Σ I_k sin(2π k/N), Σ I_k cos(2π k/N)),
 * independent of the part's reflectance and of other light.
 *
 *     "pattern": {"type": "phaseShift", "steps": 4, "periods": 16, "resolution": [1280, 800]},
 *     "index": 0
 *
 * "grayCode": the bits of g = x xor (x >> 1); neighbours differ in one bit. B is the number of bits
 * of W - 1. Index 0 … B - 1 shows bit B - 1 - index, the coarsest first. Index B … 2 B - 1 shows
 * the inverted patterns, so that a pixel is lit if it is brighter than in the inverse.
 *
 *     "pattern": {"type": "grayCode", "orientation": "horizontal", "resolution": [1280, 800]},
 *     "index": 9
 *
 * Phase shifting: V. Srinivasan, H. C. Liu, M. Halioua, Applied Optics 23 (1984) 3105. Gray code:
 * S. Inokuchi, K. Sato, F. Matsuda, ICPR 1984.
 */
#ifndef MCVISI_PATTERN_H
#define MCVISI_PATTERN_H

#include "mcvisi/params.h"

/* X(name, "name in the scene file", NAME), as for elements. */
#define MCV_PATTERNS(X) \
    X(phase_shift, "phaseShift", PHASE_SHIFT) \
    X(gray_code, "grayCode", GRAY_CODE)

#define MCV_STRIPES_PARAMS(X) \
    X(choice, orientation, 0, 0, 1, "direction of the stripes") \
    X(int2, resolution, MCV_REQUIRED, 1, 65536, "the projector's pixels in x and y")

#define MCV_PHASE_SHIFT_PARAMS(X) \
    X(integer, steps, MCV_REQUIRED, 3, 65536, "images N of the sequence") \
    X(number, periods, MCV_REQUIRED, MCV_POSITIVE, 65536, "periods P across the image") \
    MCV_STRIPES_PARAMS(X)

#define MCV_GRAY_CODE_PARAMS(X) MCV_STRIPES_PARAMS(X)

#define MCV_PATTERN_ENUM(name, key, NAME) MCV_PATTERN_##NAME,
enum { MCV_PATTERNS(MCV_PATTERN_ENUM) MCV_PATTERN_COUNT };

#endif
