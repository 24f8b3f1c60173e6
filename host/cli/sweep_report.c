/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/sweep.h"
#include "options/command.h"
#include "core/basics.h"
#include "verbs/sweep.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

void mcv_sweep_tell_row(void *user, const mcv_sweep *s, const double *row, const char *message) {
    if (((const mcv_command *)user)->json) return;
    printf("%zu/%zu ", s->table.row_count, s->plan.wanted);
    for (size_t i = 0; i < s->plan.count; ++i)
        printf(" %s %.5g", s->plan.parameters[i].name, row[i]);
    for (size_t i = 0; i < s->measurement.count; ++i) {
        const double *q = row + mcv_row_metric(&s->table, i);
        if (!isnan(q[0])) printf("; %s %.5g ± %.2g", s->measurement.metrics[i].name, q[0], q[1]);
    }
    if (message) printf(": ");
    if (message) mcv_print_plain(stdout, message);
    putchar('\n');
    fflush(stdout);
}

static void tell_extreme(const mcv_sweep *s, const char *which, size_t metric, const double *row) {
    const double *q = row + mcv_row_metric(&s->table, metric);
    printf("%s %s: %.5g ± %.2g", which, s->measurement.metrics[metric].name, q[0], q[1]);
    for (size_t i = 0; i < s->plan.count; ++i)
        printf("%s %s %.5g", i ? "," : " at", s->plan.parameters[i].name, row[i]);
    putchar('\n');
}

/* Where each metric is largest and smallest. */
static void tell_extremes(const mcv_sweep *s) {
    static const char *const words[2] = {"smallest", "largest"};
    for (size_t i = 0; i < s->measurement.count; ++i) {
        const double *extremes[2];
        mcv_table_extremes(&s->table, i, extremes);
        for (int k = 0; k < 2 && extremes[0]; ++k) tell_extreme(s, words[k], i, extremes[k]);
    }
}

mcv_result mcv_sweep_report(const mcv_sweep *s, bool json, double spent, mcv_error *error) {
    const mcv_table *table = &s->table;
    char *text;
    if (json) {
        MCV_TRY(mcv_sweep_json(s, spent, &text, error));
        puts(text);
        free(text);
        return MCV_OK;
    }
    tell_extremes(s);
    printf("%zu sets, %zu failed, %.1f s\n  %s\n  %s\n  %s\n", table->row_count,
           mcv_table_failed(table), spent, table->path, table->sidecar, table->page);
    return MCV_OK;
}
