/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/run_set.h"

#include "cl/cl.h"
#include "core/basics.h"
#include "experiment/set_image.h"
#include "scene/sensor_find.h"
#include "loader/load.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* `last`: an override after those of the set, or NULL. */
static mcv_result load_set(const mcv_sweep *s, const double *numbers, mcv_set_texts texts,
                           const char *last, mcv_scene **scene, mcv_error *error) {
    const mcv_overrides given = s->experiment->set;
    const mcv_plan *plan = &s->plan;
    const char **items = malloc((given.count + plan->count + 2) * sizeof *items);
    if (!items) {
        mcv_fail(error, MCV_FAILED, "no memory for a set of parameters");
        return MCV_FAILED;
    }
    size_t count = given.count;
    if (given.count) memcpy(items, given.items, given.count * sizeof *items);
    for (size_t i = 0; i < plan->count; ++i) {
        const mcv_parameter *p = plan->parameters + i;
        mcv_value_text value;
        snprintf(texts[i], sizeof texts[i], "%.*s=%s", p->path_length, p->item,
                 mcv_parameter_text(p, numbers[i], 17, value));
        if (!mcv_judge_has(p)) items[count++] = texts[i];
    }
    if (last) items[count++] = last;
    const mcv_result result = mcv_experiment_load(s, (mcv_overrides){items, count}, scene, error);
    free(items);
    return result;
}

mcv_result mcv_load_set(const mcv_sweep *s, const double *numbers, mcv_set_texts texts,
                        mcv_scene **scene, mcv_error *error) {
    return load_set(s, numbers, texts, NULL, scene, error);
}

/* What continues a table that is not whole. */
static const char *what_continues(const mcv_sweep *s) {
    return s->experiment->resume ? "the same command" : "--resume";
}

mcv_result mcv_sweep_stopped(const mcv_sweep *s, mcv_error *error) {
    const mcv_sweep_calls *calls = &s->experiment->calls;
    const mcv_result stopped = calls->interrupted ? calls->interrupted(calls->user) : MCV_OK;
    if (stopped == MCV_OK) return MCV_OK;
    if (!s->experiment->table)
        return mcv_fail(error, stopped, "interrupted after %zu sets", s->table.row_count);
    return mcv_fail(error, stopped, "interrupted: continue by %s; %zu %s in %s", what_continues(s),
                    s->table.row_count, s->table.row_count == 1 ? "row is" : "rows are",
                    s->table.path);
}

bool mcv_sweep_goes_on(void *user, double fraction, double seconds, double error) {
    mcv_error ignored;
    (void)fraction;
    (void)seconds;
    (void)error;
    return mcv_sweep_stopped(user, &ignored) == MCV_OK;
}

/* The current set, for the callbacks of a render. */
typedef struct set_at_work {
    const mcv_sweep *sweep;
    uint32_t seed;           /* of the render */
    mcv_measuring measuring; /* with the seed of the exposure */
    mcv_measurement measurement;
    const mcv_scene *scene;
    uint32_t sensor;
} set_at_work;

static bool go_on(void *user, double fraction, double seconds, double error) {
    return mcv_sweep_goes_on((void *)((const set_at_work *)user)->sweep, fraction, seconds, error);
}

static bool is_enough(void *user, const mcv_film *film) {
    const set_at_work *w = user;
    return mcv_measurement_suffices(&w->measurement, w->scene, w->sensor, film);
}

mcv_result mcv_set_sensor(const mcv_experiment *e, mcv_scene *scene, uint32_t *sensor,
                          mcv_error *error) {
    *sensor = 0;
    if (scene->sensor_count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no sensor", e->rig);
    if (e->sensor) MCV_TRY(mcv_sensor_find(scene, e->sensor, sensor, error));
    if (!e->resolution[0]) return MCV_OK;
    return mcv_sensor_resize(scene->sensors + *sensor, e->resolution[0], e->resolution[1], scene,
                             error);
}

static void warn(void *user, const char *sentence) {
    const mcv_sweep_calls *calls = &((set_at_work *)user)->sweep->experiment->calls;
    if (calls->warning) calls->warning(calls->user, sentence);
}

static mcv_result render(mcv_sweep *s, set_at_work *w, mcv_film *film, mcv_error *error) {
    const mcv_experiment *e = s->experiment;
    mcv_render_options options = e->render;
    mcv_render_stats stats = {.stage_count = 0};
    options.progress = go_on;
    options.warned = warn;
    options.enough = e->measuring.until.count ? is_enough : NULL;
    options.user = w;
    options.seed = w->seed;
    const mcv_result result =
        e->render_with
            ? e->render_with(w->scene, w->sensor, &options, film, &stats, error)
            : mcv_renderer_render(s->renderer, w->scene, w->sensor, &options, film, &stats, error);
    for (uint32_t i = 0; i < stats.stage_count; ++i) s->stage_seconds += stats.stages[i].seconds;
    ++s->renders;
    s->built += !e->render_with && result == MCV_OK && !stats.kept_structure;
    s->compiled += !e->render_with && result == MCV_OK && !stats.kept_program;
    return result;
}

mcv_result mcv_set_image_path(const mcv_experiment *e, size_t set, char path[PATH_MAX],
                              mcv_error *error) {
    if (snprintf(path, PATH_MAX, "%s/set-%05zu.exr", e->images, set) >= PATH_MAX)
        return mcv_fail(error, MCV_USAGE, "--images %s: the path is too long", e->images);
    return MCV_OK;
}

static mcv_result keep_image(const mcv_sweep *s, const set_at_work *w, size_t set,
                             const mcv_film *film, const mcv_set_texts texts, mcv_error *error) {
    const mcv_experiment *e = s->experiment;
    char path[PATH_MAX], joined[sizeof(mcv_set_texts)] = "", *end = joined;
    if (!e->images) return MCV_OK;
    MCV_TRY(mcv_set_image_path(e, set, path, error));
    for (size_t i = 0; i < s->plan.count; ++i) {
        if (i) *end++ = '\n';
        end = stpcpy(end, texts[i]);
    }
    return mcv_set_image_keep(path, w->scene, w->sensor, film, w->seed, joined, error);
}

static mcv_result measure(const mcv_sweep *s, const set_at_work *w, size_t set,
                          const mcv_film *film, const mcv_film *stepped, const mcv_set_texts texts,
                          double *row, mcv_error *error) {
    const mcv_table *table = &s->table;
    MCV_TRY(mcv_sweep_stopped(s, error));
    row[mcv_row_fixed(table, MCV_ROW_SAMPLES)] = (double)(film->samples * film->replicates);
    row[mcv_row_fixed(table, MCV_ROW_ERROR)] = mcv_film_relative_error(film);
    MCV_TRY(keep_image(s, w, set, film, texts, error));
    return mcv_measurement_take(&w->measurement, w->scene, w->sensor, film,
                                stepped->sums ? stepped : NULL, row + mcv_row_metric(table, 0),
                                error);
}

/* What tells renders apart: the parameters of the scene, and the seed where sets have their own. */
static uint64_t picture_of(const mcv_sweep *s, const set_at_work *w, const double *row) {
    const uint64_t scene = mcv_judge_scene(s, row);
    return s->plan.seeds ? mcv_hash_bytes(scene, &w->seed, sizeof w->seed) : scene;
}

/* The scene was the last set's: figures are known, and programs look at its exposures. */
static mcv_result decide_again(mcv_sweep *s, size_t set, const double *known, double *row,
                               mcv_error *error) {
    const size_t begin = s->plan.count, end = mcv_row_fixed(&s->table, MCV_ROW_SECONDS);
    memcpy(row + begin, known + begin, (end - begin) * sizeof *row);
    return mcv_judge_decide(s->judge, set, row, error);
}

static mcv_result decide(mcv_sweep *s, const set_at_work *w, size_t set, const mcv_film *film,
                         double *row, mcv_error *error) {
    const uint64_t scene = picture_of(s, w, row);
    MCV_TRY(mcv_judge_expose(s->judge, scene, w->scene, w->sensor, film, row, error));
    return mcv_judge_decide(s->judge, set, row, error);
}

/* Render and exposure have noise of their own in sets that have their own seeds. */
static void take_seed(set_at_work *w, size_t set) {
    const mcv_sweep *s = w->sweep;
    const uint32_t offset = s->plan.seeds ? s->plan.seeds[set] : 0;
    w->seed = s->experiment->render.seed + offset;
    w->measuring = s->experiment->measuring;
    w->measuring.camera.camera.seed += offset;
    w->measurement = s->measurement;
    w->measurement.asked = &w->measuring;
}

/* The film of the set with a step of the parameter whose bound is wanted. */
static mcv_result render_stepped(mcv_sweep *s, const set_at_work *work, const double *row,
                                 mcv_film *film, mcv_error *error) {
    mcv_set_texts texts;
    char last[512];
    mcv_scene *scene = NULL;
    set_at_work w = *work;
    if (!s->experiment->measuring.bound) return MCV_OK;
    mcv_bound_override(&s->measurement.bound, row, last);
    MCV_TRY(load_set(s, row, texts, last, &scene, error));
    w.scene = scene;
    mcv_result result = mcv_set_sensor(s->experiment, scene, &w.sensor, error);
    if (result == MCV_OK) result = render(s, &w, film, error);
    mcv_scene_free(scene);
    return result;
}

static mcv_result try_set(mcv_sweep *s, size_t set, double *row, mcv_error *error) {
    mcv_set_texts texts;
    mcv_film film = {0}, stepped = {0};
    mcv_scene *scene = NULL;
    set_at_work w = {.sweep = s};
    take_seed(&w, set);
    const double *known = s->judge && !s->experiment->images
                              ? mcv_judge_known(s->judge, picture_of(s, &w, row))
                              : NULL;
    if (known) return decide_again(s, set, known, row, error);
    MCV_TRY(mcv_load_set(s, row, texts, &scene, error));
    w.scene = scene;
    mcv_result result = mcv_set_sensor(s->experiment, scene, &w.sensor, error);
    if (result == MCV_OK) result = render(s, &w, &film, error);
    if (result == MCV_OK) result = render_stepped(s, &w, row, &stepped, error);
    if (result == MCV_OK) result = measure(s, &w, set, &film, &stepped, texts, row, error);
    if (result == MCV_OK && s->judge) result = decide(s, &w, set, &film, row, error);
    mcv_film_free(&film);
    mcv_film_free(&stepped);
    mcv_scene_free(scene);
    return result;
}

/* Whether no set can be rendered: no device can be opened again. */
static bool device_is_gone(const mcv_sweep *s, mcv_error *why) {
    mcv_cl devices[MCV_MOST_DEVICES];
    mcv_error reason = {""};
    uint32_t count = 0;
    if (mcv_cl_find_all(s->experiment->render.device, devices, &count, &reason) != MCV_OK)
        count = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (mcv_cl_start(devices + i, &reason) != MCV_OK) continue;
        mcv_cl_close(devices + i);
        return false;
    }
    *why = reason;
    return true;
}

/* A failure of the device: the set is tried again, now and when the table is resumed. */
static mcv_result try_again(mcv_sweep *s, size_t set, double *row, mcv_error *why) {
    mcv_error again = {""};
    if (try_set(s, set, row, &again) == MCV_OK) return MCV_OK;
    char text[sizeof why->text];
    snprintf(text, sizeof text, "%s", again.text);
    return mcv_fail(why, MCV_DEVICE, MCV_ROW_RETRY "%.*s",
                    (int)(sizeof text - sizeof MCV_ROW_RETRY), text);
}

mcv_result mcv_run_set(mcv_sweep *s, size_t set, double *row, mcv_error *error) {
    const mcv_sweep_calls *calls = &s->experiment->calls;
    mcv_table *table = &s->table;
    mcv_error why = {""};
    const double begun = mcv_seconds();
    for (size_t i = s->plan.count; i < table->columns; ++i) row[i] = NAN;
    row[mcv_row_fixed(table, MCV_ROW_SET)] = (double)set;
    mcv_result result = try_set(s, set, row, &why);
    mcv_result stopped = mcv_sweep_stopped(s, error);
    if (result == MCV_DEVICE && stopped == MCV_OK) {
        if (device_is_gone(s, &why))
            return mcv_fail(error, MCV_DEVICE,
                            "set %zu: %.1024s: no set can be rendered; %zu rows "
                            "are kept, continue by %s",
                            set, why.text, table->row_count, what_continues(s));
        result = try_again(s, set, row, &why);
        stopped = mcv_sweep_stopped(s, error);
    }
    if (stopped != MCV_OK) return stopped;
    row[mcv_row_fixed(table, MCV_ROW_SECONDS)] = mcv_seconds() - begun;
    const char *message = result == MCV_OK ? NULL : why.text;
    for (char *c = why.text; *c; ++c)
        if (*c == '\n' || *c == '\r') *c = ' ';
    MCV_TRY(mcv_table_append(table, row, message, error));
    if (calls->row) calls->row(calls->user, s, row, message);
    return MCV_OK;
}
