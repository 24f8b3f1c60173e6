/* SPDX-License-Identifier: Apache-2.0 */
/* How much of a pixel a half-plane and a disc cover, exactly: pictures of edges whose place is
 * known. */
#ifndef MCVISI_TESTS_AREA_SAMPLES_H
#define MCVISI_TESTS_AREA_SAMPLES_H

#include <math.h>
#include <stddef.h>

static inline double positive(double x) { return x > 0 ? x : 0; }

/* How much of a unit pixel lies beyond a line at the signed distance d before its centre, whose
 * normal has these components. */
static inline double box_coverage(double d, double cosine, double sine) {
    const double a = 0.5 * fabs(cosine), b = 0.5 * fabs(sine);
    if (fmin(a, b) < 1e-9) return fmin(1, fmax(0, d + 0.5));
    const double sum = pow(positive(d + a + b), 2) - pow(positive(d + a - b), 2) -
                       pow(positive(d - a + b), 2) + pow(positive(d - a - b), 2);
    return sum / (8 * a * b);
}

/* ∫ √(r² - t²) dt from 0 to t. */
static inline double half_segment(double t, double r) {
    return 0.5 * (t * sqrt(fmax(0, r * r - t * t)) + r * r * asin(fmax(-1, fmin(1, t / r))));
}

/* The area below x and y of the disc of radius r about 0. */
static inline double disc_corner(double x, double y, double r) {
    if (x <= -r || y <= -r) return 0;
    const double a = fmin(x, r), b = fmin(y, r), cut = sqrt(fmax(0, r * r - b * b)),
                 to = fmin(a, cut);
    /* Where |t| < cut the disc reaches beyond |y|, by √(r² - t²) - |y|. */
    const double beyond =
        to > -cut ? half_segment(to, r) - half_segment(-cut, r) - fabs(b) * (to + cut) : 0;
    return b >= 0 ? 2 * (half_segment(a, r) - half_segment(-r, r)) - beyond : beyond;
}

/* How much of the unit pixel whose top-left corner is x, y lies in the disc of radius r about 0. */
static inline double disc_coverage_of_pixel(double x, double y, double r) {
    const double ax = fabs(x + 0.5), ay = fabs(y + 0.5);
    if ((ax + 0.5) * (ax + 0.5) + (ay + 0.5) * (ay + 0.5) <= r * r) return 1;
    if (pow(positive(ax - 0.5), 2) + pow(positive(ay - 0.5), 2) >= r * r) return 0;
    return disc_corner(x + 1, y + 1, r) - disc_corner(x, y + 1, r) - disc_corner(x + 1, y, r) +
           disc_corner(x, y, r);
}

#endif
