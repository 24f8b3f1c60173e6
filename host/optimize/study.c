/* SPDX-License-Identifier: Apache-2.0 */
#include "optimize/study.h"

#include "core/output_file.h"
#include "experiment/page.h"
#include "experiment/run_set.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FEWEST = 20 }; /* evaluations */

/* --- what is asked --- */

static mcv_result check(const mcv_optimization_asked *a, mcv_error *error) {
    if (a->objectives.count == 0)
        return mcv_fail(error, MCV_USAGE,
                        "--objective is missing: give NAME=smallest or NAME=largest, a metric's "
                        "name");
    if (a->objectives.count > MCV_SEARCH_OBJECTIVES)
        return mcv_fail(error, MCV_USAGE, "--objective: %zu are given: at most %d",
                        a->objectives.count, MCV_SEARCH_OBJECTIVES);
    if (a->experiment.variation.vary.count > MCV_SURROGATE_PARAMETERS)
        return mcv_fail(error, MCV_USAGE, "--vary: %zu parameters: at most %d",
                        a->experiment.variation.vary.count, MCV_SURROGATE_PARAMETERS);
    if (a->evaluations < FEWEST)
        return mcv_fail(error, MCV_USAGE, "--evaluations %zu: must be %d or more", a->evaluations,
                        FEWEST);
    return MCV_OK;
}

static mcv_result read_objectives(const mcv_optimization_asked *a, mcv_optimization *o,
                                  mcv_error *error) {
    const mcv_measurement *m = &o->sweep.measurement;
    for (size_t i = 0; i < a->objectives.count; ++i) {
        mcv_objective *objective = o->objectives + i;
        MCV_TRY(mcv_measurement_read_goal("objective", a->objectives.items[i], m,
                                          &objective->metric, &objective->largest, error));
        for (size_t k = 0; k < i; ++k)
            if (o->objectives[k].metric == objective->metric)
                return mcv_fail(error, MCV_USAGE, "--objective %s: this metric is one already",
                                a->objectives.items[i]);
    }
    for (size_t i = 0; i < a->better.count; ++i) {
        size_t metric, k = 0;
        double least;
        MCV_TRY(
            mcv_measurement_read_limit("better", a->better.items[i], m, &metric, &least, error));
        while (k < a->objectives.count && o->objectives[k].metric != metric) ++k;
        if (k == a->objectives.count)
            return mcv_fail(error, MCV_USAGE, "--better %s: must name an objective",
                            a->better.items[i]);
        o->search.better[k] = least;
    }
    return MCV_OK;
}

/* --- the space --- */

/* Ranges stay; ranges in steps become lists. */
static mcv_result take_levels(const mcv_levels *from, mcv_levels *to, mcv_error *error) {
    *to = *from;
    if (!from->count) return MCV_OK;
    to->list = malloc(from->count * sizeof *to->list);
    if (!to->list) return mcv_fail(error, MCV_FAILED, "no memory for a parameter's values");
    for (size_t i = 0; i < from->count; ++i) to->list[i] = mcv_levels_at(from, i);
    return MCV_OK;
}

static double middle(const mcv_levels *l) {
    if (l->list) return l->list[0];
    return l->logarithmic ? sqrt(l->from * l->to) : (l->from + l->to) / 2;
}

static bool is_allowed(void *user, const double *values) {
    mcv_optimization *o = user;
    double numbers[MCV_DESIGN_PARAMETERS];
    bool wanted = false;
    mcv_error ignored;
    memcpy(o->point, values, o->space.varied * sizeof *values);
    return mcv_plan_set(&o->space, 0, numbers, &wanted, &ignored) == MCV_OK && wanted;
}

/* Constraints that cannot be read are told before the first render. */
static mcv_result check_space(mcv_optimization *o, mcv_error *error) {
    double numbers[MCV_DESIGN_PARAMETERS];
    bool wanted;
    o->space.sets = o->point;
    o->space.set_count = 1;
    for (size_t i = 0; i < o->space.varied; ++i) o->point[i] = middle(o->levels + i);
    return mcv_plan_set(&o->space, 0, numbers, &wanted, error);
}

static mcv_result make_space(mcv_optimization *o, mcv_error *error) {
    mcv_variation variation = o->experiment.variation;
    variation.where = o->where;
    MCV_TRY(mcv_plan_parameters(&variation, &o->space, error));
    const size_t d = o->space.varied;
    for (size_t i = 0; i < d; ++i)
        MCV_TRY(take_levels(&o->space.parameters[i].levels, o->levels + i, error));
    MCV_TRY(check_space(o, error));
    o->values = malloc(o->sets.count * d * sizeof *o->values);
    o->rows = calloc(o->sets.count, sizeof *o->rows);
    if (!o->values || !o->rows)
        return mcv_fail(error, MCV_FAILED, "no memory for %zu sets", o->sets.count);
    for (size_t i = 0; i < o->sets.count * d; ++i) o->values[i] = o->point[i % d];
    o->sets.values = o->values;
    return MCV_OK;
}

/* --- evaluations --- */

/* With ten digits, as the table has them: a search that is resumed takes the same way. */
static double rounded(double value) {
    char digits[32];
    snprintf(digits, sizeof digits, "%.10g", value);
    return strtod(digits, NULL);
}

static mcv_result check_row(const mcv_optimization *o, const double *row, const mcv_evaluation *e,
                            mcv_error *error) {
    for (size_t i = 0; i < o->search.dimensions; ++i)
        if (!(fabs(row[i] - e->values[i]) <= 1e-8 * fabs(e->values[i])))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: set %zu has other parameters than this search comes to: begin it "
                            "again by --force",
                            o->sweep.table.path, o->next);
    return MCV_OK;
}

/* Where all parameters are a program's, one render serves the whole search: the program looks at
 * its exposures again and again. Only what confirms has renders of its own. */
static uint32_t seed_of(const mcv_optimization *o, const mcv_evaluation *e) {
    bool own = e->stage == MCV_STAGE_CONFIRM;
    for (size_t i = 0; i < o->space.count; ++i)
        own = own || !mcv_judge_has(o->space.parameters + i);
    return own ? e->seed : 0;
}

static mcv_result render(mcv_optimization *o, const mcv_evaluation *e, mcv_error *error) {
    double row[MCV_ROW_MOST];
    bool wanted;
    mcv_plan *plan = &o->sweep.plan;
    memcpy(plan->sets + o->next * plan->varied, e->values, plan->varied * sizeof *row);
    plan->seeds[o->next] = seed_of(o, e);
    MCV_TRY(mcv_plan_set(plan, o->next, row, &wanted, error));
    MCV_TRY(mcv_run_set(&o->sweep, o->next, row, error));
    o->rows[o->next] = o->sweep.table.row_count;
    return MCV_OK;
}

static mcv_result evaluate(void *user, mcv_evaluation *e, mcv_error *error) {
    mcv_optimization *o = user;
    const mcv_table *table = &o->sweep.table;
    if (o->next == o->sets.count)
        return mcv_fail(error, MCV_FAILED, "the search needs more than %zu sets", o->sets.count);
    if (!o->rows[o->next]) MCV_TRY(render(o, e, error));
    const double *row = table->rows + (o->rows[o->next] - 1) * table->columns;
    MCV_TRY(check_row(o, row, e, error));
    for (size_t i = 0; i < o->search.objectives; ++i) {
        const double *q = row + mcv_row_metric(table, o->objectives[i].metric);
        e->results[i] = mcv_optimization_value(o, i, rounded(q[0]));
        e->errors[i] = rounded(q[1]);
    }
    MCV_TRY(mcv_requirements_margins(o, row, e, error));
    ++o->next;
    return MCV_OK;
}

double mcv_optimization_value(const mcv_optimization *o, size_t objective, double result) {
    return o->objectives[objective].largest ? -result : result;
}

static void find_rows(mcv_optimization *o) {
    const mcv_table *table = &o->sweep.table;
    for (size_t i = 0; i < table->row_count; ++i)
        o->rows[(size_t)table->rows[i * table->columns + mcv_row_fixed(table, MCV_ROW_SET)]] =
            i + 1;
}

/* --- all of it --- */

static mcv_result search(const mcv_optimization_asked *asked, mcv_optimization *o,
                         mcv_error *error) {
    o->search = (mcv_search){.dimensions = o->space.varied,
                             .objectives = asked->objectives.count,
                             .levels = o->levels,
                             .budget = asked->evaluations,
                             .seed = o->experiment.variation.seed,
                             .evaluate = evaluate,
                             .allowed = o->where.count ? is_allowed : NULL,
                             .user = o};
    MCV_TRY(read_objectives(asked, o, error));
    MCV_TRY(mcv_requirements_read(asked, o, error));
    MCV_TRY(mcv_experiment_open_table(&o->sweep, error));
    find_rows(o);
    const mcv_result result = mcv_search_run(&o->search, &o->found, error);
    mcv_error later = {""};
    if (o->sweep.table.row_count == 0 || !o->experiment.table) return result;
    if (o->found.winner.count && o->search.objectives == 1) {
        /* The rig of the page is that of the winner: its first evaluation. */
        for (size_t i = 0; i < o->found.count && !o->sweep.shown; ++i)
            if (memcmp(o->found.all[i].unit, o->found.winner.point.unit,
                       o->search.dimensions * sizeof(double)) == 0)
                o->sweep.shown = o->rows[i];
    }
    const mcv_result paged = mcv_experiment_page(&o->sweep, result == MCV_OK ? error : &later);
    return result == MCV_OK ? paged : result;
}

mcv_result mcv_optimization_run(const mcv_optimization_asked *asked, mcv_optimization *o,
                                mcv_error *error) {
    *o = (mcv_optimization){.experiment = asked->experiment,
                            .where = asked->experiment.variation.where,
                            .sets = {.option = "vary", .count = asked->evaluations},
                            .found = {.ended = ""},
                            .sweep = {.table = {.descriptor = -1}}};
    o->sweep.experiment = &o->experiment;
    o->experiment.variation.where = (mcv_texts){NULL, 0};
    o->experiment.verb = "Optimisation";
    o->experiment.put_results = mcv_optimization_put_results;
    o->experiment.results = o;
    MCV_TRY(check(asked, error));
    o->experiment.variation.given = &o->sets;
    MCV_TRY(make_space(o, error));
    MCV_TRY(mcv_experiment_plan(&o->experiment, &o->sweep, error));
    return search(asked, o, error);
}

void mcv_optimization_free(mcv_optimization *o) {
    mcv_search_free(&o->found);
    mcv_experiment_free(&o->sweep);
    for (size_t i = 0; i < o->space.varied; ++i)
        if (o->levels[i].list) mcv_levels_free(o->levels + i);
    o->space.sets = NULL; /* the point, which is not the plan's */
    mcv_plan_free(&o->space);
    free(o->values);
    free(o->rows);
    *o = (mcv_optimization){.sweep = {.table = {.descriptor = -1}}};
}
