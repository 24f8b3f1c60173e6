/* SPDX-License-Identifier: Apache-2.0 */
/* Minima of convex quadratics over numbers that are not negative, by NLopt. */
#ifndef MCVISI_HOST_TRANSPORT_NONNEGATIVE_H
#define MCVISI_HOST_TRANSPORT_NONNEGATIVE_H

#include "core/error.h"

/* The value at `at`; writes the slopes there. */
typedef double mcv_quadratic(void *user, const double *at, double *slopes);

/*
 * Looks for the least value over at >= 0. `at`: where it begins, and the result. `scale`: of each
 * number 1 over the root of the quadratic's own coefficient; 0: the number stays 0. Ends after
 * `most` evaluations at the latest.
 *
 * J. Nocedal, Updating quasi-Newton matrices with limited storage, Math. Comp. 35 (1980), with
 * bounds as in NLopt's LD_LBFGS. MCV_FAILED without memory.
 */
mcv_result mcv_minimise_nonnegative(mcv_quadratic *quadratic, void *user, const double *scale,
                                    size_t count, uint32_t most, double *at, mcv_error *error);

#endif
