/* SPDX-License-Identifier: Apache-2.0 */
/* Renders of the public interface. */
#include "api/rendering.h"
#include "core/basics.h"
#include "core/output_file.h"
#include "options/option_table.h"
#include "reference/reference.h"
#include "report/summary.h"
#include "scene/sensor_find.h"
#include "verbs/merge.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static mcv_result make_picture(const mcv_rendering *r, mcv_picture **picture, mcv_error *error) {
    mcv_exr exr;
    *picture = NULL;
    if (r->rendered.film->samples == 0) return MCV_OK;
    MCV_TRY(mcv_rendered_develop(&r->rendered, &exr, error));
    return mcv_picture_of(&exr, r->rig->path[0] ? r->rig->path : "the picture", picture, error);
}

static void tell_caller(mcv_rendering *r, double fraction, double error, bool writing,
                        bool drafts) {
    const mcv_progress progress = {.size = sizeof progress,
                                   .fraction = fraction,
                                   .seconds = mcv_seconds() - r->begun,
                                   .error = error,
                                   .render = r,
                                   .sensor = r->sensor,
                                   .writing = writing,
                                   .preview = drafts ? r->early->path : NULL};
    if (!r->call) return;
    mcv_border_leave(r->host);
    if (!r->call(r->user, &progress)) r->stopped = true;
    r->host = mcv_border_enter();
}

void mcv_rendering_tell(mcv_rendering *r, double fraction, double error, bool writing) {
    tell_caller(r, fraction, error, writing, false);
}

static bool tell(void *user, double fraction, double seconds, double error) {
    mcv_rendering *r = user;
    (void)seconds;
    tell_caller(r, fraction, error, false, r->early && mcv_early_progress(r->early, fraction));
    return !r->stopped;
}

static void skip_draft(void *user) {
    const mcv_rendering *r = user;
    mcv_early_progress(r->early, 0);
}

static void show(void *user, const mcv_image *picture, uint32_t stride) {
    const mcv_rendering *r = user;
    mcv_early_show(r->early, picture, stride);
}

mcv_result mcv_progress_picture(const mcv_progress *progress, mcv_picture **picture,
                                mcv_error *error) {
    mcv_result result;
    MCV_NEED(picture);
    *picture = NULL;
    MCV_NEED(progress);
    MCV_INSIDE(result, make_picture(progress->render, picture, error));
    return result;
}

/* --- checkpoints --- */

static bool save_is_due(void *user, bool ending) {
    const mcv_rendering *r = user;
    return mcv_saves_due(r->saves, ending);
}

static void warn(void *user, const char *sentence) {
    mcv_rendering *r = user;
    if (r->warn) r->warn(r, sentence);
}

static void save(void *user, const mcv_unfinished *unfinished) {
    mcv_rendering *r = user;
    mcv_saves_write(r->saves, unfinished);
    if (r->saves->failure.text[0]) warn(r, r->saves->failure.text);
}

static const struct mcv_render_saving SAVING = {save_is_due, save};

mcv_result mcv_progress_save(const mcv_progress *progress, mcv_error *error) {
    MCV_NEED(progress);
    const mcv_rendering *r = progress->render;
    if (!r->saves || !r->saves->path)
        return mcv_fail(error, MCV_USAGE,
                        "the render has no checkpoint: name one by the option checkpoint");
    r->saves->asked = true;
    return MCV_OK;
}

mcv_summary mcv_rendering_summary(const mcv_rendering *r, double seconds_load) {
    const mcv_rendered *rendered = &r->rendered;
    const mcv_film *film = rendered->film;
    return (mcv_summary){.scene = rendered->scene->path,
                         .sensor = r->sensor,
                         .unit = mcv_rendered_unit(rendered->scene, rendered->sensor),
                         .width = film->width,
                         .height = film->height,
                         .channels = film->channels,
                         .replicates = film->replicates,
                         .samples = (uint64_t)llround(mcv_film_mean_samples(film)),
                         .adaptive = film->levels != NULL,
                         .stats = *rendered->stats,
                         .seconds_load = seconds_load,
                         .seconds_write = NAN,
                         .seconds_first_picture = NAN,
                         .error = mcv_film_relative_error(film),
                         .error_of_rest = mcv_film_error_of_rest(film),
                         .mean = mcv_film_mean(film),
                         .preview = {.white = NAN, .saturated = NAN}};
}

/* What a render gives, once the film is done. */
static mcv_result finish(const mcv_rendering *r, const mcv_command *command, double seconds_load,
                         mcv_picture **picture, char **stats, mcv_error *error) {
    MCV_TRY(make_picture(r, picture, error));
    if (stats && *picture) {
        const mcv_summary summary = mcv_rendering_summary(r, seconds_load);
        MCV_TRY(command->json ? mcv_summary_json(&summary, stats, error)
                              : mcv_summary_text(&summary, stats, error));
    }
    if (!r->rendered.stats->interrupted) return MCV_OK;
    return mcv_fail(error, MCV_INTERRUPTED, "%s: interrupted %s", r->rendered.scene->path,
                    *picture ? "before its last sample" : "before its first sample");
}

mcv_result mcv_rendering_run(mcv_rendering *r, mcv_session *session, const mcv_command *command,
                             const mcv_scene *scene, uint32_t sensor, mcv_render_options *options,
                             mcv_film *film, mcv_render_stats *stats, mcv_error *error) {
    const bool reference = mcv_wants_reference(command);
    mcv_renderer *renderer = NULL;
    if (reference)
        options->sampler = MCV_SAMPLER_RANDOM; /* it has no other, and the header says so */
    options->progress = r->call || r->early ? tell : NULL;
    options->picture = r->early ? show : NULL;
    options->cached = r->early ? skip_draft : NULL;
    options->saving = r->saves && r->saves->path ? &SAVING : NULL;
    options->resume = r->saves && r->saves->resumes ? &r->saves->checkpoint.unfinished : NULL;
    options->warned = warn;
    options->user = r;
    if (!reference) MCV_TRY(mcv_session_renderer(session, command->device, &renderer, error));
    r->rendered.scene = scene;
    r->rendered.sensor = sensor;
    r->rendered.options = options;
    r->rendered.film = film;
    r->rendered.stats = stats;
    mcv_sensor_label(scene, sensor, r->sensor, sizeof r->sensor);
    return reference ? mcv_reference_render(scene, sensor, options, film, stats, error)
                     : mcv_renderer_render(renderer, scene, sensor, options, film, stats, error);
}

mcv_result mcv_rendering_saves(mcv_rendering *r, const mcv_command *command, const mcv_scene *scene,
                               uint32_t sensor, const char *path, bool by_default, mcv_saves *saves,
                               mcv_error *error) {
    json_t *identity = mcv_checkpoint_identity(command, scene, sensor, r->rendered.set);
    if (identity) mcv_checkpoint_hash(identity, r->rendered.replicates, r->rendered.identity);
    mcv_saves_begin(saves, path, by_default, identity);
    r->saves = saves;
    const mcv_result result = !identity ? mcv_fail(error, MCV_FAILED, "no memory for checkpoints")
                              : command->resume ? mcv_saves_resume(saves, error)
                                                : MCV_OK;
    if (result == MCV_OK) return MCV_OK;
    r->saves = NULL;
    mcv_saves_end(saves, false);
    return result;
}

/* Of a render into memory: only where they are asked for. The lock is taken, too. */
static mcv_result begin_saves(mcv_rendering *r, const mcv_command *command, const mcv_scene *scene,
                              uint32_t sensor, mcv_saves *saves, mcv_saves_lock *lock,
                              mcv_error *error) {
    const bool wanted = command->checkpoint && strcmp(command->checkpoint, "off") != 0;
    if (command->resume && !wanted)
        return mcv_fail(error, MCV_USAGE, "options: resume: name the file by checkpoint");
    if (wanted) MCV_TRY(mcv_output_check(command->checkpoint, error));
    if (command->part) MCV_TRY(mcv_output_check(command->part, error));
    if (wanted) MCV_TRY(mcv_saves_lock_take(lock, command->checkpoint, error));
    const mcv_result result = mcv_rendering_saves(
        r, command, scene, sensor, wanted ? command->checkpoint : NULL, false, saves, error);
    if (result != MCV_OK) mcv_saves_unlock(lock);
    return result;
}

static mcv_result render_scene(mcv_session *session, const mcv_command *command, mcv_rendering *r,
                               mcv_scene *scene, mcv_picture **picture, char **stats,
                               mcv_error *error) {
    const double seconds_load = mcv_seconds() - r->begun;
    mcv_render_options options;
    mcv_render_stats told = {.stage_count = 0};
    mcv_film film = {0};
    uint32_t sensor;
    MCV_TRY(mcv_render_options_read(command, &options, error));
    MCV_TRY(mcv_session_sensor(scene, command, &sensor, error));
    mcv_saves saves;
    mcv_saves_lock lock = {.path = NULL};
    MCV_TRY(begin_saves(r, command, scene, sensor, &saves, &lock, error));
    mcv_result result =
        mcv_rendering_run(r, session, command, scene, sensor, &options, &film, &told, error);
    if (result == MCV_OK) result = finish(r, command, seconds_load, picture, stats, error);
    if (result == MCV_OK && command->part)
        result = mcv_part_write(command->part, saves.identity, &r->rendered, error);
    r->saves = NULL;
    mcv_saves_end(&saves, result == MCV_OK);
    mcv_saves_unlock(&lock);
    r->rendered = (mcv_rendered){.set = r->rendered.set}; /* the rest ends here */
    mcv_film_free(&film);
    return result;
}

mcv_result mcv_rendering_changes(mcv_rendering *r, const mcv_rig *rig, const mcv_command *command,
                                 mcv_error *error) {
    const mcv_overrides changes = mcv_rig_changes(rig);
    const char **items = malloc((changes.count + command->set.count + 1) * sizeof *items);
    if (!items) return mcv_fail(error, MCV_FAILED, "no memory for the changes of the scene");
    if (changes.count) memcpy(items, changes.items, changes.count * sizeof *items);
    if (command->set.count)
        memcpy(items + changes.count, command->set.items, command->set.count * sizeof *items);
    r->rendered.set.items = items;
    r->rendered.set.count = changes.count + command->set.count;
    r->rendered.hash = rig->hash;
    r->rendered.replicates = command->parts != 0;
    r->rendered.subpixels = command->lasers;
    return MCV_OK;
}

static mcv_result do_work(mcv_session *session, const mcv_rig *rig, unsigned verb,
                          const char *options, mcv_rendering *r, mcv_rendering_work *work,
                          void *own, mcv_error *error) {
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, session->defaults, verb, arguments, NULL, &given, error));
    mcv_result result = mcv_rendering_changes(r, rig, &given.command, error);
    if (result == MCV_OK) result = work(own, &given.command, r, error);
    free((void *)r->rendered.set.items);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_rendering_verb(mcv_session *session, const mcv_rig *rig, unsigned verb,
                              const char *options, mcv_progress_call *progress, void *user,
                              mcv_rendering_work *work, void *own, mcv_error *error) {
    MCV_TRY(mcv_session_begin(session, error));
    mcv_rendering r = {.call = progress, .user = user, .rig = rig, .begun = mcv_seconds()};
    r.host = mcv_border_enter();
    const mcv_result result = do_work(session, rig, verb, options, &r, work, own, error);
    mcv_border_leave(r.host);
    mcv_session_end(session);
    return result;
}

/* Options that a render has on the command line only: its files, and those of the camera that
 * reads it out, which is a call of its own here. */
static void list_others(const char *names[MCV_OPTION_COUNT + 1]) {
    size_t count = 0;
    for (size_t i = 0; i < MCV_OPTION_COUNT; ++i) {
        const mcv_option *o = mcv_options + i;
        static const char *const files[] = {"output", "png", "camera"};
        bool other = (o->verbs & MCV_IN_CAMERA) && strcmp(o->name, "seed") != 0 &&
                     strcmp(o->name, "json") != 0;
        for (size_t k = 0; k < sizeof files / sizeof files[0]; ++k)
            other = other || strcmp(o->name, files[k]) == 0;
        if (other) names[count++] = o->name;
    }
    names[count] = NULL;
}

static mcv_result render_rig(mcv_session *session, const mcv_rig *rig, const char *text,
                             mcv_rendering *r, mcv_picture **picture, char **stats,
                             mcv_error *error) {
    const char *without[MCV_OPTION_COUNT + 1];
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    mcv_scene *scene = NULL;
    list_others(without);
    MCV_TRY(mcv_options_read(text, session->defaults, MCV_VERB_RENDER, arguments, without, &given,
                             error));
    const mcv_command *command = &given.command;
    mcv_result result = mcv_rendering_changes(r, rig, command, error);
    if (result == MCV_OK) result = mcv_session_scene(session, rig, command, &scene, error);
    if (result == MCV_OK) result = render_scene(session, command, r, scene, picture, stats, error);
    mcv_scene_free(scene);
    free((void *)r->rendered.set.items);
    mcv_options_free(&given);
    if (result == MCV_OK || result == MCV_INTERRUPTED) return result;
    mcv_picture_free(*picture);
    *picture = NULL;
    return result;
}

mcv_result mcv_session_render(mcv_session *session, const mcv_rig *rig, const char *options,
                              mcv_progress_call *progress, void *user, mcv_picture **picture,
                              char **stats, mcv_error *error) {
    MCV_NEED(picture);
    *picture = NULL;
    if (stats) *stats = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    MCV_TRY(mcv_session_begin(session, error));
    mcv_rendering r = {.call = progress, .user = user, .rig = rig, .begun = mcv_seconds()};
    r.host = mcv_border_enter();
    const mcv_result result = render_rig(session, rig, options, &r, picture, stats, error);
    mcv_border_leave(r.host);
    mcv_session_end(session);
    return result;
}
