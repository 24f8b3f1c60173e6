/* SPDX-License-Identifier: Apache-2.0 */
/* What a region's figures and the estimate of its noise share: the error of the render. */
#ifndef MCVISI_HOST_ANALYSIS_REGION_NOISE_H
#define MCVISI_HOST_ANALYSIS_REGION_NOISE_H

#include "analysis/region.h"

#include <math.h>

/* The variance of a pixel that is the render's error; 0 where there is none. */
static inline double mcv_readings_render_variance(const mcv_readings *r, size_t i) {
    return r->render.pixels ? (double)r->render.pixels[i] * r->render.pixels[i] : 0;
}

/* How neighbours share the render's error; independent pixels where nothing blurred it. */
static inline mcv_correlation mcv_readings_correlation(const mcv_readings *r) {
    return r->correlation.sum > 0 ? r->correlation : (mcv_correlation){1, 1, 1, 1};
}

/*
 * What a pixel adds to the variance of a sum over many neighbours in one direction or in two: in
 * two its error counts with all that it is correlated with. That of one is the root, for a blur
 * that is the same all round.
 */
static inline double mcv_readings_summed_variance(const mcv_readings *r, size_t i, int directions) {
    const double u = r->deviation.pixels[i], sum = mcv_readings_correlation(r).sum;
    return u * u + ((directions == 1 ? sqrt(sum) : sum) - 1) * mcv_readings_render_variance(r, i);
}

/*
 * Σ over all lines of pixels of the squared covariance with one, whose sum across them has this
 * variance, and `shared` in a sum over many lines: neighbours share the render's error, and the
 * squares of its correlation add up to the root of those in two directions.
 */
static inline double mcv_readings_squared_covariance(const mcv_readings *r, double variance,
                                                     double shared) {
    const mcv_correlation rho = mcv_readings_correlation(r);
    const double render = rho.sum > 1 ? (shared - variance) / (sqrt(rho.sum) - 1) : 0;
    return variance * variance + (sqrt(rho.squares) - 1) * render * render;
}

/*
 * Of N second differences, which share pixels: by simulation, for squares of 3 x 3 to 32 x 32
 * pixels, the squared median is 1 + 5/N times the variance in the mean, and as uncertain as a
 * variance from so many degrees of freedom.
 */
static inline double mcv_roi_estimate_bias(double differences) { return 1 + 5 / differences; }

#endif
