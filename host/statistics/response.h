/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The response of a signal to a size, for the probability of detection (MIL-HDBK-1823A: â against
 * a): y = b0 + b1 x + scatter ε, ε standard normal. x is the size or its logarithm, y the signal or
 * its logarithm. A defect is detected where y reaches the threshold.
 *
 * Signals at or below `low` (lost in the noise) and at or above `high` (saturated) are censored:
 * only that they are there is known.
 */
#ifndef MCVISI_HOST_STATISTICS_RESPONSE_H
#define MCVISI_HOST_STATISTICS_RESPONSE_H

#include "core/error.h"

#include <stdint.h>

typedef struct mcv_response_data {
    const double *x, *y; /* borrowed; x differ from each other somewhere */
    size_t count;
    double threshold;
    double low, high; /* -INFINITY and INFINITY: nothing is censored */
    uint32_t seed;    /* of the bootstrap */
} mcv_response_data;

enum { MCV_RESPONSE_RESAMPLES = 999, MCV_RESPONSE_LEAST = 10 };

typedef struct mcv_response {
    mcv_response_data data;
    double intercept, slope, scatter; /* scatter: of n - 2 degrees of freedom */
    double log_likelihood;            /* the largest */
    double mean, squares;             /* of x: mean, and sum of squares about it */
    size_t lost, saturated;           /* censored signals */
    double (*again)[3];               /* intercept, slope and scatter of each resample, or NULL */
} mcv_response;

/*
 * Fits by maximum likelihood: least squares, or where signals are censored Tobin's likelihood
 * (1958) in the form of Olsen (1978), which is concave. MCV_BAD_INPUT with a sentence where fewer
 * than MCV_RESPONSE_LEAST signals are not censored, or no scatter is left. To be freed also after a
 * failure.
 */
mcv_result mcv_response_fit(const mcv_response_data *data, mcv_response *fit, mcv_error *error);

/* What bounds of censored data need: they are drawn from the fitted line and fitted anew
 * MCV_RESPONSE_RESAMPLES times (parametric bootstrap). Nothing where none is censored.
 * MCV_BAD_INPUT where too few of these have a fit. */
mcv_result mcv_response_resample(mcv_response *fit, mcv_error *error);
void mcv_response_free(mcv_response *fit);

/* The probability of detection at x. */
double mcv_response_pod(const mcv_response *fit, double x);

/*
 * The confidence that the probability of detection at x is above p, 0 < p < 1: exact by the
 * noncentral t distribution; where signals are censored by the bootstrap. It falls with p.
 */
double mcv_response_confidence(const mcv_response *fit, double x, double p);

/* p-values of what the fit assumes. Of censored data only the others are tested, roughly. */
typedef struct mcv_response_checks {
    double linear; /* against a parabola: F test */
    double even;   /* the scatter is that of every x: Breusch and Pagan, studentised by Koenker */
    double normal; /* Anderson and Darling, with the p-values of D'Agostino and Stephens 1986 */
} mcv_response_checks;

mcv_result mcv_response_check(const mcv_response *fit, mcv_response_checks *checks,
                              mcv_error *error);

#endif
