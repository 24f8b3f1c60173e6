/* SPDX-License-Identifier: Apache-2.0 */
/* Deflectometry of the public interface. */
#include "verbs/deflectometry.h"

#include <stdlib.h>

#include "api/rendering.h"
#include "core/basics.h"

/* A call while it works. */
typedef struct work {
    mcv_session *session;
    const mcv_rig *rig;
    const mcv_command *command;
    mcv_rendering *rendering;
    mcv_deflectometry found;
    uint32_t sensor, emitter;
    mcv_picture **picture;
    char **report; /* or NULL */
} work;

/* A scene of its own for each direction: its screen shows other elements. */
static mcv_result open_scene(work *w, mcv_scene **scene, mcv_error *error) {
    MCV_TRY(mcv_session_scene(w->session, w->rig, w->command, scene, error));
    mcv_result result = mcv_session_sensor(*scene, w->command, &w->sensor, error);
    if (result == MCV_OK) result = mcv_deflectometry_screen(*scene, w->command, &w->emitter, error);
    if (result == MCV_OK) return MCV_OK;
    mcv_scene_free(*scene);
    *scene = NULL;
    return result;
}

static mcv_result look_across(work *w, uint32_t direction, mcv_error *error) {
    mcv_scene *scene;
    mcv_matrix matrix = {0};
    MCV_TRY(open_scene(w, &scene, error));
    mcv_result result = mcv_deflectometry_show(scene, w->emitter, direction, error);
    if (result == MCV_OK)
        result = mcv_rendering_matrix(w->session, w->command, w->rendering, scene, w->sensor,
                                      &matrix, error);
    if (result == MCV_OK)
        result = mcv_deflectometry_decode(w->command, scene, w->emitter, direction, &matrix,
                                          &w->found, error);
    mcv_matrix_free(&matrix);
    mcv_scene_free(scene);
    return result;
}

static mcv_result find_shape(work *w, mcv_error *error) {
    mcv_scene *scene;
    MCV_TRY(open_scene(w, &scene, error));
    const mcv_result result =
        mcv_deflectometry_shape(w->command, scene, w->sensor, w->emitter, &w->found, error);
    mcv_scene_free(scene);
    return result;
}

static mcv_result tell(const work *w, char **report, mcv_error *error) {
    mcv_report r;
    if (!report) return MCV_OK;
    MCV_TRY(mcv_report_keep(&r, w->command->json, error));
    mcv_report_text(&r, "scene", w->rig->path);
    mcv_deflectometry_report(&w->found, &r);
    mcv_report_number(&r, "seconds", "s", mcv_seconds() - w->rendering->begun);
    if (w->command->shape) mcv_report_text(&r, "image", w->command->shape);
    if (w->command->shape_png) mcv_report_text(&r, "preview", w->command->shape_png);
    if (w->command->slope_png) mcv_report_text(&r, "slopes", w->command->slope_png);
    return mcv_report_take(&r, report, error);
}

static mcv_result run(void *own, const mcv_command *command, mcv_rendering *r, mcv_error *error) {
    work *w = own;
    w->command = command;
    w->rendering = r;
    MCV_TRY(mcv_deflectometry_check(command, error));
    MCV_TRY(look_across(w, 0, error));
    MCV_TRY(look_across(w, 1, error));
    MCV_TRY(find_shape(w, error));
    MCV_TRY(mcv_deflectometry_picture(&w->found, w->picture, error));
    mcv_result result = mcv_deflectometry_write(command, *w->picture, error);
    if (result == MCV_OK) result = tell(w, w->report, error);
    if (result == MCV_OK) return MCV_OK;
    mcv_picture_free(*w->picture);
    *w->picture = NULL;
    return result;
}

mcv_result mcv_session_deflectometry(mcv_session *session, const mcv_rig *rig, const char *options,
                                     mcv_progress_call *progress, void *user, mcv_picture **picture,
                                     char **report, mcv_error *error) {
    MCV_NEED(picture);
    *picture = NULL;
    if (report) *report = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    work w = {.session = session, .rig = rig, .picture = picture, .report = report};
    const mcv_result result = mcv_rendering_verb(session, rig, MCV_VERB_DEFLECTOMETRY, options,
                                                 progress, user, run, &w, error);
    mcv_deflectometry_free(&w.found);
    return result;
}
