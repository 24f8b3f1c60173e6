/* SPDX-License-Identifier: Apache-2.0 */
/* Compiling ahead what renders of a rig need. */
#include "api/handles.h"
#include "scene/sensor_find.h"
#include "scene/sensors.h"
#include "verbs/render_picture.h"

enum {
    SIDE = 8
}; /* of the image that is rendered: drivers compile kernels at their first launch */

static mcv_result warm_sensor(mcv_renderer *renderer, const mcv_command *command, mcv_scene *scene,
                              uint32_t sensor, mcv_report *report, mcv_error *error) {
    char label[128];
    mcv_render_options options;
    mcv_render_stats stats;
    mcv_film film;
    MCV_TRY(mcv_render_options_read(command, &options, error));
    options.last = 1;
    options.error = options.seconds = 0;
    MCV_TRY(mcv_sensor_resize(scene->sensors + sensor, SIDE, SIDE, scene, error));
    MCV_TRY(mcv_renderer_render(renderer, scene, sensor, &options, &film, &stats, error));
    mcv_film_free(&film);
    mcv_sensor_label(scene, sensor, label, sizeof label);
    mcv_report_element(report, label, stats.device);
    mcv_report_number(report, "seconds", "s", stats.seconds_compile + stats.seconds_render);
    mcv_report_text(report, "features", stats.features);
    mcv_report_close(report);
    return MCV_OK;
}

static mcv_result warm_sensors(mcv_session *session, const mcv_command *command, mcv_scene *scene,
                               mcv_report *report, mcv_error *error) {
    mcv_renderer *renderer;
    uint32_t first = 0, count = scene->sensor_count;
    if (command->sensor) {
        MCV_TRY(mcv_sensor_find(scene, command->sensor, &first, error));
        count = 1;
    }
    MCV_TRY(mcv_session_renderer(session, command->device, &renderer, error));
    mcv_report_list(report, "programs");
    for (uint32_t i = first; i < first + count; ++i)
        MCV_TRY(warm_sensor(renderer, command, scene, i, report, error));
    mcv_report_close(report);
    return MCV_OK;
}

static mcv_result warm_rig(mcv_session *session, const mcv_rig *rig, const mcv_command *command,
                           char **report, mcv_error *error) {
    mcv_scene *scene = NULL;
    mcv_report r;
    if (mcv_wants_reference(command))
        return mcv_fail(error, MCV_USAGE,
                        "the reference renderer has no programs to compile: name an OpenCL device");
    MCV_TRY(mcv_session_scene(session, rig, command, &scene, error));
    mcv_result result = mcv_report_keep(&r, command->json, error);
    if (result == MCV_OK) {
        if (rig->path[0]) mcv_report_text(&r, "scene", scene->path);
        result = warm_sensors(session, command, scene, &r, error);
        if (result == MCV_OK)
            result = mcv_report_take(&r, report, error);
        else
            mcv_report_free(&r);
    }
    mcv_scene_free(scene);
    return result;
}

static mcv_result warm(mcv_session *session, const mcv_rig *rig, const char *options, char **report,
                       mcv_error *error) {
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, session->defaults, MCV_VERB_WARM, arguments, NULL, &given,
                             error));
    const mcv_result result = warm_rig(session, rig, &given.command, report, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_session_warm(mcv_session *session, const mcv_rig *rig, const char *options,
                            char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    MCV_TRY(mcv_session_begin(session, error));
    MCV_INSIDE(result, warm(session, rig, options, report, error));
    mcv_session_end(session);
    return result;
}
