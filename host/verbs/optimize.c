/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/optimize.h"

#include "core/basics.h"

#include "verbs/sweep.h"

#include <math.h>
#include <stdlib.h>

mcv_optimization_asked mcv_optimize_asked(const mcv_command *c, const mcv_experiment *experiment) {
    return (mcv_optimization_asked){.experiment = *experiment,
                                    .objectives = {c->objective.items, c->objective.count},
                                    .better = {c->better.items, c->better.count},
                                    .require = {c->require.items, c->require.count},
                                    .evaluations = (size_t)c->evaluations};
}

static const char *objective_name(const mcv_optimization *o, size_t objective) {
    return o->sweep.measurement.metrics[o->objectives[objective].metric].name;
}

/* --- JSON --- */

/* JSON has neither NaN nor infinity. */
static json_t *number(double value) { return isfinite(value) ? json_real(value) : json_null(); }

/* Parameters by name, objectives with their uncertainty. */
static json_t *point_json(const mcv_optimization *o, const mcv_confirmed *c) {
    json_t *parameters = json_object(), *objectives = json_object();
    for (size_t i = 0; i < o->search.dimensions; ++i)
        json_object_set_new(parameters, o->sweep.plan.parameters[i].name,
                            mcv_parameter_json(o->sweep.plan.parameters + i, c->point.values[i]));
    for (size_t k = 0; k < o->search.objectives; ++k)
        json_object_set_new(objectives, objective_name(o, k),
                            json_pack("{s:o, s:o}", "value",
                                      number(mcv_optimization_value(o, k, c->point.results[k])),
                                      "uncertainty", number(c->point.errors[k])));
    return json_pack("{s:o, s:o, s:I}", "parameters", parameters, "objectives", objectives,
                     "renders", (json_int_t)c->count);
}

/* The margin is below 0 where the requirement is met. */
static json_t *requirements_json(const mcv_optimization *o) {
    json_t *list = json_array();
    const mcv_evaluation *e = &o->found.winner.point;
    for (size_t k = 0; k < o->search.requirements; ++k)
        json_array_append_new(
            list, json_pack("{s:s, s:o, s:o, s:b}", "requirement", o->requirements[k].text,
                            "margin", number(e->margins[k]), "uncertainty",
                            number(e->margin_errors[k]), "met", e->margins[k] <= 0));
    return list;
}

static json_t *winner_json(const mcv_optimization *o) {
    const mcv_search_result *f = &o->found;
    const bool largest = o->objectives[0].largest;
    json_t *winner = point_json(o, &f->winner), *near = json_object();
    json_object_set_new(
        winner, "interval",
        json_pack("[o, o]", number(mcv_optimization_value(o, 0, largest ? f->high : f->low)),
                  number(mcv_optimization_value(o, 0, largest ? f->low : f->high))));
    json_object_set_new(winner, "in_search",
                        number(mcv_optimization_value(o, 0, f->winner.in_search)));
    for (size_t i = 0; i < o->search.dimensions; ++i)
        if (!o->levels[i].named) /* words have no order */
            json_object_set_new(near, o->sweep.plan.parameters[i].name,
                                json_pack("[f, f]", f->near[i][0], f->near[i][1]));
    json_object_set_new(winner, "as_good_within", near);
    if (o->search.requirements) json_object_set_new(winner, "requirements", requirements_json(o));
    return winner;
}

mcv_result mcv_optimize_json(const mcv_optimization *o, double spent, char **text,
                             mcv_error *error) {
    json_t *document = mcv_sweep_json_head(&o->sweep, spent), *points = json_array();
    json_object_set_new(document, "ended", json_string(o->found.ended));
    for (size_t i = 0; i < o->found.point_count; ++i)
        json_array_append_new(points, point_json(o, o->found.points + i));
    if (o->search.objectives == 1) json_object_set_new(document, "winner", winner_json(o));
    json_object_set_new(document, o->search.objectives == 1 ? "rivals" : "front", points);
    *text = json_dumps(document, JSON_COMPACT);
    json_decref(document);
    return *text ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the report");
}

/* --- for people --- */

static void put_point(FILE *out, const mcv_optimization *o, const char *what,
                      const mcv_confirmed *c) {
    mcv_value_text value;
    fprintf(out, "%s:", what);
    for (size_t i = 0; i < o->search.dimensions; ++i)
        fprintf(out, "%s %s %s", i ? "," : "", o->sweep.plan.parameters[i].name,
                mcv_parameter_text(o->sweep.plan.parameters + i, c->point.values[i], 6, value));
    for (size_t k = 0; k < o->search.objectives && c->count; ++k)
        fprintf(out, "; %s %.5g ± %.2g", objective_name(o, k),
                mcv_optimization_value(o, k, c->point.results[k]), c->point.errors[k]);
    fputc('\n', out);
}

static void put_winner(FILE *out, const mcv_optimization *o) {
    const mcv_search_result *f = &o->found;
    const double ends[2] = {mcv_optimization_value(o, 0, f->low),
                            mcv_optimization_value(o, 0, f->high)};
    put_point(out, o, "best", &f->winner);
    fprintf(out, "  95 %%: %.5g to %.5g, from %zu renders that have chosen nothing\n",
            fmin(ends[0], ends[1]), fmax(ends[0], ends[1]), f->winner.count);
    fprintf(out, "  in the search it looked like %.5g\n",
            mcv_optimization_value(o, 0, f->winner.in_search));
    for (size_t k = 0; k < o->search.requirements; ++k)
        fprintf(out, "  %s: %s by %.3g ± %.2g\n", o->requirements[k].text,
                f->winner.point.margins[k] <= 0 ? "met" : "missed",
                fabs(f->winner.point.margins[k]), f->winner.point.margin_errors[k]);
    for (size_t i = 0; i < o->search.dimensions; ++i)
        if (!o->levels[i].named)
            fprintf(out, "  %s: as good from %.5g to %.5g\n", o->sweep.plan.parameters[i].name,
                    f->near[i][0], f->near[i][1]);
    for (size_t i = 1; i < f->point_count; ++i) put_point(out, o, "rival", f->points + i);
}

mcv_result mcv_optimize_text(const mcv_optimization *o, double spent, char **text,
                             mcv_error *error) {
    const mcv_table *table = &o->sweep.table;
    size_t size;
    *text = NULL;
    FILE *out = open_memstream(text, &size);
    if (!out) return mcv_fail(error, MCV_FAILED, "no memory for the report");
    if (o->search.objectives == 1) put_winner(out, o);
    for (size_t i = 0; i < o->found.point_count && o->search.objectives > 1; ++i)
        put_point(out, o, "front", o->found.points + i);
    fprintf(out, "%zu sets, %zu failed, %.1f s: %s\n", table->row_count, mcv_table_failed(table),
            spent, o->found.ended);
    if (table->path[0])
        fprintf(out, "  %s\n  %s\n  %s\n", table->path, table->sidecar, table->page);
    if (mcv_text_close(out, text)) return MCV_OK;
    return mcv_fail(error, MCV_FAILED, "no memory for the report");
}
