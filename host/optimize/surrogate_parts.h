/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of a Gaussian process share. */
#ifndef MCVISI_HOST_OPTIMIZE_SURROGATE_PARTS_H
#define MCVISI_HOST_OPTIMIZE_SURROGATE_PARTS_H

#include "optimize/surrogate.h"

/* Takes logarithms of the lengths and of s². */
void mcv_surrogate_set(mcv_surrogate *s, const double *logarithms);

/* Δ_i/l_i of two points. */
double mcv_surrogate_off(const mcv_surrogate *s, const double *a, const double *b, size_t i);

/* √5 r of two points. */
double mcv_surrogate_distance(const mcv_surrogate *s, const double *a, const double *b);

/* The lower half of the covariance of all values, in units of scale². */
void mcv_surrogate_fill(const mcv_surrogate *s, double *k);

/* Factors k, and finds the constant mean by generalised least squares. False where k has no
 * factor. */
bool mcv_surrogate_solve(mcv_surrogate *s, double *k, double *unit, double *weights);

/* surrogate_lengths.c: the logarithms before anything is known; and the best ones, for which
 * factor, unit and weights are overwritten. */
void mcv_surrogate_usual(const mcv_surrogate *s, double *logarithms);
void mcv_surrogate_search(mcv_surrogate *s);

#endif
