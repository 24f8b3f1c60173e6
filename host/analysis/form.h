/* SPDX-License-Identifier: Apache-2.0 */
/* What fits of lines and circles share: deviations of form, and intervals where the noise itself is
 * estimated. */
#ifndef MCVISI_HOST_ANALYSIS_FORM_H
#define MCVISI_HOST_ANALYSIS_FORM_H

#include "analysis/region.h"

/*
 * The degrees of freedom of the mean of two variances that mcv_roi_estimate_noise() found, each
 * from so many differences (Welch and Satterthwaite); infinite where both are 0.
 */
double mcv_noise_freedom(const double variances[2], const uint64_t differences[2]);

/* What makes 1.96 standard uncertainties hold the truth in 95 % of cases where the noise has these
 * degrees of freedom: t/1.96. */
double mcv_widening(double freedom);

/* Squared distances of places from a fit. */
typedef struct mcv_scatter {
    double count;   /* of places, or of their weights */
    double squares; /* Σ distance² */
    double noise;   /* what noise alone makes of it in the mean, and its variance then */
    double variance;
    double crossed; /* what noise and a true deviation make of the variance besides */
} mcv_scatter;

/*
 * The root of the mean squared distance that is not noise. An interval of 1.96 uncertainties ends
 * at 0 or below unless the squares are above what noise alone reaches in 95 % of cases (χ² of their
 * mean and variance, by Wilson and Hilferty 1931).
 */
mcv_quantity mcv_form_deviation(const mcv_scatter *scatter, double freedom);

#endif
