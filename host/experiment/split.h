/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Settings of a program (parameters process/…) are tuned on some scenes of a sweep and validated on
 * others, which had no part in the choice: on the scenes that it was tuned on, the best of many
 * settings looks better than it is. A scene is on one side with all of its sets, by a hash of its
 * parameters.
 */
#ifndef MCVISI_HOST_EXPERIMENT_SPLIT_H
#define MCVISI_HOST_EXPERIMENT_SPLIT_H

#include "experiment/experiment.h"
#include "statistics/rate.h"

/* The mean of a metric of values from 0 to 1 over scenes, and Wilson's interval of 95 %. The
 * exposures of a scene are no scenes of their own. NaN without scenes. */
typedef struct mcv_split_rate {
    size_t scenes;
    double rate;
    mcv_interval interval;
} mcv_split_rate;

enum { MCV_SPLIT_TUNING, MCV_SPLIT_VALIDATION };

/* A setting of the program. */
typedef struct mcv_split_setting {
    size_t row; /* of the table, that has it */
    mcv_split_rate rates[2];
} mcv_split_setting;

typedef struct mcv_split {
    mcv_split_setting *settings; /* owned */
    size_t count;
    size_t best; /* the setting that is best on the scenes that it was tuned on */
} mcv_split;

/* Whether a scene is put aside for validation, of this share of all. */
bool mcv_split_validates(uint64_t scene, double share);

/* Rates of a program's metric, by its settings; *split is empty where the experiment has no
 * validation, or values lie outside of 0 to 1. Freed by mcv_split_free. */
mcv_result mcv_split_make(const mcv_sweep *sweep, size_t metric, mcv_split *split,
                          mcv_error *error);
void mcv_split_free(mcv_split *split);

#endif
