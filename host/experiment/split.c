/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/split.h"

#include "core/basics.h"

#include <math.h>
#include <stdlib.h>

bool mcv_split_validates(uint64_t scene, double share) {
    /* FNV's upper bits depend little on the last bytes: another round mixes them. */
    uint64_t x = scene ^ scene >> 33;
    x *= 0xff51afd7ed558ccdu;
    x ^= x >> 33;
    x *= 0xc4ceb9fe1a85ec53u;
    x ^= x >> 33;
    return (double)(x >> 11) * 0x1p-53 < share;
}

/* The parameters of all rows as the plan has them: a table that was read again has ten digits. */
static mcv_result plan_rows(const mcv_sweep *s, double **rows, mcv_error *error) {
    const size_t columns = s->plan.count;
    *rows = malloc((s->table.row_count * columns + 1) * sizeof **rows);
    if (!*rows) return mcv_fail(error, MCV_FAILED, "no memory for the validation");
    for (size_t row = 0; row < s->table.row_count; ++row) {
        const double *numbers = s->table.rows + row * s->table.columns;
        bool wanted;
        MCV_TRY(mcv_plan_set(&s->plan, (size_t)numbers[mcv_row_fixed(&s->table, MCV_ROW_SET)],
                             *rows + row * columns, &wanted, error));
    }
    return MCV_OK;
}

/* Whether two rows have the same setting of the program. */
static bool same_setting(const mcv_sweep *s, const double *a, const double *b) {
    for (size_t i = 0; i < s->plan.count; ++i)
        if (mcv_judge_has(s->plan.parameters + i) && a[i] != b[i]) return false;
    return true;
}

static mcv_split_setting *setting_of(const mcv_sweep *s, const double *rows, mcv_split *split,
                                     size_t row) {
    const size_t columns = s->plan.count;
    for (size_t i = 0; i < split->count; ++i)
        if (same_setting(s, rows + split->settings[i].row * columns, rows + row * columns))
            return split->settings + i;
    split->settings[split->count] = (mcv_split_setting){.row = row};
    return split->settings + split->count++;
}

/* Adds the rows to their settings; none where values lie outside of 0 to 1. */
static void add_rows(const mcv_sweep *s, size_t metric, const double *rows, mcv_split *split) {
    const mcv_table *table = &s->table;
    for (size_t row = 0; row < table->row_count; ++row) {
        const double value = table->rows[row * table->columns + mcv_row_metric(table, metric)];
        if (isnan(value)) continue;
        if (value < 0 || value > 1) {
            mcv_split_free(split);
            return;
        }
        const uint64_t scene = mcv_judge_scene(s, rows + row * s->plan.count);
        mcv_split_rate *r = setting_of(s, rows, split, row)->rates +
                            mcv_split_validates(scene, s->experiment->measuring.validate);
        r->rate += value;
        ++r->scenes;
    }
}

static void finish(mcv_split_rate *r) {
    const double hits = r->rate;
    r->rate = r->scenes ? hits / (double)r->scenes : NAN;
    r->interval = mcv_wilson(hits, (double)r->scenes, 0.95);
}

static bool is_better(const mcv_sweep *s, size_t metric, double a, double b) {
    const bool smallest = s->measurement.best == metric && !s->measurement.best_largest;
    return isnan(b) || (smallest ? a < b : a > b);
}

mcv_result mcv_split_make(const mcv_sweep *s, size_t metric, mcv_split *split, mcv_error *error) {
    double *rows = NULL;
    *split = (mcv_split){.count = 0};
    if (!(s->experiment->measuring.validate > 0) ||
        !mcv_program_named(s->measurement.metrics[metric].expression))
        return MCV_OK;
    split->settings = calloc(s->table.row_count + 1, sizeof *split->settings);
    if (!split->settings) return mcv_fail(error, MCV_FAILED, "no memory for the validation");
    const mcv_result result = plan_rows(s, &rows, error);
    if (result == MCV_OK)
        add_rows(s, metric, rows, split);
    else
        mcv_split_free(split);
    free(rows);
    for (size_t i = 0; i < split->count; ++i) {
        for (int k = 0; k < 2; ++k) finish(split->settings[i].rates + k);
        if (is_better(s, metric, split->settings[i].rates[MCV_SPLIT_TUNING].rate,
                      split->settings[split->best].rates[MCV_SPLIT_TUNING].rate))
            split->best = i;
    }
    return result;
}

void mcv_split_free(mcv_split *split) {
    free(split->settings);
    *split = (mcv_split){.count = 0};
}
