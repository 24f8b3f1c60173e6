/* SPDX-License-Identifier: Apache-2.0 */
/* The axes of a plot in an HTML page (inline SVG). */
#ifndef MCVISI_HOST_IO_AXIS_H
#define MCVISI_HOST_IO_AXIS_H

#include <stdbool.h>
#include <stdio.h>

/* Of a plot, and its margins for the axes' numbers [CSS pixels]. */
enum {
    MCV_PLOT_WIDTH = 560,
    MCV_PLOT_HEIGHT = 340,
    MCV_PLOT_LEFT = 84,
    MCV_PLOT_RIGHT = 16,
    MCV_PLOT_TOP = 14,
    MCV_PLOT_BOTTOM = 52
};

/* From values to CSS pixels. */
typedef struct mcv_axis {
    double low, high; /* of what is shown; logarithms on a logarithmic axis */
    double from, to;  /* [CSS pixels] */
    bool logarithmic;
} mcv_axis;

/* With a little room at both ends. One value, or none, gets a range about it. */
mcv_axis mcv_axis_over(double low, double high, bool logarithmic, double from, double to);
double mcv_axis_place(const mcv_axis *axis, double value);

/* Enlarges a range, {INFINITY, -INFINITY} at first, to a value if it is finite. */
void mcv_axis_extend(double range[2], double value);

/* Opens the SVG of a plot, which the caller closes, with frame, grid, numbers and names. */
void mcv_axes_put(FILE *out, const mcv_axis *x, const mcv_axis *y, const char *x_name,
                  const char *y_name);

/* The opening and the names alone, for plots that write their numbers themselves. */
void mcv_axes_put_names(FILE *out, const char *x_name, const char *y_name);

#endif
