/* SPDX-License-Identifier: Apache-2.0 */
/* What the steps of measuring an edge share (analysis/edge.c); nothing else calls them. */
#ifndef MCVISI_HOST_ANALYSIS_EDGE_LINE_H
#define MCVISI_HOST_ANALYSIS_EDGE_LINE_H

#include "analysis/edge.h"
#include "analysis/form.h"
#include "analysis/region_noise.h"

typedef struct mcv_edge_patch {
    const mcv_readings *readings;
    const mcv_edge *edge;
    size_t columns, rows;
} mcv_edge_patch;

static inline size_t mcv_patch_index(const mcv_edge_patch *p, size_t column, size_t row) {
    const size_t x = p->edge->box.x + (p->edge->across_rows ? column : row),
                 y = p->edge->box.y + (p->edge->across_rows ? row : column);
    return y * p->readings->values.width + x;
}

static inline double mcv_patch_value(const mcv_edge_patch *p, size_t column, size_t row) {
    return p->readings->values.pixels[mcv_patch_index(p, column, row)];
}

static inline double mcv_patch_variance(const mcv_edge_patch *p, size_t column, size_t row) {
    const double u = p->readings->deviation.pixels[mcv_patch_index(p, column, row)];
    return u * u;
}

static inline double mcv_patch_summed_variance(const mcv_edge_patch *p, size_t column, size_t row,
                                               int directions) {
    return mcv_readings_summed_variance(p->readings, mcv_patch_index(p, column, row), directions);
}

/* In the patch: column = at + slope (row - middle), both of pixel centres. `left` and `right` are
 * the plateaus; `window` is half of what a row sums. */
typedef struct mcv_edge_line {
    double at, slope, middle, window;
    double variance_at, variance_slope;
    mcv_quantity left, right;
} mcv_edge_line;

static inline double mcv_edge_line_column(const mcv_edge_line *l, double row) {
    return l->at + l->slope * (row - l->middle);
}

/* Bins of 1/4 pixel along the normal, the edge between bins `half - 1` and `half`. */
typedef struct mcv_edge_bins {
    size_t half;
    double *count, *sum, *variance, *place, *place2;
} mcv_edge_bins;

mcv_result mcv_edge_fail(const mcv_edge *edge, mcv_error *error, const char *why);

/* edge_line.c */

mcv_edge_patch mcv_patch_of(const mcv_readings *readings, const mcv_edge *edge);

/* Whether the grey values change more along rows. Noise adds equally to both sums. */
bool mcv_edge_is_across_rows(const mcv_readings *readings, const mcv_edge *edge);

/* Plateaus from the pixels beyond the window. False where either has fewer than the rows. */
bool mcv_edge_find_plateaus(const mcv_edge_patch *p, mcv_edge_line *l);

/* Where an ideal step would hold a row's light inside the window. */
typedef struct mcv_edge_row {
    double place, variance; /* by the row's own pixels */
    double shared;          /* what it adds to the variance of a sum over many rows */
    double by_plateau[2];   /* slopes of the place */
} mcv_edge_row;

/* False where the window leaves the patch. */
bool mcv_edge_find_row(const mcv_edge_patch *p, const mcv_edge_line *l, size_t row,
                       mcv_edge_row *found);

/* Least squares through the rows' places. False where fewer than half of the rows have room for
 * their window. */
bool mcv_edge_fit_line(const mcv_edge_patch *p, mcv_edge_line *l);

/* edge_spread.c */

/* The bins reach as far as every row does. False without memory or room. */
bool mcv_edge_fill_bins(const mcv_edge_patch *p, const mcv_edge_line *l, mcv_edge_bins *b);
void mcv_edge_bins_free(mcv_edge_bins *b);
bool mcv_edge_find_width(const mcv_edge_patch *p, const mcv_edge_line *l, mcv_quantity *width);

/* edge_form.c */

/* The rows' places about their line. False without memory. */
bool mcv_edge_find_form(const mcv_edge_patch *p, const mcv_edge_line *l, mcv_edge *edge);

#endif
