/* SPDX-License-Identifier: Apache-2.0 */
/* Plots of a table of results for an HTML page (inline SVG). Each point leads to the row of its
 * set: a link to #sNUMBER. */
#ifndef MCVISI_HOST_IO_PLOTS_H
#define MCVISI_HOST_IO_PLOTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef struct mcv_plots_axis {
    const char *name; /* for people, with the unit */
    bool logarithmic;
} mcv_plots_axis;

/* Nothing is owned. A row holds the parameters, then value and standard uncertainty of each metric;
 * NaN: there is none. Numbers are as they are to be read. */
typedef struct mcv_plots {
    const mcv_plots_axis *parameters;
    size_t parameter_count;
    const char *const *metrics;
    size_t metric_count;
    const double *values; /* [row][parameter_count + 2 metric_count] */
    const size_t *sets;   /* number of each row's set */
    size_t row_count;
    size_t best, best_metric; /* a row that is marked in the plots of a metric; best row_count: none
                               */
} mcv_plots;

static inline const double *mcv_plots_row(const mcv_plots *p, size_t row) {
    return p->values + row * (p->parameter_count + 2 * p->metric_count);
}
static inline double mcv_plots_value(const mcv_plots *p, size_t metric, size_t row) {
    return mcv_plots_row(p, row)[p->parameter_count + 2 * metric];
}
/* 0: not known. */
double mcv_plots_uncertainty(const mcv_plots *p, size_t metric, size_t row);

/* The distinct values of a parameter in rising order; most + 1 if there are more than `most`. */
size_t mcv_plots_distinct(const mcv_plots *p, size_t parameter, double *values, size_t most);

/* The colour of a value in a range from 0 to 1, readable on white and on black: 0xRRGGBB. */
uint32_t mcv_plots_colour(double position);

/* A metric over a parameter: a curve for each set of the other parameters, with error bars of one
 * standard uncertainty. Colours tell the first other parameter. False without memory. */
bool mcv_plots_put_curves(FILE *out, const mcv_plots *plots, size_t metric, size_t parameter);

/*
 * heat_map.c: a metric over the first two parameters. A grid is drawn as cells, with their values
 * where they fit; other designs as coloured points.
 */
void mcv_plots_put_map(FILE *out, const mcv_plots *plots, size_t metric);

#endif
