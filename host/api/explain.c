/* SPDX-License-Identifier: Apache-2.0 */
/* Explained pixels of the public interface. */
#include "verbs/explain.h"

#include "api/handles.h"

static mcv_result explain_scene(mcv_session *session, const mcv_rig *rig,
                                const mcv_command *command, char **report, mcv_error *error) {
    mcv_scene *scene = NULL;
    mcv_report r;
    uint32_t sensor;
    MCV_TRY(mcv_session_scene(session, rig, command, &scene, error));
    mcv_result result = mcv_session_sensor(scene, command, &sensor, error);
    if (result == MCV_OK) {
        result = mcv_report_keep(&r, command->json, error);
        if (result == MCV_OK) result = mcv_explain(command, scene, sensor, &r, error);
        if (result == MCV_OK)
            result = mcv_report_take(&r, report, error);
        else
            mcv_report_free(&r);
    }
    mcv_scene_free(scene);
    return result;
}

static mcv_result explain(mcv_session *session, const mcv_rig *rig, const char *options,
                          char **report, mcv_error *error) {
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    MCV_TRY(mcv_options_read(options, NULL, MCV_VERB_EXPLAIN, arguments, NULL, &given, error));
    const mcv_result result = explain_scene(session, rig, &given.command, report, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_session_explain(mcv_session *session, const mcv_rig *rig, const char *options,
                               char **report, mcv_error *error) {
    mcv_result result;
    MCV_NEED(report);
    *report = NULL;
    MCV_NEED(session);
    MCV_NEED(rig);
    MCV_TRY(mcv_session_begin(session, error));
    MCV_INSIDE(result, explain(session, rig, options, report, error));
    mcv_session_end(session);
    return result;
}
