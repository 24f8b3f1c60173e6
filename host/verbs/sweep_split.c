/* SPDX-License-Identifier: Apache-2.0 */
/* What is told of a program's settings, tuned and validated (experiment/split.h). */
#include "verbs/sweep_split.h"

#include <math.h>

static const char *const sides[2] = {"tuning", "validation"};

static json_t *rate_json(const mcv_split_rate *r) {
    json_t *rate = json_object();
    json_object_set_new(rate, "scenes", json_integer((json_int_t)r->scenes));
    json_object_set_new(rate, "rate", isnan(r->rate) ? json_null() : json_real(r->rate));
    json_object_set_new(rate, "low", json_real(r->interval.low));
    json_object_set_new(rate, "high", json_real(r->interval.high));
    return rate;
}

static json_t *setting_json(const mcv_sweep *s, const mcv_split_setting *setting, bool best) {
    const double *row = s->table.rows + setting->row * s->table.columns;
    json_t *object = json_object(), *parameters = json_object();
    for (size_t i = 0; i < s->plan.count; ++i)
        if (mcv_judge_has(s->plan.parameters + i))
            json_object_set_new(parameters, s->plan.parameters[i].name,
                                mcv_parameter_json(s->plan.parameters + i, row[i]));
    json_object_set_new(object, "parameters", parameters);
    for (int k = 0; k < 2; ++k)
        json_object_set_new(object, sides[k], rate_json(setting->rates + k));
    json_object_set_new(object, "best", json_boolean(best));
    return object;
}

mcv_result mcv_sweep_split_json(const mcv_sweep *s, json_t *document, mcv_error *error) {
    json_t *metrics = json_object();
    mcv_result result = MCV_OK;
    for (size_t metric = 0; metric < s->measurement.count && result == MCV_OK; ++metric) {
        mcv_split split;
        result = mcv_split_make(s, metric, &split, error);
        if (result != MCV_OK || split.count == 0) continue;
        json_t *settings = json_array();
        for (size_t i = 0; i < split.count; ++i)
            json_array_append_new(settings, setting_json(s, split.settings + i, i == split.best));
        json_object_set_new(metrics, s->measurement.metrics[metric].name, settings);
        mcv_split_free(&split);
    }
    if (json_object_size(metrics)) json_object_set(document, "validation", metrics);
    json_decref(metrics);
    return result;
}

static void put_rate(FILE *out, const mcv_split_rate *r, const char *side) {
    if (isnan(r->rate))
        fprintf(out, "no scenes of %s", side);
    else
        fprintf(out, "%.3g %% (%.3g to %.3g %%) on %zu scenes of %s", 100 * r->rate,
                100 * r->interval.low, 100 * r->interval.high, r->scenes, side);
}

mcv_result mcv_sweep_split_text(const mcv_sweep *s, FILE *out, mcv_error *error) {
    for (size_t metric = 0; metric < s->measurement.count; ++metric) {
        mcv_split split;
        MCV_TRY(mcv_split_make(s, metric, &split, error));
        if (split.count == 0) continue;
        const mcv_split_setting *best = split.settings + split.best;
        const double *row = s->table.rows + best->row * s->table.columns;
        mcv_value_text value;
        fprintf(out, "tuned for %s:", s->measurement.metrics[metric].name);
        for (size_t i = 0; i < s->plan.count; ++i)
            if (mcv_judge_has(s->plan.parameters + i))
                fprintf(out, " %s %s,", s->plan.parameters[i].name,
                        mcv_parameter_text(s->plan.parameters + i, row[i], 5, value));
        fputc(' ', out);
        put_rate(out, best->rates + MCV_SPLIT_TUNING, "tuning");
        fputs("; ", out);
        put_rate(out, best->rates + MCV_SPLIT_VALIDATION, "validation");
        fputc('\n', out);
        mcv_split_free(&split);
    }
    return MCV_OK;
}
