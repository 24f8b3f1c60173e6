/* SPDX-License-Identifier: Apache-2.0 */
/* Renders of the public interface into files. */
#include "verbs/merge.h"
#include "verbs/render_files.h"

#include "api/rendering.h"
#include "check/findings.h"
#include "core/basics.h"
#include "scene/sensor_find.h"
#include "verbs/grey_picture.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <unistd.h>

/* A process may open some 1000 files. A render of more sensors is known by the first ones. */
enum { MOST_LOCKS = 256 };

/* A call, with what it tells. */
typedef struct files_call {
    mcv_rendering rendering;
    mcv_told_call *told; /* or NULL */
    mcv_session *session;
    mcv_options_given given;
    double seconds_load;
} files_call;

/* Takes the text. */
static void tell_text(files_call *c, char *text) {
    if (c->told) {
        mcv_border_leave(c->rendering.host);
        if (!c->told(c->rendering.user, text)) c->rendering.stopped = true;
        c->rendering.host = mcv_border_enter();
    }
    free(text);
}

/* Takes the report; one that says nothing is not told. */
static mcv_result tell_report(files_call *c, mcv_report *report, bool silent, mcv_error *error) {
    char *text;
    if (silent) {
        mcv_report_free(report);
        return MCV_OK;
    }
    MCV_TRY(mcv_report_take(report, &text, error));
    tell_text(c, text);
    return MCV_OK;
}

/* Errors and warnings, before hours are spent on a wrong scene. */
static mcv_result tell_findings(files_call *c, const mcv_scene *scene, mcv_error *error) {
    mcv_findings findings;
    mcv_report report;
    MCV_TRY(mcv_warnings_of(scene, &findings, error));
    const mcv_result result = mcv_report_keep(&report, c->given.command.json, error);
    for (size_t i = 0; result == MCV_OK && i < findings.count; ++i)
        mcv_report_tell(&report, mcv_severities[findings.items[i].severity],
                        findings.items[i].sentence);
    mcv_findings_free(&findings);
    return result == MCV_OK ? tell_report(c, &report, json_array_size(report.notes) == 0, error)
                            : result;
}

static mcv_result write_files(files_call *c, const mcv_render_files *files, double first_picture,
                              mcv_error *error) {
    const double begun = mcv_seconds();
    mcv_summary summary = mcv_rendering_summary(&c->rendering, c->seconds_load);
    char *text;
    summary.image_path = files->exr;
    summary.preview_path = files->png;
    MCV_TRY(mcv_render_files_write(files, &c->rendering.rendered, &summary.preview, error));
    summary.seconds_write = mcv_seconds() - begun;
    summary.seconds_first_picture =
        first_picture > 0 ? first_picture : mcv_seconds() - c->rendering.begun;
    MCV_TRY(c->given.command.json ? mcv_summary_json(&summary, &text, error)
                                  : mcv_summary_text(&summary, &text, error));
    tell_text(c, text);
    return MCV_OK;
}

static mcv_result expose(files_call *c, const mcv_render_files *files, mcv_error *error) {
    mcv_report report;
    MCV_TRY(mcv_report_keep(&report, c->given.command.json, error));
    const mcv_result result = mcv_render_files_expose(&c->given.command, files, &report, error);
    if (result == MCV_OK)
        return tell_report(c, &report, report.json && json_array_size(report.notes) == 0, error);
    mcv_report_free(&report);
    return result;
}

static mcv_result tell_note(files_call *c, const char *severity, const char *sentence,
                            mcv_error *error) {
    mcv_report report;
    MCV_TRY(mcv_report_keep(&report, c->given.command.json, error));
    mcv_report_tell(&report, severity, sentence);
    return tell_report(c, &report, false, error);
}

/* An image that stays: in JSON an object as of one that is rendered. */
static mcv_result tell_kept(files_call *c, const mcv_scene *scene, uint32_t sensor,
                            const mcv_render_files *files, const char *sentence, mcv_error *error) {
    mcv_report report;
    MCV_TRY(mcv_report_keep(&report, c->given.command.json, error));
    mcv_report_tell(&report, "note", sentence);
    if (report.json) {
        mcv_report_text(&report, "scene", scene->path);
        mcv_report_text(&report, "sensor", scene->sensors[sensor].name);
        mcv_report_text(&report, "image", files->exr);
        mcv_report_text(&report, "preview", files->png);
        mcv_report_flag(&report, "kept", true);
    }
    return tell_report(c, &report, false, error);
}

/* A checkpoint is there to go on with, or to be told of. */
static mcv_result tell_checkpoint(files_call *c, const mcv_saves *saves, mcv_error *error) {
    char sentence[PATH_MAX + 160];
    const bool resume = c->given.command.resume,
               exists = saves->path && access(saves->path, F_OK) == 0;
    if (resume == exists) return MCV_OK;
    snprintf(sentence, sizeof sentence,
             resume ? "%s: there is no checkpoint: the render begins at its first sample"
                    : "%s: holds an unfinished render, which --resume goes on with; without it, "
                      "it is replaced",
             saves->path ? saves->path : "--checkpoint off");
    return tell_note(c, "note", sentence, error);
}

/* With --resume an image that is finished is kept; one of another render is told of. */
static mcv_result keep_finished(files_call *c, const mcv_scene *scene, uint32_t sensor,
                                const mcv_render_files *files, const mcv_saves *saves, bool *kept,
                                mcv_error *error) {
    char sentence[PATH_MAX + 160];
    *kept = c->given.command.resume && mcv_render_files_kept(files, c->rendering.rendered.identity,
                                                             mcv_rendered_unit(scene, sensor));
    if (!*kept && (!c->given.command.resume || saves->resumes || !mcv_render_files_finished(files)))
        return MCV_OK;
    snprintf(sentence, sizeof sentence,
             *kept ? "%s: is finished, and stays"
                   : "%s: is of another render, or has no film: it is rendered anew",
             files->exr);
    MCV_TRY(*kept ? tell_kept(c, scene, sensor, files, sentence, error)
                  : tell_note(c, "note", sentence, error));
    return *kept && files->grey[0] ? expose(c, files, error) : MCV_OK;
}

static void warn(mcv_rendering *rendering, const char *sentence) {
    mcv_error ignored;
    (void)tell_note((files_call *)rendering, "warning", sentence, &ignored);
}

/* Renders into the film; previews appear under the name of that of the image. */
static mcv_result render_film(files_call *c, mcv_scene *scene, mcv_render_options *options,
                              uint32_t sensor, mcv_film *film, mcv_render_stats *stats,
                              mcv_early *early, mcv_error *error) {
    mcv_rendering *r = &c->rendering;
    r->early = early;
    mcv_result result = mcv_rendering_run(r, c->session, &c->given.command, scene, sensor, options,
                                          film, stats, error);
    r->early = NULL;
    mcv_early_end(early);
    if (result == MCV_OK && film->samples == 0)
        result = mcv_fail(error, MCV_INTERRUPTED, "%s: interrupted before its first sample",
                          scene->path);
    return result;
}

/* An interrupted image does not replace a finished one. */
static mcv_result choose_files(const mcv_rendering *r, mcv_early *early, mcv_render_files *files,
                               bool *kept, mcv_error *error) {
    mcv_render_files others;
    *kept = r->rendered.stats->interrupted && mcv_render_files_finished(files);
    if (!*kept) return MCV_OK;
    mcv_early_withdraw(early);
    MCV_TRY(mcv_render_files_rename(files, &others, error));
    *files = others;
    return MCV_OK;
}

static mcv_result tell_interrupted(const mcv_saves *saves, const char *finished,
                                   const mcv_render_files *files, mcv_error *error) {
    return mcv_fail(error, MCV_INTERRUPTED, "interrupted: what was rendered is saved in %s%s%s%s%s",
                    files->exr, finished ? "; the finished image stays, " : "",
                    finished ? finished : "", saves->exists ? "; continue by --resume from " : "",
                    saves->exists ? saves->path : "");
}

/* Files that could not be written: what is lost of an hour's work, and how to go on. */
static void tell_checkpoint_stays(const mcv_saves *saves, mcv_result result, mcv_error *error) {
    const mcv_error why = *error;
    if (!saves->exists) return;
    (void)mcv_fail(error, result,
                   "%s; the checkpoint stays, %s: when the files can be written, continue by "
                   "--resume",
                   why.text, saves->path);
}

/* *done: nothing is left to go on with. */
static mcv_result render_planned(files_call *c, mcv_scene *scene, mcv_render_options *options,
                                 uint32_t sensor, const mcv_render_files *planned, bool *done,
                                 mcv_error *error) {
    mcv_render_files files = *planned;
    mcv_render_stats stats = {.stage_count = 0};
    mcv_film film = {0};
    mcv_rendering *r = &c->rendering;
    mcv_early early;
    bool kept = false;
    mcv_sensor_label(scene, sensor, r->sensor, sizeof r->sensor);
    mcv_rendering_tell(r, 0, INFINITY, false);
    mcv_early_begin(&early, scene, sensor, planned->png, mcv_rendered_unit(scene, sensor), options);
    mcv_result result = tell_checkpoint(c, r->saves, error);
    if (result == MCV_OK)
        result = render_film(c, scene, options, sensor, &film, &stats, &early, error);
    if (result == MCV_OK) result = choose_files(r, &early, &files, &kept, error);
    if (result == MCV_OK) {
        mcv_rendering_tell(r, 1, mcv_film_relative_error(&film), true);
        result = write_files(c, &files, early.seconds, error);
        if (result != MCV_OK) tell_checkpoint_stays(r->saves, result, error);
    }
    if (result != MCV_OK) mcv_early_withdraw(&early);
    mcv_early_free(&early);
    if (result == MCV_OK && files.grey[0]) result = expose(c, &files, error);
    /* A part that lacks samples would be merged unnoticed; they are in the checkpoint. */
    if (result == MCV_OK && files.part[0] && !stats.interrupted)
        result = mcv_part_write(files.part, r->saves->identity, &r->rendered, error);
    mcv_film_free(&film);
    if (result == MCV_OK && r->stopped)
        result = tell_interrupted(r->saves, kept ? planned->exr : NULL, &files, error);
    *done = result == MCV_OK || (result == MCV_INTERRUPTED && !stats.interrupted);
    return result;
}

static mcv_result render_sensor(files_call *c, mcv_scene *scene, mcv_render_options options,
                                uint32_t sensor, bool several, mcv_error *error) {
    mcv_render_files files;
    mcv_rendering *r = &c->rendering;
    mcv_saves saves;
    bool done;
    MCV_TRY(mcv_render_files_plan(&c->given.command, scene, sensor, several, &files, error));
    r->begun = mcv_seconds();
    MCV_TRY(mcv_rendering_saves(r, &c->given.command, scene, sensor,
                                files.film[0] ? files.film : NULL, !c->given.command.checkpoint,
                                &saves, error));
    mcv_result result = keep_finished(c, scene, sensor, &files, &saves, &done, error);
    if (result == MCV_OK && !done)
        result = render_planned(c, scene, &options, sensor, &files, &done, error);
    r->rendered = (mcv_rendered){.set = r->rendered.set,
                                 .hash = r->rendered.hash,
                                 .replicates = r->rendered.replicates,
                                 .subpixels = r->rendered.subpixels};
    r->saves = NULL;
    mcv_saves_end(&saves, done);
    return result;
}

/* Of all sensors before the first is rendered: a refusal is to come at once, not hours later. */
static mcv_result lock_files(const files_call *c, const mcv_scene *scene, uint32_t first,
                             uint32_t count, mcv_saves_lock *locks, mcv_error *error) {
    mcv_render_files files;
    for (uint32_t i = 0; i < count && i < MOST_LOCKS; ++i) {
        MCV_TRY(
            mcv_render_files_plan(&c->given.command, scene, first + i, count > 1, &files, error));
        if (files.film[0]) MCV_TRY(mcv_saves_lock_take(locks + i, files.film, error));
    }
    return MCV_OK;
}

static mcv_result render_scene(files_call *c, mcv_scene *scene, const mcv_render_options *options,
                               mcv_error *error) {
    uint32_t first, count;
    MCV_TRY(tell_findings(c, scene, error));
    MCV_TRY(mcv_render_sensors(&c->given.command, scene, &first, &count, error));
    MCV_TRY(mcv_render_files_check(&c->given.command, scene, first, count, error));
    mcv_saves_lock locks[MOST_LOCKS] = {{.path = NULL}};
    mcv_result result = lock_files(c, scene, first, count, locks, error);
    for (uint32_t i = first; i < first + count && result == MCV_OK; ++i)
        result = render_sensor(c, scene, *options, i, count > 1, error);
    for (int i = 0; i < MOST_LOCKS; ++i) mcv_saves_unlock(locks + i);
    return result;
}

static mcv_result render_command(files_call *c, const mcv_rig *rig, mcv_error *error) {
    const mcv_command *command = &c->given.command;
    const mcv_camera_settings camera = mcv_camera_settings_of(command);
    mcv_render_options options;
    mcv_scene *scene = NULL;
    if (!command->camera && mcv_camera_wanted(&camera))
        return mcv_fail(
            error, MCV_USAGE,
            "the exposure belongs to --camera FILE: give --camera, or leave the exposure out");
    MCV_TRY(mcv_render_options_read(command, &options, error));
    const double begun = mcv_seconds();
    mcv_result result = mcv_rendering_changes(&c->rendering, rig, command, error);
    if (result == MCV_OK) result = mcv_session_scene(c->session, rig, command, &scene, error);
    c->seconds_load = rig->seconds + mcv_seconds() - begun;
    if (result == MCV_OK) result = render_scene(c, scene, &options, error);
    mcv_scene_free(scene);
    free((void *)c->rendering.rendered.set.items);
    return result;
}

static mcv_result render_files(files_call *c, const mcv_rig *rig, const char *text,
                               mcv_error *error) {
    const char *const arguments[2] = {rig->document.path};
    MCV_TRY(mcv_options_read(text, c->session->defaults, MCV_VERB_RENDER, arguments, NULL,
                             &c->given, error));
    const mcv_result result = render_command(c, rig, error);
    mcv_options_free(&c->given);
    return result;
}

mcv_result mcv_session_render_files(mcv_session *session, const mcv_rig *rig, const char *options,
                                    mcv_progress_call *progress, mcv_told_call *told, void *user,
                                    mcv_error *error) {
    MCV_NEED(session);
    MCV_NEED(rig);
    MCV_TRY(mcv_session_begin(session, error));
    files_call c = {.rendering = {.call = progress, .user = user, .rig = rig, .warn = warn},
                    .told = told,
                    .session = session};
    c.rendering.host = mcv_border_enter();
    const mcv_result result = render_files(&c, rig, options, error);
    mcv_border_leave(c.rendering.host);
    mcv_session_end(session);
    return result;
}
