/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/sweep.h"

#include "analysis/metrics.h"
#include "core/json.h"
#include "reference/reference.h"
#include "verbs/grey_picture.h"
#include "verbs/places.h"
#include "verbs/render_picture.h"
#include "verbs/sweep_split.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool mcv_read_share(const char *text, size_t share[2]) {
    char *slash, *end;
    const unsigned long part = strtoul(text, &slash, 10);
    if (!isdigit((unsigned char)text[0]) || slash[0] != '/' || !isdigit((unsigned char)slash[1]))
        return false;
    const unsigned long parts = strtoul(slash + 1, &end, 10);
    share[0] = part;
    share[1] = parts;
    return *end == '\0' && part < parts && parts <= 1000000;
}

/* --range; zeros without it. */
static mcv_result read_range(const char *text, size_t share[2], mcv_error *error) {
    share[0] = share[1] = 0;
    return !text || mcv_read_share(text, share)
               ? MCV_OK
               : mcv_fail(error, MCV_USAGE,
                          "--range %s: must be I/N with I from 0 to N - 1, as in 0/8", text);
}

mcv_result mcv_sweep_experiment(const mcv_command *c, mcv_experiment *experiment,
                                mcv_error *error) {
    *experiment =
        (mcv_experiment){.set = {c->set.items, c->set.count},
                         .sensor = c->sensor,
                         .resolution = {c->resolution[0], c->resolution[1]},
                         .variation = {.vary = mcv_texts_of(&c->vary),
                                       .tie = mcv_texts_of(&c->tie),
                                       .where = mcv_texts_of(&c->where),
                                       .design = (int)c->design,
                                       .points = (size_t)c->points,
                                       .seed = (uint32_t)c->design_seed},
                         .measuring = {.metrics = mcv_texts_of(&c->metric),
                                       .until = mcv_texts_of(&c->until),
                                       .bound = c->bound,
                                       .best = c->best,
                                       .places = mcv_places_of(c),
                                       .camera = mcv_camera_settings_of(c),
                                       .channel = c->channel,
                                       .in_gradient = c->in != 0,
                                       .form = c->form ? MCV_EMD_MASS : MCV_EMD_NORMALIZED,
                                       .threads = (uint32_t)c->threads,
                                       .allow_exec = c->allow_exec,
                                       .exposures = (size_t)c->exposures,
                                       .exec_time = c->exec_time,
                                       .validate = c->validate},
                         .render_with = mcv_wants_reference(c) ? mcv_reference_render : NULL,
                         .own_noise = c->set_noise != 0,
                         .images = c->images,
                         .title = c->title,
                         .note = c->note,
                         .resume = c->resume,
                         .force = c->again};
    experiment->measuring.places.bound = c->bound != NULL;
    MCV_TRY(read_range(c->share, experiment->share, error));
    if (c->resume && c->again)
        return mcv_fail(error, MCV_USAGE, "--force begins the table again: leave out --resume");
    return mcv_render_options_read(c, &experiment->render, error);
}

json_t *mcv_sweep_settings(const mcv_command *command) {
    static const char *const without[] = {"output",  "images",   "resume", "force", "device",
                                          "threads", "schedule", "memory", "json",  NULL};
    json_t *settings = mcv_command_json(command, without);
    if (command->noise_free) mcv_json_put(&settings, "noise-free", json_true());
    return settings;
}

/* --- what is told --- */

/* JSON has neither NaN nor infinity. */
static json_t *number(double value) { return isfinite(value) ? json_real(value) : json_null(); }

static json_t *parameters_json(const mcv_sweep *s, const double *row) {
    json_t *where = json_object();
    for (size_t i = 0; i < s->plan.count; ++i)
        json_object_set_new(where, s->plan.parameters[i].name,
                            mcv_parameter_json(s->plan.parameters + i, row[i]));
    return where;
}

/* {"value": …, "uncertainty": …, "set": …, "parameters": {…}} */
static json_t *describe_row(const mcv_sweep *s, size_t metric, const double *row) {
    const double *q = row + mcv_row_metric(&s->table, metric);
    json_t *point = json_object();
    json_object_set_new(point, "value", json_real(q[0]));
    json_object_set_new(point, "uncertainty", number(q[1]));
    json_object_set_new(point, "set",
                        json_integer((json_int_t)row[mcv_row_fixed(&s->table, MCV_ROW_SET)]));
    json_object_set_new(point, "parameters", parameters_json(s, row));
    return point;
}

/* Where each metric is largest and smallest. */
static json_t *extremes_json(const mcv_sweep *s) {
    static const char *const words[2] = {"smallest", "largest"};
    json_t *all = json_object();
    for (size_t i = 0; i < s->measurement.count; ++i) {
        const double *extremes[2];
        json_t *of = json_object();
        mcv_table_extremes(&s->table, i, extremes);
        for (int k = 0; k < 2 && extremes[0]; ++k)
            json_object_set_new(of, words[k], describe_row(s, i, extremes[k]));
        json_object_set_new(all, s->measurement.metrics[i].name, of);
    }
    return all;
}

/* In SI units, as the table is. */
static json_t *describe_metric(const mcv_sweep *s, size_t metric, const double *row) {
    const double *q = row + mcv_row_metric(&s->table, metric);
    return json_pack(
        "{s:o, s:o, s:s}", "value", number(q[0]), "uncertainty", number(q[1]), "unit",
        mcv_metric_unit(s->measurement.metrics[metric].expression, mcv_sweep_units(s)));
}

json_t *mcv_sweep_json_head(const mcv_sweep *s, double spent) {
    const mcv_table *table = &s->table;
    json_t *document = json_object();
    if (table->path[0]) {
        json_object_set_new(document, "table", mcv_json_text(table->path));
        json_object_set_new(document, "page", mcv_json_text(table->page));
        json_object_set_new(document, "experiment", mcv_json_text(table->sidecar));
    }
    json_object_set_new(document, "rows", json_integer((json_int_t)table->row_count));
    json_object_set_new(document, "failed", json_integer((json_int_t)mcv_table_failed(table)));
    json_object_set_new(document, "seconds", json_real(spent));
    json_object_set_new(document, "fingerprint", json_string(s->fingerprint));
    return document;
}

mcv_result mcv_sweep_json(const mcv_sweep *s, double spent, char **text, mcv_error *error) {
    json_t *document = mcv_sweep_json_head(s, spent);
    json_object_set_new(document, "stage_seconds", json_real(s->stage_seconds));
    json_object_set_new(document, "renders", json_integer((json_int_t)s->renders));
    json_object_set_new(document, "assets_read",
                        json_integer((json_int_t)mcv_asset_cache_reads(s->assets)));
    json_object_set_new(document, "structures_built", json_integer((json_int_t)s->built));
    json_object_set_new(document, "programs_built", json_integer((json_int_t)s->compiled));
    json_object_set_new(document, "metrics", extremes_json(s));
    const mcv_result result = mcv_sweep_split_json(s, document, error);
    *text = result == MCV_OK ? json_dumps(document, JSON_COMPACT) : NULL;
    json_decref(document);
    MCV_TRY(result);
    return *text ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the report");
}

char *mcv_sweep_row_json(const mcv_sweep *s, const double *row, const char *message) {
    const mcv_table *table = &s->table;
    json_t *document = json_object(), *metrics = json_object();
    for (size_t i = 0; i < s->measurement.count; ++i)
        json_object_set_new(metrics, s->measurement.metrics[i].name, describe_metric(s, i, row));
    json_object_set_new(document, "set",
                        json_integer((json_int_t)row[mcv_row_fixed(table, MCV_ROW_SET)]));
    json_object_set_new(document, "sets", json_integer((json_int_t)s->plan.wanted));
    json_object_set_new(document, "parameters", parameters_json(s, row));
    json_object_set_new(document, "metrics", metrics);
    json_object_set_new(document, "samples", number(row[mcv_row_fixed(table, MCV_ROW_SAMPLES)]));
    json_object_set_new(document, "error", number(row[mcv_row_fixed(table, MCV_ROW_ERROR)]));
    json_object_set_new(document, "seconds", number(row[mcv_row_fixed(table, MCV_ROW_SECONDS)]));
    json_object_set_new(document, "message", message ? json_string(message) : json_null());
    char *text = json_dumps(document, JSON_COMPACT);
    json_decref(document);
    return text;
}
