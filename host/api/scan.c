/* SPDX-License-Identifier: Apache-2.0 */
/* Scans of a laser head of the public interface. */
#include "verbs/scan.h"

#include "api/rendering.h"
#include "core/basics.h"
#include "scene/sensor_find.h"
#include "scene/sensors.h"
#include "verbs/surface_part.h"

#include <math.h>
#include <stdlib.h>

/* A call while it works. */
typedef struct work {
    mcv_session *session;
    const mcv_rig *rig;
    const mcv_command *command;
    const char *text;          /* of its options */
    mcv_options_given head;    /* owned: with those of a laserTriangulation sensor */
    mcv_rendering *rendering;  /* of the whole scan */
    mcv_scene *still, *moving; /* as headers tell it; and where the head is */
    mcv_sensor whole[2];       /* their sensors, of the whole film */
    uint32_t sensor;
    ref_geometry geometry; /* of the parts, which stand still, for their speckle */
    mcv_scan scan;
    mcv_picture **picture;
    char **report; /* or NULL */
} work;

/* What is rendered of a profile. */
typedef struct view {
    uint32_t profile, window[2], subpixels;
    uint64_t samples; /* of each replicate and pixel; 0: by the options */
    uint32_t replicates;
    mcv_scan_run run;
} view;

/* The film between two of its rows or columns, with so many sub-pixels. The optical axis stays. */
static mcv_result cut_film(const work *w, mcv_scene *scene, const mcv_sensor *whole,
                           const uint32_t window[2], uint32_t subpixels, mcv_error *error) {
    mcv_sensor *s = scene->sensors + w->sensor;
    const uint32_t axis = w->scan.axis;
    *s = *whole;
    const mcv_param_table table = mcv_sensor_table(s->type);
    uint32_t *resolution = mcv_params_find(table, "resolution", &s->as);
    double *axis_at = mcv_params_find(table, "principalPoint", &s->as);
    if (!resolution || !axis_at)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: a scan needs a thinLens or telecentric sensor, which %s is not",
                        scene->path, s->name);
    for (int i = 0; i < 2; ++i)
        if (isnan(axis_at[i])) axis_at[i] = resolution[i] / 2.0;
    resolution[axis] = window[1] - window[0];
    axis_at[axis] -= window[0];
    return mcv_sensor_resize(s, (uint64_t)resolution[0] * subpixels,
                             (uint64_t)resolution[1] * subpixels, scene, error);
}

/* Takes the head to where the part's next strip lies below it, and bends its lines or not. */
static void move_head(const work *w, const view *v) {
    const double *m = w->scan.laser.m, way = -w->command->feed[0] * v->profile;
    mcv_sensor *s = w->moving->sensors + w->sensor;
    for (int k = 0; k < 3; ++k) s->to_world.m[9 + k] += way * m[3 * k + 1];
    for (uint32_t i = 0; i < w->still->emitter_count; ++i) {
        mcv_emitter *e = w->moving->emitters + i;
        if (e->type != MCV_EMITTER_LASER) continue;
        e->to_world = w->still->emitters[i].to_world;
        for (int k = 0; k < 3; ++k) e->to_world.m[9 + k] += way * m[3 * k + 1];
        e->as.laser.straightness =
            v->run.straight ? 0 : w->still->emitters[i].as.laser.straightness;
    }
}

static mcv_result read_options(const work *w, const view *v, mcv_render_options *options,
                               mcv_error *error) {
    MCV_TRY(mcv_render_options_read(w->command, options, error));
    options->error = options->seconds = 0;
    options->replicates = v->replicates ? v->replicates : options->replicates;
    /* Independent of the other profiles, and of another render of this one. */
    options->seed += 2 * v->profile + v->run.again;
    if (v->run.direct) options->depth = 2; /* the surface, and the laser */
    if (v->samples) options->last = v->samples;
    uint64_t each = 1;
    /* Sub-pixels share the samples of a pixel. */
    const uint64_t share = (uint64_t)v->subpixels * v->subpixels;
    while (each * share < options->last) each *= 2;
    options->last = each;
    return MCV_OK;
}

static mcv_result render(work *w, const view *v, mcv_render_options *options, mcv_rendering *quiet,
                         mcv_film *film, mcv_render_stats *stats, mcv_error *error) {
    MCV_TRY(read_options(w, v, options, error));
    MCV_TRY(cut_film(w, w->still, w->whole, v->window, 1, error));
    MCV_TRY(cut_film(w, w->moving, w->whole + 1, v->window, v->subpixels, error));
    move_head(w, v);
    return mcv_rendering_run(quiet, w->session, w->command, w->moving, w->sensor, options, film,
                             stats, error);
}

/* The rows that the line reaches, by one sample a pixel. */
static mcv_result find_window(work *w, uint32_t profile, uint32_t window[2], mcv_error *error) {
    const uint32_t count = w->scan.model.size[w->scan.axis];
    const view v = {
        .profile = profile, .window = {0, count}, .subpixels = 1, .samples = 1, .replicates = 1};
    mcv_rendering quiet = {.rig = w->rig};
    mcv_render_options options;
    mcv_render_stats stats = {.stage_count = 0};
    mcv_film film = {0};
    mcv_result result = render(w, &v, &options, &quiet, &film, &stats, error);
    if (result == MCV_OK) result = mcv_scan_window(&w->scan, &film, window, error);
    mcv_film_free(&film);
    return result;
}

/* The light of a profile at pixels and at sub-pixels, with headers. After failure nothing is
 * owned. */
static mcv_result render_light(work *w, const view *v, mcv_exr *light, mcv_exr *laser,
                               mcv_error *error) {
    mcv_rendering quiet = {.rig = w->rig};
    mcv_render_options options;
    mcv_render_stats stats = {.stage_count = 0};
    mcv_film fine = {0}, film = {0};
    *light = *laser = (mcv_exr){0};
    mcv_result result = render(w, v, &options, &quiet, &fine, &stats, error);
    if (result == MCV_OK) result = mcv_film_bin(&fine, v->subpixels, &film, error);
    mcv_rendered rendered = {.scene = w->moving,
                             .sensor = w->sensor,
                             .options = &options,
                             .film = &fine,
                             .stats = &stats,
                             .set = w->rendering->rendered.set,
                             .hash = w->rig->hash};
    if (result == MCV_OK) result = mcv_rendered_develop(&rendered, laser, error);
    if (result == MCV_OK && w->geometry.scene)
        result = mcv_surface_part_add(&w->geometry, w->moving->sensors + w->sensor, v->subpixels,
                                      laser, error);
    rendered.scene = w->still;
    rendered.film = &film;
    if (result == MCV_OK) result = mcv_rendered_develop(&rendered, light, error);
    if (result == MCV_OK) result = mcv_scan_filter(&w->scan, v->window[0], light, laser, error);
    mcv_film_free(&fine);
    mcv_film_free(&film);
    if (result == MCV_OK) return MCV_OK;
    mcv_exr_free(light);
    mcv_exr_free(laser);
    return result;
}

/* Is the light of both runs the same? */
static bool share_light(const mcv_scan_run *a, const mcv_scan_run *b) {
    return a->again == b->again && a->direct == b->direct && a->straight == b->straight;
}

static mcv_result scan_profile(work *w, uint32_t profile, mcv_error *error) {
    view v = {.profile = profile, .subpixels = w->scan.subpixels};
    mcv_exr light = {0}, laser = {0};
    mcv_result result = find_window(w, profile, v.window, error);
    for (int run = 0; result == MCV_OK && run < MCV_SCAN_RUNS; ++run) {
        if (!mcv_scan_needs(&w->scan, run)) continue;
        if (!light.part_count || !share_light(&v.run, mcv_scan_runs + run)) {
            v.run = mcv_scan_runs[run];
            mcv_exr_free(&light);
            mcv_exr_free(&laser);
            result = render_light(w, &v, &light, &laser, error);
        }
        if (result == MCV_OK)
            result = mcv_scan_expose(&w->scan, run, profile, &light, &laser, v.window[0], error);
        if (result == MCV_OK && run == MCV_SCAN_CLEAN && profile == 0 && v.subpixels > 1)
            result = mcv_scan_lock(&w->scan, &light, &laser, error);
    }
    mcv_exr_free(&light);
    mcv_exr_free(&laser);
    return result;
}

static mcv_result scan_all(work *w, mcv_error *error) {
    const uint32_t count = (uint32_t)w->command->profile_count;
    for (uint32_t i = 0; i < count; ++i) {
        MCV_TRY(scan_profile(w, i, error));
        mcv_rendering_tell(w->rendering, (i + 1.0) / count, 0, false);
        if (w->rendering->stopped)
            return mcv_fail(error, MCV_INTERRUPTED, "%s: interrupted after %u of %u profiles",
                            w->still->path, i + 1, count);
    }
    return mcv_profiles_write(w->scan.profiles, error);
}

static mcv_result tell(const work *w, char **report, mcv_error *error) {
    mcv_report r;
    if (!report) return MCV_OK;
    MCV_TRY(mcv_report_keep(&r, w->command->json, error));
    mcv_scan_report(&w->scan, &r);
    mcv_report_number(&r, "seconds", "s", mcv_seconds() - w->rendering->begun);
    return mcv_report_take(&r, report, error);
}

/* The options again, with those of a sensor that is a whole head. */
static mcv_result take_head(work *w, mcv_error *error) {
    const char *const arguments[2] = {w->rig->document.path};
    if (!w->whole[0].is_head) return MCV_OK;
    json_t *defaults =
        mcv_scan_head(&w->whole[0], w->rig->document.path, w->command, w->session->defaults);
    if (!defaults) return mcv_fail(error, MCV_FAILED, "no memory for the options of a head");
    const mcv_result result =
        mcv_options_read(w->text, defaults, MCV_VERB_SCAN, arguments, NULL, &w->head, error);
    json_decref(defaults);
    if (result != MCV_OK) return result;
    /* A single profile needs no feed of the head. */
    if (w->head.command.profile_count == 1 && w->command->feed[0] == 0) w->head.command.feed[0] = 0;
    w->command = &w->head.command;
    return MCV_OK;
}

static mcv_result run(void *own, const mcv_command *command, mcv_rendering *r, mcv_error *error) {
    work *w = own;
    w->command = command;
    w->rendering = r;
    mcv_scene **const scenes[] = {&w->still, &w->moving};
    for (int i = 0; i < 2; ++i) {
        MCV_TRY(mcv_session_scene(w->session, w->rig, w->command, scenes[i], error));
        MCV_TRY(mcv_session_sensor(*scenes[i], w->command, &w->sensor, error));
        w->whole[i] = (*scenes[i])->sensors[w->sensor];
    }
    MCV_TRY(take_head(w, error));
    snprintf(w->rendering->sensor, sizeof w->rendering->sensor, "%s", w->whole[0].name);
    mcv_result result = mcv_scan_begin(w->command, w->still, w->sensor, &w->scan, error);
    if (result == MCV_OK && !w->command->scan_speckle)
        result = ref_geometry_new(w->moving, &w->geometry, error);
    if (result == MCV_OK) result = scan_all(w, error);
    if (result == MCV_OK) result = tell(w, w->report, error);
    if (result == MCV_OK) result = mcv_profiles_picture(w->scan.profiles, w->picture, error);
    if (w->geometry.scene) ref_geometry_free(&w->geometry);
    mcv_scan_free(&w->scan);
    return result;
}

mcv_result mcv_session_scan(mcv_session *session, const mcv_rig *rig, const char *options,
                            mcv_progress_call *progress, void *user, mcv_picture **picture,
                            char **report, mcv_error *error) {
    MCV_NEED(picture);
    *picture = NULL;
    if (report) *report = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    work w = {
        .session = session, .rig = rig, .text = options, .picture = picture, .report = report};
    const mcv_result result =
        mcv_rendering_verb(session, rig, MCV_VERB_SCAN, options, progress, user, run, &w, error);
    mcv_scene_free(w.still);
    mcv_scene_free(w.moving);
    mcv_options_free(&w.head); /* nothing, where the sensor is no head */
    return result;
}
