/* SPDX-License-Identifier: Apache-2.0 */
/* The measurements of an experiment in the image of each set: expressions of the figures of
 * analysis/metrics.h. */
#ifndef MCVISI_HOST_EXPERIMENT_MEASURE_H
#define MCVISI_HOST_EXPERIMENT_MEASURE_H

#include "analysis/emd.h"
#include "analysis/places.h"
#include "analysis/read_out.h"
#include "experiment/bound.h"

/* The requested measurements. */
typedef struct mcv_measuring {
    mcv_texts metrics;          /* "[NAME:=]EXPR", a name like a metric's or an expression */
    mcv_texts until;            /* "NAME=U": render until the metric's standard uncertainty is U */
    const char *bound;          /* "PATH=STEP" (experiment/bound.h), or NULL */
    const char *best;           /* "NAME=largest|smallest": what the best set has, or NULL */
    mcv_places places;          /* as given: in pixels, or on the part */
    mcv_camera_settings camera; /* if given, grey values are measured, else light */
    uint64_t channel;           /* 1: red …; 0: the mean of all */
    bool in_gradient;           /* measure in the Earth Mover's gradient of a light field image */
    mcv_emd_form form;          /* of that */
    uint32_t threads;           /* for that; 0: one per core */
    bool allow_exec;            /* metrics may run programs (experiment/judge.h) */
    size_t exposures;           /* of each render, for them */
    double exec_time;           /* seconds for an answer */
    double validate;            /* share of the scenes that is put aside (experiment/split.h) */
} mcv_measuring;

typedef struct mcv_metric {
    char name[128];
    const char *expression;
    double until; /* 0: no limit */
} mcv_metric;

enum { MCV_METRICS = 32 };

/* The texts are borrowed. */
typedef struct mcv_measurement {
    const mcv_measuring *asked;
    mcv_bound bound;
    mcv_metric metrics[MCV_METRICS];
    size_t count;
    size_t best;       /* the metric that tells the best set; count: none */
    bool best_largest; /* largest is best, else smallest */
} mcv_measurement;

/* Reads the metrics. MCV_USAGE names the wrong text. Nothing needs to be freed. */
mcv_result mcv_measurement_read(const mcv_measuring *asked, mcv_measurement *measurement,
                                mcv_error *error);

/* Reads "NAME=U", a number above 0 for a metric, and "NAME=largest" or "NAME=smallest", of an
 * option. MCV_USAGE for other texts. */
mcv_result mcv_measurement_read_limit(const char *option, const char *item,
                                      const mcv_measurement *measurement, size_t *metric,
                                      double *limit, mcv_error *error);
mcv_result mcv_measurement_read_goal(const char *option, const char *item,
                                     const mcv_measurement *measurement, size_t *metric,
                                     bool *largest, mcv_error *error);

/*
 * Measures in the current image of a sensor's film. `stepped`: that of the second render of a
 * bound, or NULL. `numbers` gets value and standard uncertainty of each metric, NaN for those that
 * fail and those that programs decide; the result is that of the first failure. If the image cannot
 * be measured at all, all fail.
 */
mcv_result mcv_measurement_take(const mcv_measurement *measurement, const mcv_scene *scene,
                                uint32_t sensor, const mcv_film *film, const mcv_film *stepped,
                                double *numbers, mcv_error *error);

/* Is the uncertainty of every metric at or below its limit? */
bool mcv_measurement_suffices(const mcv_measurement *measurement, const mcv_scene *scene,
                              uint32_t sensor, const mcv_film *film);

#endif
