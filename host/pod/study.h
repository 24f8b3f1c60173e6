/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A study of the probability of detection: a table of defects with signals or hits, what is fitted
 * to it (statistics/pod.h), and the words in which that is told.
 *
 * A row with the size 0 is a flawless part. Such rows tell the noise and the rate of false calls.
 */
#ifndef MCVISI_HOST_POD_STUDY_H
#define MCVISI_HOST_POD_STUDY_H

#include "pod/columns.h"
#include "statistics/pod.h"
#include "statistics/rate.h"

#include <stdio.h>

enum { MCV_POD_LEAST_FLAWLESS = 10 }; /* for a threshold of a rate of false calls */

typedef struct mcv_pod_asked {
    bool signals;       /* the values are signals; else hits, 0 or 1 */
    double threshold;   /* of signals; NaN: that of false_calls */
    double false_calls; /* chance of a false call, 0 to 1; NaN: the threshold is given */
    double low, high;   /* signals at or beyond these are lost or saturated; NaN: none are */
    int size_scale, signal_scale; /* MCV_POD_… */
    double confidence;
    uint32_t seed;
    bool metres; /* sizes are lengths [m]; else numbers */
} mcv_pod_asked;

typedef struct mcv_pod_study {
    mcv_pod_asked asked;
    double *sizes, *values; /* of the defects */
    size_t count, hits;
    double *flawless; /* values of flawless parts */
    size_t flawless_count, false_calls;
    mcv_interval false_call_rate;           /* Wilson's, with 95 % */
    double noise_mean, noise_deviation;     /* of the signals of flawless parts; NaN: too few */
    double threshold, expected_false_calls; /* of a normal noise; NaN: not known */
    size_t left_out;                        /* rows without a size or a value */
    size_t repeated; /* rows of a defect that another row has had: left out, too */
    mcv_pod pod;
} mcv_pod_study;

/*
 * Makes the study of a table's columns. Rows of one defect are no independent defects: the first
 * one of each counts. MCV_BAD_INPUT with a sentence for data that no POD can be told of. To be
 * freed also after a failure.
 */
mcv_result mcv_pod_study_make(const mcv_pod_asked *asked, const mcv_columns *columns,
                              mcv_pod_study *study, mcv_error *error);
void mcv_pod_study_free(mcv_pod_study *study);

/* The answer in a sentence or two, malloc'ed; NULL without memory. */
char *mcv_pod_sentence(const mcv_pod_study *study);

/* Why a bound may not hold, a sentence each: assumptions that the data contradict, few defects. */
void mcv_pod_put_doubts(FILE *out, const mcv_pod_study *study, const char *before,
                        const char *after);

/* A size for people. */
void mcv_pod_size_words(const mcv_pod_study *study, double size, char words[32]);

/* The share of experiments in which a bound of hits and misses holds, said to be 95 %, from so many
 * defects; from simulations (tests/statistics). NaN from 240 on, where it is as said. */
double mcv_pod_coverage(size_t defects);

#endif
