/* SPDX-License-Identifier: Apache-2.0 */
#include "uncertainty/study.h"

#include "loader/overrides.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FEWEST_TRIALS = 10 };

static mcv_result check(const mcv_study_asked *a, mcv_error *error) {
    if (a->experiment.variation.vary.count == 0)
        return mcv_fail(error, MCV_USAGE,
                        "--tolerance is missing: give what varies, as in --tolerance "
                        "'nodes/part/turnX=normal(0.5deg)'");
    if (a->repeats == 1)
        return mcv_fail(error, MCV_USAGE,
                        "--repeats 1: must be 2 or more, whose spread is the renders' noise, or 0");
    if (a->trials > 0 && a->trials < FEWEST_TRIALS)
        return mcv_fail(error, MCV_USAGE, "--trials %zu: must be %d or more, or 0", a->trials,
                        FEWEST_TRIALS);
    if (a->repeats + a->trials == 0)
        return mcv_fail(error, MCV_USAGE,
                        "--repeats 0 and --trials 0 leave nothing to do: give one of them");
    if (a->indices && !a->trials)
        return mcv_fail(error, MCV_USAGE, "--indices needs --trials: they are found by them");
    if (a->indices && a->correlate.count)
        return mcv_fail(error, MCV_USAGE,
                        "--indices: Sobol' indices are those of independent tolerances: leave out "
                        "--correlate or --indices");
    return MCV_OK;
}

/* --- nominal values --- */

/* Tolerances without a centre are about the value that the scene states. */
static mcv_result find_centres(const mcv_experiment *e, const mcv_plan *plan, mcv_tolerances *t,
                               mcv_error *error) {
    for (size_t i = 0; i < t->count; ++i) {
        const mcv_parameter *p = plan->parameters + i;
        char path[1024];
        mcv_error why = {""};
        if (!isnan(t->of[i].centre)) continue;
        snprintf(path, sizeof path, "%.*s", p->path_length, p->item);
        if (mcv_overrides_number(path, e->set, e->document, &t->of[i].centre, &why) != MCV_OK)
            return mcv_fail(error, MCV_BAD_INPUT,
                            "--tolerance %s: %s: give the centre, as in normal(25mm,0.1mm)",
                            p->item, why.text);
    }
    return MCV_OK;
}

/* --- sets --- */

static mcv_result make_sets(mcv_study *s, mcv_error *error) {
    const size_t points = mcv_propagation_points(&s->propagation), count = s->tolerances.count;
    if (points > MCV_DESIGN_SETS)
        return mcv_fail(error, MCV_USAGE, "--trials: makes %zu sets: at most %d", points,
                        MCV_DESIGN_SETS);
    s->values = malloc(points * count * sizeof *s->values);
    s->seeds = malloc(points * sizeof *s->seeds);
    if (!s->values || !s->seeds)
        return mcv_fail(error, MCV_FAILED, "no memory for %zu sets", points);
    for (size_t i = 0; i < points; ++i)
        mcv_propagation_point(&s->propagation, i, s->experiment.variation.seed,
                              s->values + i * count, s->seeds + i);
    s->sets.values = s->values;
    s->sets.seeds = s->seeds;
    s->sets.count = points;
    return MCV_OK;
}

static mcv_result plan(const mcv_study_asked *asked, mcv_study *s, mcv_error *error) {
    mcv_plan names;
    MCV_TRY(check(asked, error));
    mcv_result result = mcv_plan_parameters(&s->experiment.variation, &names, error);
    if (result == MCV_OK)
        result = mcv_tolerances_read(&names, asked->correlate, &s->tolerances, error);
    if (result == MCV_OK) result = find_centres(&s->experiment, &names, &s->tolerances, error);
    mcv_plan_free(&names);
    return result == MCV_OK ? make_sets(s, error) : result;
}

mcv_result mcv_study_run(const mcv_study_asked *asked, mcv_study *s, mcv_error *error) {
    *s = (mcv_study){.experiment = asked->experiment,
                     .propagation = {.tolerances = &s->tolerances,
                                     .repeats = asked->repeats,
                                     .trials = asked->trials,
                                     .indices = asked->indices},
                     .sets = {.option = "tolerance"},
                     .sweep = {.table = {.descriptor = -1}}};
    s->sweep.experiment = &s->experiment;
    s->experiment.variation.given = &s->sets;
    s->experiment.verb = "Uncertainty";
    s->experiment.put_results = mcv_study_put_results;
    s->experiment.results = s;
    MCV_TRY(plan(asked, s, error));
    MCV_TRY(mcv_experiment_plan(&s->experiment, &s->sweep, error));
    MCV_TRY(mcv_experiment_open_table(&s->sweep, error));
    return mcv_experiment_run(&s->sweep, error);
}

mcv_result mcv_study_find(const mcv_study *s, size_t metric, mcv_propagated *found,
                          mcv_error *error) {
    const mcv_table *table = &s->sweep.table;
    const size_t points = s->sets.count, at = mcv_row_metric(table, metric);
    double *values = malloc(2 * points * sizeof *values);
    if (!values) return mcv_fail(error, MCV_FAILED, "no memory for %zu values", points);
    for (size_t i = 0; i < 2 * points; ++i) values[i] = NAN;
    for (size_t i = 0; i < table->row_count; ++i) {
        const double *row = table->rows + i * table->columns;
        memcpy(values + 2 * (size_t)row[mcv_row_fixed(table, MCV_ROW_SET)], row + at,
               2 * sizeof *values);
    }
    const mcv_result result = mcv_propagate(&s->propagation, values, 2, found, error);
    free(values);
    return result;
}

void mcv_study_free(mcv_study *s) {
    mcv_experiment_free(&s->sweep);
    free(s->values);
    free(s->seeds);
    *s = (mcv_study){.sweep = {.table = {.descriptor = -1}}};
}
