/* SPDX-License-Identifier: Apache-2.0 */
/* What the page of an uncertainty study shows: a sentence for each metric, contributions, the
 * distribution by Monte Carlo, and the tolerances. */
#include "uncertainty/study.h"

#include "experiment/page_parts.h"
#include "io/axis.h"
#include "io/html.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BARS = 24 };

/* A metric of the page: what was found, in the units that are shown. */
typedef struct shown {
    const mcv_study *study;
    const mcv_page *page;
    size_t metric;
    mcv_propagated found; /* in SI */
    double per_si;
    const char *unit;
} shown;

static void put_number(FILE *out, const shown *s, double value) {
    fprintf(out, "%.4g%s%s", value * s->per_si, s->unit[0] ? " " : "", s->unit);
}

static void put_with_error(FILE *out, const shown *s, double value, double error) {
    char words[48];
    mcv_value_words(value * s->per_si, error * s->per_si, words);
    fprintf(out, "%s%s%s", words, s->unit[0] ? " " : "", s->unit);
}

/* "0.12 mm (95 %: 0.11 mm to 0.14 mm)" */
static void put_bounded(FILE *out, const shown *s, const mcv_bounded *b) {
    put_number(out, s, b->value);
    fputs(" (95 %: ", out);
    put_number(out, s, b->low);
    fputs(" to ", out);
    put_number(out, s, b->high);
    fputs(")", out);
}

static const char *name_of(const shown *s, size_t parameter) {
    return s->study->sweep.plan.parameters[parameter].name;
}

/* --- the answer --- */

static void put_answer(FILE *out, const shown *s) {
    const mcv_propagated *f = &s->found;
    const bool trials = !isnan(f->mean), first = !isnan(f->linear.value);
    fputs("<div class=\"answer\"><p><strong>", out);
    mcv_html_text(out, s->study->sweep.measurement.metrics[s->metric].name);
    if (!trials && !first) {
        fputs(" cannot be told: too few sets could be measured.</strong></p></div>\n", out);
        return;
    }
    fputs(" is ", out);
    put_with_error(out, s, trials ? f->mean : f->nominal,
                   trials ? f->deviation.value : f->linear.value);
    fputs(" under these tolerances", out);
    if (trials) {
        fputs("; 95 % of all rigs lie between ", out);
        put_number(out, s, f->low);
        fputs(" and ", out);
        put_number(out, s, f->high);
    }
    fputs(".</strong></p>\n", out);
    if (first && f->effects[f->order[0]].resolved) {
        fputs("<p>The largest contribution is that of ", out);
        mcv_html_text(out, name_of(s, f->order[0]));
        fputs(": ", out);
        put_number(out, s, fabs(f->effects[f->order[0]].effect));
        fputs(".</p>\n", out);
    }
    if (f->nonlinear)
        fputs("<p class=\"warning\">The metric is not linear over these tolerances: believe Monte "
              "Carlo, not the first order.</p>\n",
              out);
    fputs("</div>\n", out);
}

/* --- both methods --- */

static void put_methods(FILE *out, const shown *s) {
    const mcv_propagated *f = &s->found;
    fputs("<table class=\"told\">\n", out);
    if (!isnan(f->nominal)) {
        fputs("<tr><th>at the centres<td>", out);
        put_with_error(out, s, f->nominal, f->nominal_error);
        fprintf(out, ", the mean of %zu renders\n<tr><th>standard uncertainty, first order<td>",
                f->repeats);
        put_bounded(out, s, &f->linear);
        fputs("\n", out);
    }
    if (!isnan(f->mean)) {
        fputs("<tr><th>mean, Monte Carlo<td>", out);
        put_with_error(out, s, f->mean, f->mean_error);
        fprintf(out, ", of %zu trials\n<tr><th>standard uncertainty, Monte Carlo<td>", f->trials);
        put_bounded(out, s, &f->deviation);
        fputs("\n<tr><th>noise of one render, taken off<td>", out);
        put_number(out, s, f->noise);
        fputs("\n", out);
    }
    fputs("</table>\n", out);
}

static void put_index(FILE *out, const mcv_bounded *index) {
    if (isnan(index->value))
        fputs("<td>", out);
    else
        fprintf(out, "<td>%.2f (%.2f to %.2f)", index->value, index->low, index->high);
}

static void put_bar(FILE *out, double share) {
    fprintf(out,
            "<td><svg class=\"bar\" viewBox=\"0 0 120 10\"><rect width=\"%.1f\" height=\"10\" "
            "fill=\"#3b6fb5\"/></svg>",
            120 * fmin(1, fmax(0, share)));
}

static void put_effect(FILE *out, const shown *s, size_t parameter) {
    const mcv_effect *e = s->found.effects + parameter;
    const mcv_tolerances *t = &s->study->tolerances;
    const mcv_shown_unit *unit = s->page->parameters + parameter;
    fputs("<tr><td>", out);
    mcv_html_text(out, name_of(s, parameter));
    fprintf(out, "<td>%.6g%s%s<td>%.4g%s%s<td>", t->of[parameter].centre * unit->per_si,
            unit->name[0] ? " " : "", unit->name,
            mcv_distribution_deviation(t->of + parameter) * unit->per_si, unit->name[0] ? " " : "",
            unit->name);
    if (!isnan(e->effect)) put_with_error(out, s, e->effect, e->effect_error);
    if (!isnan(e->effect) && !e->resolved) fputs(", not resolved", out);
    fputs("<td>", out);
    if (!isnan(e->share)) fprintf(out, "%.1f %%", 100 * e->share);
    put_bar(out, isnan(e->share) ? e->total.value : e->share);
    fprintf(out, "<td>%s", e->curved ? "curved" : "");
    if (s->study->propagation.indices) put_index(out, &e->first);
    if (s->study->propagation.indices) put_index(out, &e->total);
    fputs("\n", out);
}

static void put_effects(FILE *out, const shown *s) {
    fputs("<div class=\"wide\"><table class=\"told\"><tr><th>parameter<th>centre<th>standard "
          "deviation<th>effect of it<th>share<th><th>",
          out);
    if (s->study->propagation.indices) fputs("<th>first index<th>total index", out);
    fputs("\n", out);
    for (size_t i = 0; i < s->study->tolerances.count; ++i) put_effect(out, s, s->found.order[i]);
    fputs("</table></div>\n", out);
    if (s->found.interacts)
        fputs("<p>Parameters that are off together do what none of them does alone.</p>\n", out);
}

/* --- the distribution --- */

/* The trials' values, without those in which one parameter is exchanged. */
static size_t take_values(const shown *s, double *values) {
    const mcv_propagation *p = &s->study->propagation;
    const mcv_table *table = &s->study->sweep.table;
    const size_t first = p->repeats * mcv_propagation_repeat(p), per = mcv_propagation_trial(p);
    size_t count = 0;
    for (size_t i = 0; i < table->row_count; ++i) {
        const double *row = table->rows + i * table->columns;
        const size_t set = (size_t)row[mcv_row_fixed(table, MCV_ROW_SET)];
        const double value = row[mcv_row_metric(table, s->metric)];
        if (set >= first && (set - first) % per < (p->indices ? 2 : 1) && !isnan(value))
            values[count++] = value * s->per_si;
    }
    return count;
}

static void put_histogram(FILE *out, const shown *s, const double *values, size_t count) {
    double range[2] = {INFINITY, -INFINITY};
    size_t bars[BARS] = {0}, most = 1;
    for (size_t i = 0; i < count; ++i) mcv_axis_extend(range, values[i]);
    if (!(range[1] > range[0])) return;
    for (size_t i = 0; i < count; ++i) {
        const double place = (values[i] - range[0]) / (range[1] - range[0]) * BARS;
        const size_t bar = place < BARS ? (size_t)place : BARS - 1;
        if (++bars[bar] > most) most = bars[bar];
    }
    const mcv_axis x = mcv_axis_over(range[0], range[1], false, MCV_PLOT_LEFT,
                                     MCV_PLOT_WIDTH - MCV_PLOT_RIGHT),
                   y = mcv_axis_over(0, (double)most, false, MCV_PLOT_HEIGHT - MCV_PLOT_BOTTOM,
                                     MCV_PLOT_TOP);
    fputs("<div class=\"plots\"><figure>", out);
    mcv_axes_put(out, &x, &y, s->page->metric_names[s->metric].words, "trials");
    for (size_t i = 0; i < BARS; ++i) {
        const double step = (range[1] - range[0]) / BARS,
                     left = mcv_axis_place(&x, range[0] + step * (double)i),
                     right = mcv_axis_place(&x, range[0] + step * (double)(i + 1)),
                     top = mcv_axis_place(&y, (double)bars[i]);
        fprintf(out,
                "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"#3b6fb5\"/>",
                left, top, right - left - 1, mcv_axis_place(&y, 0) - top);
    }
    const double ends[2] = {s->found.low * s->per_si, s->found.high * s->per_si};
    for (int i = 0; i < 2; ++i)
        fprintf(out, "<path class=\"best\" d=\"M%.1f %d V%d\"/>", mcv_axis_place(&x, ends[i]),
                MCV_PLOT_TOP, MCV_PLOT_HEIGHT - MCV_PLOT_BOTTOM);
    fputs("</svg><figcaption>The trials, each with the noise of its render. Lines: 95 % of the "
          "metric without that noise.</figcaption></figure></div>\n",
          out);
}

static bool put_distribution(FILE *out, const shown *s) {
    if (isnan(s->found.mean)) return true;
    double *values = malloc((s->study->sweep.table.row_count + 1) * sizeof *values);
    if (!values) return false;
    put_histogram(out, s, values, take_values(s, values));
    free(values);
    return true;
}

bool mcv_study_put_results(FILE *out, const struct mcv_page *page, void *user) {
    shown s = {.study = user, .page = page};
    bool written = true;
    for (s.metric = 0; s.metric < s.study->sweep.measurement.count && written; ++s.metric) {
        mcv_error ignored;
        if (mcv_study_find(s.study, s.metric, &s.found, &ignored) != MCV_OK) return false;
        s.per_si = page->metrics[s.metric].per_si;
        s.unit = page->metrics[s.metric].name;
        fputs("<h2>", out);
        mcv_html_text(out, page->names[s.metric]);
        fputs("</h2>\n", out);
        put_answer(out, &s);
        put_methods(out, &s);
        put_effects(out, &s);
        written = put_distribution(out, &s);
    }
    return written;
}
