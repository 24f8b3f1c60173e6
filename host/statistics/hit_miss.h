/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Hits and misses against a size, for the probability of detection (MIL-HDBK-1823A): POD(x) =
 * 1/(1 + exp(-(b0 + b1 x))), x the size or its logarithm.
 *
 * Where one x parts hits from misses, the likelihood has no maximum; then Firth's penalty (1993)
 * is added: half the logarithm of the information's determinant.
 */
#ifndef MCVISI_HOST_STATISTICS_HIT_MISS_H
#define MCVISI_HOST_STATISTICS_HIT_MISS_H

#include "core/error.h"

#include <stdbool.h>

typedef struct mcv_hit_miss {
    const double *x;   /* not all equal; borrowed */
    const double *hit; /* 0 or 1 each; borrowed */
    size_t count;
    double intercept, slope;
    double log_likelihood; /* with the penalty, where `penalised` */
    bool penalised;        /* by Firth */
} mcv_hit_miss;

/*
 * Fits by maximum likelihood. MCV_BAD_INPUT with a sentence where all are hits, or all are misses.
 */
mcv_result mcv_hit_miss_fit(const double *x, const double *hit, size_t count, mcv_hit_miss *fit,
                            mcv_error *error);

/* The probability of detection at x. */
double mcv_hit_miss_pod(const mcv_hit_miss *fit, double x);

/*
 * The confidence that the probability of detection at x is above p, 0 < p < 1: Φ of the signed root
 * of the profile likelihood's ratio. Its coverage is 94 to 96 % for 95 % from some 240 hits and
 * misses on. It falls with p.
 */
double mcv_hit_miss_confidence(const mcv_hit_miss *fit, double x, double p);

#endif
