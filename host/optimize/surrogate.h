/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A Gaussian process through noisy values whose noise is known: what an optimisation believes of an
 * objective between the points that it has seen (Rasmussen and Williams, Gaussian Processes for
 * Machine Learning, 2006, 2.2 and 5.4). Points are in the unit cube. The covariance is Matérn's of
 * 5/2 with a length for each parameter,
 *
 *     k(r) = s² (1 + √5 r + 5r²/3) exp(-√5 r),   r² = Σ (Δ_i/l_i)²
 *
 * where the Δ of a named parameter is 0 or 1: its values are the same or not, without an order
 * (Hutter, Hoos and Leyton-Brown, Sequential model-based optimization for general algorithm
 * configuration, LION 5, 507, 2011); and each value's own variance stands on the diagonal. The mean
 * is an unknown constant. Lengths and s are those of the largest posterior density, with wide
 * normal priors on their logarithms.
 */
#ifndef MCVISI_HOST_OPTIMIZE_SURROGATE_H
#define MCVISI_HOST_OPTIMIZE_SURROGATE_H

#include "core/error.h"
#include "experiment/design.h"

#include <stdbool.h>
#include <stddef.h>

enum { MCV_SURROGATE_PARAMETERS = 12 };

typedef struct mcv_surrogate {
    size_t dimensions, count, room;
    bool named[MCV_SURROGATE_PARAMETERS];
    double *points; /* [value][dimensions] */
    double *values, *variances;
    double logarithms[MCV_SURROGATE_PARAMETERS + 1]; /* of the lengths, and of s² in units of
                                                        scale² */
    double inverse[MCV_SURROGATE_PARAMETERS], variance, nugget; /* lengths⁻¹, s² */
    double shift, scale; /* standardised: (value - shift)/scale */
    /* Of the last fit: */
    size_t fitted;   /* values then */
    double *factor;  /* [fitted][fitted], lower: Cholesky's of the covariance */
    double *weights; /* of the covariances with a new point */
    double *unit;    /* factor⁻¹ 1 */
    double mean, mean_variance;
} mcv_surrogate;

/* After failure, too, it is freed by mcv_surrogate_free. */
void mcv_surrogate_begin(mcv_surrogate *s, size_t dimensions);
void mcv_surrogate_free(mcv_surrogate *s);

/* Adds a value with its variance, 0 or more. MCV_FAILED without memory. */
mcv_result mcv_surrogate_add(mcv_surrogate *s, const double *point, double value, double variance,
                             mcv_error *error);

/* Fits all values; with `search` also looks for better lengths. Needs one value. MCV_FAILED without
 * memory. */
mcv_result mcv_surrogate_fit(mcv_surrogate *s, bool search, mcv_error *error);

/* Mean and standard deviation of the objective, without noise, at points [count][dimensions]. */
mcv_result mcv_surrogate_predict(const mcv_surrogate *s, const double *points, size_t count,
                                 double *means, double *deviations, mcv_error *error);

/*
 * Draws of the objective at points, jointly: [draw][count]. `normals`, as many standard normal
 * numbers, are replaced by the draws.
 */
mcv_result mcv_surrogate_draw(const mcv_surrogate *s, const double *points, size_t count,
                              size_t draws, double *normals, mcv_error *error);

#endif
