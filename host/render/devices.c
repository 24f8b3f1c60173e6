/* SPDX-License-Identifier: Apache-2.0 */
/* Several devices for one render: opening them, giving them up. */
#include "render/renderer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/parallel.h"

static mcv_result find_devices(mcv_renderer *r) {
    mcv_cl found[MCV_MOST_DEVICES];
    uint32_t count;
    MCV_TRY(mcv_cl_find_all(r->options->device, found, &count, r->error));
    if (count > 1 && r->options->records)
        return mcv_fail(r->error, MCV_USAGE,
                        "--device %s: one device records which light reaches a pixel: name one",
                        r->options->device);
    r->cl = found[0];
    for (uint32_t i = 1; i < count; ++i) {
        mcv_other_device *other = calloc(1, sizeof *other);
        if (!other) return mcv_fail(r->error, MCV_FAILED, "no memory for %s", found[i].name);
        other->renderer.cl = found[i];
        r->others[r->other_count++] = other;
    }
    return MCV_OK;
}

static void tell(const mcv_renderer *r, const mcv_cl *cl, const mcv_error *why) {
    char sentence[sizeof cl->name + sizeof why->text + 64];
    if (!r->options->warned) return;
    snprintf(sentence, sizeof sentence, "%s is given up, and the other devices go on: %s", cl->name,
             why->text);
    r->options->warned(r->options->user, sentence);
}

static void remove_other(mcv_renderer *r, uint32_t index) {
    free(r->others[index]);
    --r->other_count;
    memmove(r->others + index, r->others + index + 1,
            (r->other_count - index) * sizeof r->others[0]);
}

void mcv_give_up_other(mcv_renderer *r, uint32_t index, const mcv_error *why) {
    mcv_other_device *other = r->others[index];
    tell(r, &other->renderer.cl, why);
    mcv_close_device(&other->renderer);
    remove_other(r, index);
}

void mcv_give_up_first(mcv_renderer *r, const mcv_error *why) {
    mcv_renderer *from = &r->others[0]->renderer;
    tell(r, &r->cl, why);
    mcv_close_device(r);
    r->cl = from->cl;
    r->scene = from->scene;
    r->schedule = from->schedule;
    r->earlier = from->earlier;
    r->key = from->key;
    r->earlier_key = from->earlier_key;
    r->schedule.cl = r->earlier.cl = &r->cl;
    r->schedule.scene = r->earlier.scene = &r->scene;
    remove_other(r, 0);
}

bool mcv_go_on_without_first(mcv_renderer *r) {
    if (r->other_count == 0) return false;
    mcv_give_up_first(r, r->error);
    r->error->text[0] = '\0';
    return true;
}

void mcv_close_others(mcv_renderer *r) {
    while (r->other_count > 0) {
        mcv_close_device(&r->others[0]->renderer);
        remove_other(r, 0);
    }
}

/* Contexts are made before anything is compiled: until then damaged files of a driver's cache may
 * be deleted. The first device is the last: its programs stay in the cache of the process. */
static mcv_result start_devices(mcv_renderer *r) {
    for (uint32_t i = r->other_count; i-- > 0;) {
        mcv_other_device *other = r->others[i];
        if (mcv_cl_start(&other->renderer.cl, &other->error) != MCV_OK)
            mcv_give_up_other(r, i, &other->error);
    }
    return mcv_cl_start(&r->cl, r->error);
}

typedef struct opening {
    mcv_renderer *r;
    const mcv_scene *scene;
    uint32_t sensor;
    bool failed[MCV_MOST_DEVICES];
} opening;

static void open_other(void *user, size_t i) {
    opening *o = user;
    mcv_other_device *other = o->r->others[i];
    mcv_renderer *r = &other->renderer;
    other->options = *o->r->options;
    other->options.progress = NULL;
    other->stats = (mcv_render_stats){.stage_count = 0};
    r->options = &other->options;
    r->stats = &other->stats;
    r->error = &other->error;
    r->film = o->r->film;
    r->round = o->r->round;
    r->begun = o->r->begun;
    o->failed[i] = mcv_open_scene(r, o->scene, o->sensor) != MCV_OK;
}

static void name_devices(mcv_renderer *r) {
    mcv_render_stats *stats = r->stats;
    memcpy(stats->driver, r->cl.version, sizeof stats->driver);
    size_t length = (size_t)snprintf(stats->device, sizeof stats->device, "%s", r->cl.name);
    for (uint32_t i = 0; i < r->other_count && length < sizeof stats->device; ++i)
        length += (size_t)snprintf(stats->device + length, sizeof stats->device - length, " + %s",
                                   r->others[i]->renderer.cl.name);
}

mcv_result mcv_open_devices(mcv_renderer *r, const mcv_scene *scene, uint32_t sensor) {
    opening o = {.r = r, .scene = scene, .sensor = sensor};
    if (!r->cl.device) MCV_TRY(find_devices(r));
    if (!r->cl.context) MCV_TRY(start_devices(r));
    MCV_TRY(mcv_open_scene(r, scene, sensor));
    mcv_in_parallel(r->other_count, open_other, &o);
    for (uint32_t i = r->other_count; i-- > 0;)
        if (o.failed[i]) mcv_give_up_other(r, i, &r->others[i]->error);
    name_devices(r);
    return MCV_OK;
}

mcv_result mcv_take_splats(mcv_renderer *r, uint64_t *splats) {
    const size_t values = mcv_film_values(r->film);
    if (!r->scene.splats) return MCV_OK;
    uint64_t *taken = malloc(8 * values);
    if (!taken) return mcv_fail(r->error, MCV_FAILED, "no memory for what light paths bring");
    mcv_result result = mcv_cl_read(&r->cl, r->scene.splats, 0, 8 * values, taken, r->error);
    if (result == MCV_OK) result = mcv_cl_clear(&r->cl, r->scene.splats, 8 * values, r->error);
    if (result == MCV_OK) result = mcv_cl_finish(&r->cl, r->error);
    for (size_t i = 0; result == MCV_OK && i < values; ++i) splats[i] += taken[i];
    free(taken);
    return result;
}
