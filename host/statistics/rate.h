/* SPDX-License-Identifier: Apache-2.0 */
/* Rates: how many of some trials succeed. */
#ifndef MCVISI_HOST_STATISTICS_RATE_H
#define MCVISI_HOST_STATISTICS_RATE_H

#include <stdint.h>

typedef struct mcv_interval {
    double low, high;
} mcv_interval;

/*
 * The interval of Wilson 1927 for the chance of a success, two-sided with this confidence, 0 to 1.
 * Its coverage is right on average over the chances, and not for each one. The whole of [0, 1]
 * without trials. 0 <= successes <= trials; successes may be a sum of rates.
 */
mcv_interval mcv_wilson(double successes, double trials, double confidence);

/* The lower bound of Clopper and Pearson 1934 for the chance, one-sided: never less confident than
 * it says. */
double mcv_clopper_pearson_low(uint64_t successes, uint64_t trials, double confidence);

#endif
