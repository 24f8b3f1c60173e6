/* SPDX-License-Identifier: Apache-2.0 */
/* The page of an experiment (experiment/page.h): what its parts share. */
#ifndef MCVISI_HOST_EXPERIMENT_PAGE_PARTS_H
#define MCVISI_HOST_EXPERIMENT_PAGE_PARTS_H

#include "experiment/experiment.h"
#include "experiment/units.h"
#include "io/plots.h"

typedef struct mcv_page_name {
    char words[320]; /* with the unit */
} mcv_page_name;

typedef struct mcv_page {
    const mcv_sweep *sweep;
    mcv_shown_unit parameters[MCV_DESIGN_PARAMETERS], metrics[MCV_METRICS];
    mcv_page_name parameter_names[MCV_DESIGN_PARAMETERS], metric_names[MCV_METRICS];
    mcv_plots_axis axes[MCV_DESIGN_PARAMETERS];
    const char *names[MCV_METRICS];
    mcv_result stopped; /* an interruption has left out the pictures: why, with its sentence */
    mcv_error *error;
    mcv_plots plots; /* the table's rows in the units that are shown; its arrays are owned */
} mcv_page;

/* page_best.c: the best set, and smallest and largest of each metric. */
void mcv_page_put_best(FILE *out, const mcv_page *page);
void mcv_page_put_extremes(FILE *out, const mcv_page *page);

/* The row with the smallest or the largest of a metric; row_count: none. */
size_t mcv_page_extreme(const mcv_sweep *sweep, size_t metric, bool largest);

/* page_split.c: settings of programs with their rates, where scenes are put aside for validation.
 * False without memory. */
bool mcv_page_put_split(FILE *out, const mcv_page *page);

/* page_sets.c: all sets with their pictures and commands. */
void mcv_page_put_sets(FILE *out, const mcv_page *page);

/* The picture of a row and the command that renders it. */
void mcv_page_put_set(FILE *out, const mcv_page *page, size_t row);

/* page_assumed.c: what the numbers rest on; scene: that of one set, or NULL. */
void mcv_page_put_assumed(FILE *out, const mcv_page *page, const mcv_scene *scene);

#endif
