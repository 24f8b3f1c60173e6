/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/uncertainty.h"

#include "core/basics.h"

#include "analysis/metrics.h"
#include "verbs/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

mcv_study_asked mcv_uncertainty_asked(const mcv_command *c, const mcv_experiment *experiment) {
    mcv_study_asked asked = {.experiment = *experiment,
                             .correlate = {c->correlate.items, c->correlate.count},
                             .repeats = (size_t)c->repetitions,
                             .trials = (size_t)c->trials,
                             .indices = c->indices};
    asked.experiment.variation.vary = (mcv_texts){c->tolerance.items, c->tolerance.count};
    return asked;
}

/* --- JSON --- */

/* JSON has neither NaN nor infinity. */
static json_t *number(double value) { return isfinite(value) ? json_real(value) : json_null(); }

static json_t *quantity(double value, double uncertainty) {
    return json_pack("{s:o, s:o}", "value", number(value), "uncertainty", number(uncertainty));
}

static json_t *bounded(const mcv_bounded *b) {
    return json_pack("{s:o, s:[o, o]}", "value", number(b->value), "interval", number(b->low),
                     number(b->high));
}

static json_t *effect_json(const mcv_study *s, const mcv_propagated *f, size_t parameter) {
    const mcv_effect *e = f->effects + parameter;
    const mcv_distribution *d = s->tolerances.of + parameter;
    json_t *effect =
        json_pack("{s:s, s:f, s:f, s:o, s:o, s:o, s:b, s:b}", "parameter",
                  s->sweep.plan.parameters[parameter].name, "centre", d->centre, "deviation",
                  mcv_distribution_deviation(d), "effect", quantity(e->effect, e->effect_error),
                  "curvature", quantity(e->curvature, e->curvature_error), "share",
                  number(e->share), "resolved", e->resolved, "curved", e->curved);
    if (s->propagation.indices) {
        json_object_set_new(effect, "first_index", bounded(&e->first));
        json_object_set_new(effect, "total_index", bounded(&e->total));
    }
    return effect;
}

static json_t *metric_json(const mcv_study *s, size_t metric, const mcv_propagated *f) {
    const char *unit = mcv_metric_unit(s->sweep.measurement.metrics[metric].expression,
                                       mcv_sweep_units(&s->sweep));
    json_t *effects = json_array(), *document = json_pack("{s:s}", "unit", unit);
    for (size_t i = 0; i < s->tolerances.count; ++i)
        json_array_append_new(effects, effect_json(s, f, f->order[i]));
    if (s->propagation.repeats)
        json_object_set_new(document, "first_order",
                            json_pack("{s:i, s:o, s:o, s:b}", "repeats", (int)f->repeats, "centre",
                                      quantity(f->nominal, f->nominal_error), "uncertainty",
                                      bounded(&f->linear), "interacts", f->interacts));
    if (s->propagation.trials)
        json_object_set_new(
            document, "monte_carlo",
            json_pack("{s:I, s:o, s:o, s:[o, o], s:o}", "trials", (json_int_t)f->trials, "mean",
                      quantity(f->mean, f->mean_error), "uncertainty", bounded(&f->deviation),
                      "interval", number(f->low), number(f->high), "noise", number(f->noise)));
    json_object_set_new(document, "nonlinear", json_boolean(f->nonlinear));
    json_object_set_new(document, "effects", effects);
    return document;
}

mcv_result mcv_uncertainty_json(const mcv_study *s, double spent, char **text, mcv_error *error) {
    json_t *document = mcv_sweep_json_head(&s->sweep, spent), *metrics = json_object();
    mcv_result result = MCV_OK;
    for (size_t i = 0; i < s->sweep.measurement.count && result == MCV_OK; ++i) {
        mcv_propagated found;
        result = mcv_study_find(s, i, &found, error);
        if (result == MCV_OK)
            json_object_set_new(metrics, s->sweep.measurement.metrics[i].name,
                                metric_json(s, i, &found));
    }
    json_object_set_new(document, "metrics", metrics);
    *text = result == MCV_OK ? json_dumps(document, JSON_COMPACT) : NULL;
    json_decref(document);
    MCV_TRY(result);
    return *text ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the report");
}

/* --- for people --- */

static void put_bounded(FILE *out, const char *what, const mcv_bounded *b) {
    fprintf(out, "  %s: %.4g (95 %%: %.4g to %.4g)\n", what, b->value, b->low, b->high);
}

static void put_effect(FILE *out, const mcv_study *s, const mcv_propagated *f, size_t parameter) {
    const mcv_effect *e = f->effects + parameter;
    fprintf(out, "  %s:", s->sweep.plan.parameters[parameter].name);
    if (!isnan(e->effect)) {
        fprintf(out, " effect %.4g ± %.2g", e->effect, e->effect_error);
        if (e->resolved && !isnan(e->share))
            fprintf(out, ", %.1f %% of the variance", 100 * e->share);
        if (!e->resolved)
            fputs(e->effect == 0 && e->effect_error == 0 ? ", none" : ", not resolved", out);
        if (e->curved) fputs(", curved", out);
    }
    if (!isnan(e->first.value))
        fprintf(out, "%s first index %.3f (%.3f to %.3f), total index %.3f (%.3f to %.3f)",
                isnan(e->effect) ? "" : ";", e->first.value, e->first.low, e->first.high,
                e->total.value, e->total.low, e->total.high);
    fputc('\n', out);
}

static void put_metric(FILE *out, const mcv_study *s, size_t metric, const mcv_propagated *f) {
    fprintf(out, "%s\n", s->sweep.measurement.metrics[metric].name);
    if (s->propagation.repeats && !isnan(f->nominal)) {
        fprintf(out, "  at the centres: %.6g ± %.2g\n", f->nominal, f->nominal_error);
        put_bounded(out, "standard uncertainty, first order", &f->linear);
    }
    if (s->propagation.trials && !isnan(f->mean)) {
        fprintf(out, "  mean of %zu trials: %.6g ± %.2g\n", f->trials, f->mean, f->mean_error);
        put_bounded(out, "standard uncertainty, Monte Carlo", &f->deviation);
        fprintf(out, "  95 %% of the values: %.6g to %.6g\n", f->low, f->high);
        fprintf(out, "  noise of one render, taken off: %.2g\n", f->noise);
    }
    if (isnan(f->nominal) && isnan(f->mean)) fputs("  too few sets could be measured\n", out);
    for (size_t i = 0; i < s->tolerances.count; ++i) put_effect(out, s, f, f->order[i]);
    if (f->interacts) fputs("  parameters that are off together interact\n", out);
    if (f->nonlinear)
        fputs("  not linear over these tolerances: believe Monte Carlo, not the first order\n",
              out);
}

mcv_result mcv_uncertainty_text(const mcv_study *s, double spent, char **text, mcv_error *error) {
    const mcv_table *table = &s->sweep.table;
    size_t size;
    mcv_result result = MCV_OK;
    *text = NULL;
    FILE *out = open_memstream(text, &size);
    if (!out) return mcv_fail(error, MCV_FAILED, "no memory for the report");
    for (size_t i = 0; i < s->sweep.measurement.count && result == MCV_OK; ++i) {
        mcv_propagated found;
        result = mcv_study_find(s, i, &found, error);
        if (result == MCV_OK) put_metric(out, s, i, &found);
    }
    fprintf(out, "%zu sets, %zu failed, %.1f s\n", table->row_count, mcv_table_failed(table),
            spent);
    if (table->path[0])
        fprintf(out, "  %s\n  %s\n  %s\n", table->path, table->sidecar, table->page);
    if (!mcv_text_close(out, text) && result == MCV_OK)
        result = mcv_fail(error, MCV_FAILED, "no memory for the report");
    if (result == MCV_OK) return MCV_OK;
    free(*text);
    *text = NULL;
    return result;
}
