/* SPDX-License-Identifier: Apache-2.0 */
/* The distributions that comparisons need. p-values keep their relative accuracy in the far tail.
 */
#ifndef MCVISI_HOST_ANALYSIS_STATISTICS_H
#define MCVISI_HOST_ANALYSIS_STATISTICS_H

#include <stdint.h>

/*
 * The regularised incomplete beta function I_x(a, b), a, b > 0, 0 <= x <= 1: the continued fraction
 * of DLMF 8.17.22 by the modified Lentz method. Relative error about 1e-15 (a + b) ln(a + b), that
 * of lgamma, and never better than 1e-13.
 */
double mcv_incomplete_beta(double a, double b, double x);

/* P(|T| >= |t|) for Student's t with (not necessarily whole) degrees of freedom. */
double mcv_student_two_sided(double t, double freedom);

/* The t with P(|T| >= t) = p, 0 < p < 1. */
double mcv_student_quantile(double p, double freedom);

/* P(X >= successes) for `trials` trials that succeed with probability p. */
double mcv_binomial_upper(uint64_t successes, uint64_t trials, double p);

/*
 * Mann and Whitney's U of nx and ny values, the number of pairs with x > y: table[u] = P(U <= u), 0
 * <= u <= nx ny, exact where all come from one distribution, whatever it is. malloc'ed; NULL
 * without memory.
 */
double *mcv_mann_whitney(uint32_t nx, uint32_t ny);

/*
 * Kolmogorov-Smirnov, one-sided: whether the values (sorted in place) are smaller than uniform on
 * [0, 1] ones would be. The bound exp(-2 n D²) on the p-value (Massart 1990), good for every n; 1
 * for n = 0.
 */
double mcv_smaller_than_uniform(double *values, uint64_t count);

/* The p-value of the smallest of `count` independent ones: 1 - (1 - p)^count (Šidák). */
double mcv_sidak(double smallest, double count);

#endif
