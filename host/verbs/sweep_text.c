/* SPDX-License-Identifier: Apache-2.0 */
/* What people read of a sweep. */
#include "core/basics.h"
#include "verbs/sweep.h"
#include "verbs/sweep_split.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* What the stream has taken; NULL without memory. */
static char *finish(FILE *out, char **text) {
    (void)mcv_text_close(out, text);
    return *text;
}

char *mcv_sweep_row_text(const mcv_sweep *s, const double *row, const char *message) {
    char *text = NULL;
    size_t size;
    mcv_value_text value;
    FILE *out = open_memstream(&text, &size);
    if (!out) return NULL;
    fprintf(out, "%zu/%zu ", s->table.row_count, s->plan.wanted);
    for (size_t i = 0; i < s->plan.count; ++i)
        fprintf(out, " %s %s", s->plan.parameters[i].name,
                mcv_parameter_text(s->plan.parameters + i, row[i], 5, value));
    for (size_t i = 0; i < s->measurement.count; ++i) {
        const double *q = row + mcv_row_metric(&s->table, i);
        if (!isnan(q[0])) fprintf(out, "; %s %.5g", s->measurement.metrics[i].name, q[0]);
        if (!isnan(q[0]) && !isnan(q[1])) fprintf(out, " ± %.2g", q[1]);
    }
    if (message) fputs(": ", out);
    if (message) mcv_print_line(out, message);
    fputc('\n', out);
    return finish(out, &text);
}

static void print_extreme(FILE *out, const mcv_sweep *s, const char *which, size_t metric,
                          const double *row) {
    const double *q = row + mcv_row_metric(&s->table, metric);
    mcv_value_text value;
    fprintf(out, "%s %s: %.5g", which, s->measurement.metrics[metric].name, q[0]);
    if (!isnan(q[1])) fprintf(out, " ± %.2g", q[1]);
    for (size_t i = 0; i < s->plan.count; ++i)
        fprintf(out, "%s %s %s", i ? "," : " at", s->plan.parameters[i].name,
                mcv_parameter_text(s->plan.parameters + i, row[i], 5, value));
    fputc('\n', out);
}

/* Where each metric is largest and smallest. */
static void print_extremes(FILE *out, const mcv_sweep *s) {
    static const char *const words[2] = {"smallest", "largest"};
    for (size_t i = 0; i < s->measurement.count; ++i) {
        const double *extremes[2];
        mcv_table_extremes(&s->table, i, extremes);
        for (int k = 0; k < 2 && extremes[0]; ++k) print_extreme(out, s, words[k], i, extremes[k]);
    }
}

mcv_result mcv_sweep_text(const mcv_sweep *s, double spent, char **text, mcv_error *error) {
    const mcv_table *table = &s->table;
    size_t size;
    mcv_result result = MCV_OK;
    *text = NULL;
    FILE *out = open_memstream(text, &size);
    if (out) {
        print_extremes(out, s);
        result = mcv_sweep_split_text(s, out, error);
        fprintf(out, "%zu sets, %zu failed, %.1f s\n", table->row_count, mcv_table_failed(table),
                spent);
        if (table->path[0])
            fprintf(out, "  %s\n  %s\n  %s\n", table->path, table->sidecar, table->page);
    }
    *text = finish(out, text);
    MCV_TRY(result);
    return *text ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the report");
}
