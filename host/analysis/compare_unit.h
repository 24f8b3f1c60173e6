/* SPDX-License-Identifier: Apache-2.0 */
/* One pixel, tile or image of two pictures (analysis/compare.c); nothing else calls this. */
#ifndef MCVISI_HOST_ANALYSIS_COMPARE_UNIT_H
#define MCVISI_HOST_ANALYSIS_COMPARE_UNIT_H

#include "analysis/compare.h"
#include "analysis/statistics.h"

#define MCV_ALL_CHANNELS UINT32_MAX

/* One of the two pictures: a film, or images with their errors. */
typedef struct mcv_compared {
    const mcv_film *film;
    const mcv_measured *measured;
    uint32_t replicates;
    const double *rank_table; /* mcv_mann_whitney of both pictures' replicates */
} mcv_compared;

/* What is known of one region of one picture. */
typedef struct mcv_region_view {
    mcv_estimate estimate;
    double means[MCV_MAX_REPLICATES]; /* of a film's replicates */
    uint64_t pixels;                  /* that are finite */
} mcv_region_view;

/* The outcome of one unit. */
typedef struct mcv_unit_outcome {
    bool seen;       /* it has finite pixels, */
    bool tested;     /* which are not all equal beyond doubt */
    double p;        /* for the unit test */
    bool counts;     /* whether the p-value may enter KS and count: */
    double uniform;  /* uniform in [0, 1] or larger where there is no difference */
    double variance; /* of the difference of the means */
} mcv_unit_outcome;

void mcv_region_measure(const mcv_compared *s, const mcv_compared *other, const mcv_region *region,
                        mcv_region_view *v);

/* Welch's difference: the variance of x - y and its degrees of freedom (Welch 1947, Satterthwaite
 * 1946). */
mcv_estimate mcv_estimate_subtract(const mcv_estimate *x, const mcv_estimate *y);
double mcv_welch_two_sided(const mcv_estimate *difference);
mcv_unit_outcome mcv_compare_unit(const mcv_compared *x, const mcv_compared *y,
                                  const mcv_region *region);

#endif
