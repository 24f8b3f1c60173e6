/* SPDX-License-Identifier: Apache-2.0 */
#include "cli/sweep.h"
#include "cli/command.h"
#include "core/basics.h"
#include "loader/load.h"

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

/* {"value": …, "uncertainty": …, "set": …, "parameters": {…}} */
static json_t *describe_row(const mcv_sweep *s, size_t metric, const double *row) {
    const double *q = row + mcv_row_metric(&s->table, metric);
    json_t *point = json_object(), *where = json_object();
    for (size_t i = 0; i < s->plan.count; ++i)
        json_object_set_new(where, s->plan.parameters[i].name, json_real(row[i]));
    json_object_set_new(point, "value", json_real(q[0]));
    json_object_set_new(point, "uncertainty", isfinite(q[1]) ? json_real(q[1]) : json_null());
    json_object_set_new(point, "set",
                        json_integer((json_int_t)row[mcv_row_fixed(&s->table, MCV_ROW_SET)]));
    json_object_set_new(point, "parameters", where);
    return point;
}

static void tell_extreme(const mcv_sweep *s, const char *which, size_t metric, const double *row) {
    const double *q = row + mcv_row_metric(&s->table, metric);
    printf("%s %s: %.5g ± %.2g", which, s->measurement.metrics[metric].name, q[0], q[1]);
    for (size_t i = 0; i < s->plan.count; ++i)
        printf("%s %s %.5g", i ? "," : " at", s->plan.parameters[i].name, row[i]);
    putchar('\n');
}

/* The largest and the smallest value of each metric, as an object; for people they are printed. */
static json_t *report_extremes(const mcv_sweep *s, bool json) {
    static const char *const words[2] = {"smallest", "largest"};
    json_t *all = json_object();
    for (size_t i = 0; i < s->measurement.count; ++i) {
        const double *extremes[2];
        json_t *of = json_object();
        mcv_table_extremes(&s->table, i, extremes);
        for (int k = 0; k < 2 && extremes[0]; ++k) {
            json_object_set_new(of, words[k], describe_row(s, i, extremes[k]));
            if (!json) tell_extreme(s, words[k], i, extremes[k]);
        }
        json_object_set_new(all, s->measurement.metrics[i].name, of);
    }
    return all;
}

mcv_result mcv_sweep_report(const mcv_sweep *s, bool json, double spent, mcv_error *error) {
    const mcv_table *table = &s->table;
    const size_t failed = mcv_table_failed(table);
    json_t *document = json_object(), *extremes = report_extremes(s, json);
    json_object_set_new(document, "table", json_string(table->path));
    json_object_set_new(document, "page", json_string(table->page));
    json_object_set_new(document, "experiment", json_string(table->sidecar));
    json_object_set_new(document, "rows", json_integer((json_int_t)table->row_count));
    json_object_set_new(document, "failed", json_integer((json_int_t)failed));
    json_object_set_new(document, "seconds", json_real(spent));
    json_object_set_new(document, "stage_seconds", json_real(s->stage_seconds));
    json_object_set_new(document, "assets_read",
                        json_integer((json_int_t)mcv_asset_cache_reads(s->assets)));
    json_object_set_new(document, "structures_built", json_integer((json_int_t)s->built));
    json_object_set_new(document, "programs_built", json_integer((json_int_t)s->compiled));
    json_object_set_new(document, "metrics", extremes);
    char *text = json_dumps(document, JSON_COMPACT);
    json_decref(document);
    if (!text) return mcv_fail(error, MCV_FAILED, "no memory for the report");
    if (json)
        puts(text);
    else
        printf("%zu sets, %zu failed, %.1f s\n  %s\n  %s\n  %s\n", table->row_count, failed, spent,
               table->path, table->sidecar, table->page);
    free(text);
    return MCV_OK;
}
