/* SPDX-License-Identifier: Apache-2.0 */
/* An experiment as one HTML file that needs nothing else: each metric over each parameter with
 * error bars (inline SVG), and all rows. */
#ifndef MCVISI_HOST_IO_PLOTS_H
#define MCVISI_HOST_IO_PLOTS_H

#include "core/error.h"

typedef struct mcv_plots_axis {
    const char *name; /* for people */
    bool logarithmic;
} mcv_plots_axis;

/* Nothing is owned. A row holds the parameters, then value and standard uncertainty of each metric;
 * NaN: there is none. */
typedef struct mcv_plots {
    const char *title, *text; /* text: a paragraph below the title */
    const mcv_plots_axis *parameters;
    size_t parameter_count;
    const char *const *metrics;
    size_t metric_count;
    const double *values;        /* [row][parameter_count + 2 metric_count] */
    const char *const *messages; /* per row, why it failed, or NULL */
    size_t row_count;
} mcv_plots;

/* Writes it; the file appears whole or not at all. */
mcv_result mcv_plots_write(const char *path, const mcv_plots *page, mcv_error *error);

#endif
