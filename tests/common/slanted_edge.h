/* SPDX-License-Identifier: Apache-2.0 */
/* Exact pixels of a slanted half-plane, sharp or behind a uniform disc. */
#ifndef MCVISI_TESTS_SLANTED_EDGE_H
#define MCVISI_TESTS_SLANTED_EDGE_H

#include "area_samples.h"

/* A uniform disc of radius r: how much of it. */
static inline double disc_coverage(double d, double r) {
    if (fabs(d) >= r) return d > 0 ? 1 : 0;
    return 0.5 + (d * sqrt(r * r - d * d) + r * r * asin(d / r)) / (M_PI * r * r);
}

typedef struct picture {
    double tilt, place,
        row;     /* the line passes column `place` at `row`; the tilt from the column axis */
    double disc; /* radius of the blur, 0: none */
    double dark, bright;
} picture;

/* The disc in 256 slices of equal width along the normal: off by at most (2r/256)²/12 times the
 * slope of the pixel's coverage: 1e-5. */
static inline double pixel_value(const picture *p, double x, double y) {
    enum { SLICES = 256 };
    const double cosine = cos(p->tilt), sine = sin(p->tilt);
    const double d = (x - p->place) * cosine - (y - p->row) * sine;
    double share = 0;
    if (p->disc == 0) {
        share = box_coverage(d, cosine, sine);
    } else {
        for (int i = 0; i < SLICES; ++i) {
            const double low = p->disc * (2.0 * i / SLICES - 1),
                         high = p->disc * (2.0 * (i + 1) / SLICES - 1);
            share += (disc_coverage(high, p->disc) - disc_coverage(low, p->disc)) *
                     box_coverage(d - 0.5 * (low + high), cosine, sine);
        }
    }
    return p->dark + (p->bright - p->dark) * share;
}

#endif
