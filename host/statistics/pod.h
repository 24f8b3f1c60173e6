/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Probability of detection (POD) after MIL-HDBK-1823A: of signals against a threshold, or of hits
 * and misses, over the size of defects.
 *
 *     mcv_pod pod;
 *     result = mcv_pod_fit(&data, &pod, &error);
 *     …                      pod.a90.value, pod.a90.high: a90 and a90/95
 *     mcv_pod_free(&pod);
 *
 * A bound stands only where it is known: within the tested sizes, and not from too few hits.
 */
#ifndef MCVISI_HOST_STATISTICS_POD_H
#define MCVISI_HOST_STATISTICS_POD_H

#include "statistics/hit_miss.h"
#include "statistics/response.h"

/* The axes of the fit. MCV_POD_AUTO: of the scales that can be, the most likely one (Akaike). */
enum { MCV_POD_AUTO, MCV_POD_LINEAR, MCV_POD_LOG };

/* For hits and misses, below which no bound is told. */
enum { MCV_POD_LEAST_DEFECTS = 30, MCV_POD_LEAST_OF_EACH = 5 };

typedef struct mcv_pod_data {
    const double *sizes;   /* above 0; borrowed */
    const double *signals; /* borrowed; or NULL: hits */
    const double *hits;    /* 0 or 1 each; borrowed */
    size_t count;
    double threshold; /* of the signals: at and above it a defect is detected */
    double low, high; /* signals at or beyond these are lost or saturated; NaN: none are */
    int size_scale, signal_scale; /* MCV_POD_… */
    double confidence;            /* of each bound, one-sided, such as 0.95 */
    uint32_t seed;                /* of the bootstrap of censored signals */
} mcv_pod_data;

/* Why a size is a number or NaN. */
typedef enum mcv_pod_known {
    MCV_POD_FOUND,
    MCV_POD_SMALLER, /* than every tested size; its number is the smallest one */
    MCV_POD_LARGER,  /* than every tested size: no number */
    MCV_POD_TOO_FEW, /* hits or misses: no number */
    MCV_POD_FALLING  /* the POD does not rise with the size: no number */
} mcv_pod_known;

/* A size that is found with some probability, and its bounds. */
typedef struct mcv_pod_size {
    double probability;
    double value, low, high; /* NaN where there is no number */
    mcv_pod_known value_known, low_known, high_known;
} mcv_pod_size;

typedef struct mcv_pod {
    mcv_pod_data data;
    bool fitted; /* false: all are hits, or all are misses; there is no curve */
    bool log_size, log_signal;
    double smallest, largest; /* tested sizes */
    mcv_response response;    /* of signals */
    mcv_response_checks checks;
    mcv_hit_miss hit_miss; /* else */
    double akaike;         /* of the scales taken, for signals as they are, not as logarithms */
    mcv_pod_size a50, a90;
    double *x, *y; /* own: what is fitted */
} mcv_pod;

/*
 * Fits and finds a50 and a90. MCV_BAD_INPUT with a sentence for data that no POD can be told of.
 * Fewer hits or misses than MCV_POD_LEAST_OF_EACH are no error: there is no bound then, and without
 * any no curve. To be freed also after a failure.
 */
mcv_result mcv_pod_fit(const mcv_pod_data *data, mcv_pod *pod, mcv_error *error);
void mcv_pod_free(mcv_pod *pod);

/* The POD at a size, and its one-sided bounds, each of the data's confidence; NaN: not known. */
typedef struct mcv_pod_point {
    double value, low, high;
} mcv_pod_point;

mcv_pod_point mcv_pod_at(const mcv_pod *pod, double size);

#endif
