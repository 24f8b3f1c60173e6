/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/page.h"

#include "io/plots.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The columns for the plots: the parameters that vary, and the metrics. */
static double *pick_numbers(const mcv_table *table) {
    const size_t varied = table->plan->varied, metrics = 2 * table->measurement->count,
                 columns = varied + metrics;
    double *numbers = calloc(table->row_count * columns + 1, sizeof *numbers);
    for (size_t row = 0; numbers && row < table->row_count; ++row) {
        const double *from = table->rows + row * table->columns;
        double *to = numbers + row * columns;
        memcpy(to, from, varied * sizeof *to);
        memcpy(to + varied, from + mcv_row_metric(table, 0), metrics * sizeof *to);
    }
    return numbers;
}

mcv_result mcv_experiment_page(const char *rig, const mcv_table *table, mcv_error *error) {
    const mcv_plan *plan = table->plan;
    mcv_plots_axis axes[MCV_DESIGN_PARAMETERS];
    const char *names[MCV_METRICS];
    char labels[MCV_DESIGN_PARAMETERS][320], title[PATH_MAX + 64], text[PATH_MAX + 256];
    double *numbers = pick_numbers(table);
    if (!numbers) return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", table->page);
    for (size_t i = 0; i < plan->varied; ++i) {
        const mcv_parameter *p = plan->parameters + i;
        snprintf(labels[i], sizeof labels[i], "%.*s", p->path_length, p->item);
        axes[i] = (mcv_plots_axis){labels[i], p->levels.logarithmic};
    }
    for (size_t i = 0; i < table->measurement->count; ++i)
        names[i] = table->measurement->metrics[i].name;
    snprintf(title, sizeof title, "Sweep of %s", rig);
    snprintf(
        text, sizeof text,
        "%zu sets of parameters, %zu of which failed. Numbers are in SI units; the table is %s.",
        table->row_count, mcv_table_failed(table), table->path);
    const mcv_plots page = {title,
                            text,
                            axes,
                            plan->varied,
                            names,
                            table->measurement->count,
                            numbers,
                            (const char *const *)table->messages,
                            table->row_count};
    const mcv_result result = mcv_plots_write(table->page, &page, error);
    free(numbers);
    return result;
}
