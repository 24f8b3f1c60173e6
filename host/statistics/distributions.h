/* SPDX-License-Identifier: Apache-2.0 */
/* The normal distribution, and the noncentral t distribution of tolerance bounds. */
#ifndef MCVISI_HOST_STATISTICS_DISTRIBUTIONS_H
#define MCVISI_HOST_STATISTICS_DISTRIBUTIONS_H

/* P(Z <= z) of a standard normal Z. */
double mcv_normal_cdf(double z);

/* The z with P(Z <= z) = p; infinite for p of 0 and 1, NaN outside. */
double mcv_normal_quantile(double p);

/*
 * P(T <= t) of the noncentral t: T = (Z + noncentrality)/S, S² = χ²(freedom)/freedom. The integral
 * over the density of S by the trapezoidal rule; absolute error below 1e-9 for freedom >= 8 and
 * |noncentrality| <= 200.
 */
double mcv_noncentral_t_cdf(double t, double freedom, double noncentrality);

#endif
