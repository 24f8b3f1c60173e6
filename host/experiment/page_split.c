/* SPDX-License-Identifier: Apache-2.0 */
/* A program's settings on the page: their rates on the scenes of tuning and of validation. */
#include "experiment/page_parts.h"

#include "experiment/split.h"
#include "io/html.h"

#include <math.h>

static void put_rate(FILE *out, const mcv_split_rate *r) {
    if (isnan(r->rate))
        fputs("<td>no scenes", out);
    else
        fprintf(out, "<td>%.3g %% (%.3g to %.3g %%) of %zu", 100 * r->rate, 100 * r->interval.low,
                100 * r->interval.high, r->scenes);
}

static void put_setting(FILE *out, const mcv_page *page, const mcv_split_setting *setting,
                        bool best) {
    const mcv_sweep *s = page->sweep;
    const double *row = s->table.rows + setting->row * s->table.columns;
    fputs(best ? "<tr class=\"best\"><th>" : "<tr><th>", out);
    const char *comma = "";
    mcv_value_text value;
    for (size_t i = 0; i < s->plan.count; ++i) {
        if (!mcv_judge_has(s->plan.parameters + i)) continue;
        fputs(comma, out);
        mcv_html_text(out, s->plan.parameters[i].name);
        fprintf(out, " %s", mcv_parameter_text(s->plan.parameters + i, row[i], 6, value));
        comma = ", ";
    }
    for (int side = 0; side < 2; ++side) put_rate(out, setting->rates + side);
    fputs("\n", out);
}

bool mcv_page_put_split(FILE *out, const mcv_page *page) {
    const mcv_measurement *m = &page->sweep->measurement;
    for (size_t metric = 0; metric < m->count; ++metric) {
        mcv_split split;
        mcv_error ignored;
        if (mcv_split_make(page->sweep, metric, &split, &ignored) != MCV_OK) return false;
        if (split.count == 0) continue;
        fputs("<h2>Tuned and validated: ", out);
        mcv_html_text(out, m->metrics[metric].name);
        fputs("</h2>\n<p>The best setting is chosen on the scenes of tuning. What it reaches on "
              "those "
              "of validation, which had no part in the choice, is what it is worth. Intervals hold "
              "in 95 %.</p>\n<table class=\"told\">\n<tr><th>setting<th>tuning<th>validation\n",
              out);
        for (size_t i = 0; i < split.count; ++i)
            put_setting(out, page, split.settings + i, i == split.best);
        fputs("</table>\n", out);
        mcv_split_free(&split);
    }
    return true;
}
