/* SPDX-License-Identifier: Apache-2.0 */
/* What an experiment measures in the image of each set: expressions in the figures of
 * analysis/metrics.h. */
#ifndef MCVISI_HOST_EXPERIMENT_MEASURE_H
#define MCVISI_HOST_EXPERIMENT_MEASURE_H

#include "analysis/emd.h"
#include "analysis/places.h"
#include "analysis/read_out.h"

/* What is asked for. */
typedef struct mcv_measuring {
    mcv_texts metrics;          /* "[NAME:=]EXPR", a name like a metric's or an expression */
    mcv_texts until;            /* "NAME=U": a render goes on until the metric is known to U */
    mcv_places places;          /* as given: in pixels, or on the part */
    mcv_camera_settings camera; /* grey values are measured where it is wanted, else light */
    uint64_t channel;           /* 1: red …; 0: the mean of all */
    bool in_gradient;           /* measure in the Earth Mover's gradient of a light field image */
    mcv_emd_form form;          /* of that */
    uint32_t threads;           /* for that; 0: one per core */
} mcv_measuring;

typedef struct mcv_metric {
    char name[128];
    const char *expression;
    double until; /* 0: whatever */
} mcv_metric;

enum { MCV_METRICS = 32 };

/* The texts are not copied. */
typedef struct mcv_measurement {
    const mcv_measuring *asked;
    mcv_metric metrics[MCV_METRICS];
    size_t count;
} mcv_measurement;

/* Reads the metrics. MCV_USAGE names the text that is wrong. Nothing is to be freed. */
mcv_result mcv_measurement_read(const mcv_measuring *asked, mcv_measurement *measurement,
                                mcv_error *error);

/*
 * The metrics of what a film of the sensor holds so far. numbers: value and standard uncertainty of
 * each, NaN of those that fail; the result is then that of the first that does. The image may be
 * none that can be measured in: then all fail.
 */
mcv_result mcv_measurement_take(const mcv_measurement *measurement, const mcv_scene *scene,
                                uint32_t sensor, const mcv_film *film, double *numbers,
                                mcv_error *error);

/* Is every metric known as well as it is asked for? */
bool mcv_measurement_suffices(const mcv_measurement *measurement, const mcv_scene *scene,
                              uint32_t sensor, const mcv_film *film);

#endif
