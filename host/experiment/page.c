/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/page.h"

#include "check/setup_page.h"
#include "experiment/page_parts.h"
#include "experiment/run_set.h"
#include "experiment/set_picture.h"
#include "io/embedded.h"
#include "io/html.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- numbers and names --- */

static double largest_of(const mcv_table *table, size_t metric) {
    const double *extremes[2];
    const size_t at = mcv_row_metric(table, metric);
    mcv_table_extremes(table, metric, extremes);
    return extremes[0] ? fmax(fabs(extremes[0][at]), fabs(extremes[1][at])) : 0;
}

/* "material, 0: steel, 1: brass": plots have numbers. */
static void tell_words(const mcv_parameter *p, mcv_page_name *name) {
    mcv_value_text value;
    for (size_t i = 0; i < p->levels.count; ++i) {
        const size_t at = strlen(name->words);
        snprintf(name->words + at, sizeof name->words - at, ", %zu: %s", i,
                 mcv_parameter_text(p, (double)i, 6, value));
    }
}

static void name_columns(mcv_page *page) {
    const mcv_plan *plan = &page->sweep->plan;
    const mcv_measurement *m = &page->sweep->measurement;
    for (size_t i = 0; i < plan->varied; ++i) {
        mcv_page_name *name = page->parameter_names + i;
        page->parameters[i] = mcv_unit_of_parameter(plan->parameters + i);
        mcv_name_with_unit(plan->parameters[i].name, page->parameters + i, name->words,
                           sizeof name->words);
        if (plan->parameters[i].levels.named) tell_words(plan->parameters + i, name);
        page->axes[i] = (mcv_plots_axis){name->words, plan->parameters[i].levels.logarithmic};
    }
    for (size_t i = 0; i < m->count; ++i) {
        mcv_page_name *name = page->metric_names + i;
        page->metrics[i] =
            mcv_unit_of_metric(m->metrics[i].expression, mcv_sweep_units(page->sweep),
                               largest_of(&page->sweep->table, i));
        mcv_name_with_unit(m->metrics[i].name, page->metrics + i, name->words, sizeof name->words);
        page->names[i] = name->words;
    }
}

static bool make_numbers(mcv_page *page) {
    const mcv_table *table = &page->sweep->table;
    const mcv_measurement *m = table->measurement;
    const size_t varied = table->plan->varied, columns = varied + 2 * m->count;
    double *numbers = calloc(table->row_count * columns + 1, sizeof *numbers);
    size_t *sets = calloc(table->row_count + 1, sizeof *sets);
    for (size_t row = 0; numbers && sets && row < table->row_count; ++row) {
        const double *from = table->rows + row * table->columns,
                     *metrics = from + mcv_row_metric(table, 0);
        double *to = numbers + row * columns;
        sets[row] = (size_t)from[mcv_row_fixed(table, MCV_ROW_SET)];
        for (size_t i = 0; i < varied; ++i) to[i] = from[i] * page->parameters[i].per_si;
        for (size_t i = 0; i < 2 * m->count; ++i)
            to[varied + i] = metrics[i] * page->metrics[i / 2].per_si;
    }
    page->plots = (mcv_plots){page->axes, varied,           page->names,      m->count, numbers,
                              sets,       table->row_count, table->row_count, m->best};
    if (numbers && sets && m->best < m->count)
        page->plots.best = mcv_page_extreme(page->sweep, m->best, m->best_largest);
    return numbers && sets;
}

/* --- the page --- */

static void put_head(FILE *out, const mcv_page *page) {
    const mcv_experiment *e = page->sweep->experiment;
    const char *slash = strrchr(e->rig, '/');
    char title[PATH_MAX + 16], policy[160];
    snprintf(title, sizeof title, "%s of %s", e->verb ? e->verb : "Sweep",
             slash ? slash + 1 : e->rig);
    snprintf(policy, sizeof policy, "; script-src '%s'; img-src data:", mcv_sweep_js_hash);
    mcv_html_begin(out, e->title ? e->title : title, true, policy);
    fputs("<p class=\"file\">", out);
    mcv_html_date(out);
    fputs(" · mcvisi " MCV_VERSION " · ", out);
    fprintf(out, "%zu of %zu sets", page->sweep->table.row_count, page->sweep->plan.wanted);
    if (mcv_table_failed(&page->sweep->table))
        fprintf(out, ", %zu failed", mcv_table_failed(&page->sweep->table));
    fputs("</p>\n", out);
    if (!e->note) return;
    fputs("<p>", out);
    mcv_html_text(out, e->note);
    fputs("</p>\n", out);
}

static bool put_plots(FILE *out, const mcv_page *page) {
    const mcv_plots *p = &page->plots;
    bool written = true;
    for (size_t metric = 0; metric < p->metric_count; ++metric) {
        fputs("<h2>", out);
        mcv_html_text(out, p->metrics[metric]);
        fputs("</h2>\n<div class=\"plots\">", out);
        if (p->parameter_count == 2) mcv_plots_put_map(out, p, metric);
        for (size_t x = 0; x < p->parameter_count; ++x)
            written = mcv_plots_put_curves(out, p, metric, x) && written;
        fputs("</div>\n", out);
    }
    return written;
}

static bool put_results(FILE *out, const mcv_page *page) {
    const mcv_experiment *e = page->sweep->experiment;
    if (e->put_results) return e->put_results(out, page, e->results);
    mcv_page_put_best(out, page);
    mcv_page_put_extremes(out, page);
    return mcv_page_put_split(out, page) && put_plots(out, page);
}

/* The scene of the best set, or of the first that has not failed. */
static mcv_scene *load_shown(const mcv_page *page, uint32_t *sensor, size_t *shown) {
    const mcv_sweep *s = page->sweep;
    const mcv_table *table = &s->table;
    mcv_scene *scene = NULL;
    mcv_set_texts texts;
    mcv_error ignored;
    *shown = 0;
    while (*shown + 1 < table->row_count && table->messages[*shown]) ++*shown;
    if (s->measurement.best < s->measurement.count) {
        const size_t best = mcv_page_extreme(s, s->measurement.best, s->measurement.best_largest);
        if (best < table->row_count) *shown = best;
    }
    if (s->shown) *shown = s->shown - 1;
    if (mcv_load_set(s, table->rows + *shown * table->columns, texts, &scene, &ignored) != MCV_OK)
        return NULL;
    if (mcv_set_sensor(s->experiment, scene, sensor, &ignored) == MCV_OK) return scene;
    mcv_scene_free(scene);
    return NULL;
}

static bool put_page(FILE *out, void *user) {
    mcv_page *page = user;
    const mcv_sweep *s = page->sweep;
    uint32_t sensor = 0;
    size_t shown;
    mcv_scene *scene = load_shown(page, &sensor, &shown);
    name_columns(page);
    bool written = make_numbers(page);
    if (written) {
        put_head(out, page);
        written = put_results(out, page);
        if (scene) fprintf(out, "<h2>The rig, as in set %zu</h2>\n", page->plots.sets[shown]);
        written = (!scene || mcv_setup_put_view(out, scene, sensor, false, NULL, NULL)) && written;
        if (!s->experiment->put_results)
            mcv_page_put_sets(out, page);
        else if (scene)
            page->stopped = mcv_put_set_pictures(out, s, shown, page->error);
        mcv_page_put_assumed(out, page, scene);
        fputs("<footer><p>Scene ", out);
        mcv_html_text(out, s->experiment->rig);
        fprintf(out, ", fingerprint %s. Table ", s->fingerprint);
        mcv_html_text(out, s->table.path);
        fputs(", in SI units. Experiment ", out);
        mcv_html_text(out, s->table.sidecar);
        fprintf(out, ".</p></footer>\n<script>%s</script></body></html>\n", mcv_sweep_js);
    }
    free((double *)page->plots.values);
    free((size_t *)page->plots.sets);
    mcv_scene_free(scene);
    return written;
}

mcv_result mcv_experiment_page(const mcv_sweep *sweep, mcv_error *error) {
    mcv_page *page = calloc(1, sizeof *page);
    if (!page) return mcv_fail(error, MCV_FAILED, "%s: no memory to write it", sweep->table.page);
    page->sweep = sweep;
    page->error = error;
    mcv_result result = mcv_html_write(sweep->table.page, put_page, page, error);
    if (result == MCV_OK) result = page->stopped;
    free(page);
    return result;
}
