/* SPDX-License-Identifier: Apache-2.0 */
/* Camera models of the public interface. */
#include "verbs/camera_model.h"

#include "api/handles.h"
#include "core/basics.h"

#include <stdlib.h>
#include <string.h>

static mcv_result export_sensor(const mcv_command *command, mcv_scene *scene, char **text,
                                mcv_error *error) {
    mcv_calibration_texts texts;
    uint32_t sensor;
    if (!command->model && command->format == MCV_CALIBRATION_COLMAP)
        return mcv_fail(error, MCV_USAGE,
                        "--output is missing: COLMAP has three files: give their folder");
    MCV_TRY(mcv_session_sensor(scene, command, &sensor, error));
    MCV_TRY(mcv_camera_model_export(command, scene, sensor, &texts, error));
    mcv_result result = command->model ? mcv_camera_model_save(command, &texts, error) : MCV_OK;
    if (result == MCV_OK && text) {
        *text = texts.items[0];
        texts.items[0] = NULL;
    }
    mcv_calibration_texts_free(&texts);
    return result;
}

static mcv_result export_model(const mcv_rig *rig, const char *options, char **text,
                               mcv_error *error) {
    static const char *const without[] = {"import", "pixel-size", NULL};
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    mcv_scene *scene = NULL;
    MCV_TRY(
        mcv_options_read(options, NULL, MCV_VERB_CAMERA_MODEL, arguments, without, &given, error));
    mcv_result result = mcv_session_scene(NULL, rig, &given.command, &scene, error);
    if (result == MCV_OK) result = export_sensor(&given.command, scene, text, error);
    mcv_scene_free(scene);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_rig_camera_model(const mcv_rig *rig, const char *options, char **text,
                                mcv_error *error) {
    mcv_result result;
    if (text) *text = NULL;
    MCV_NEED(rig);
    MCV_INSIDE(result, export_model(rig, options, text, error));
    return result;
}

/* --- the other way --- */

/* On a copy of the tree: after failure the rig is as it was. */
static mcv_result add(mcv_rig *rig, const mcv_command *command, char **report, mcv_error *error) {
    mcv_report r;
    json_t *root = json_deep_copy(rig->document.root);
    mcv_result result = mcv_report_keep(&r, command->json, error);
    if (result == MCV_OK && !root) result = mcv_fail(error, MCV_FAILED, "no memory for the rig");
    if (result == MCV_OK) result = mcv_camera_model_import(command, root, &r, error);
    if (result == MCV_OK && report)
        result = mcv_report_take(&r, report, error);
    else
        mcv_report_free(&r);
    if (result == MCV_OK)
        mcv_rig_take_root(rig, root);
    else
        json_decref(root);
    return result;
}

static mcv_result add_camera(mcv_rig *rig, const char *file, const char *options, char **report,
                             mcv_error *error) {
    static const char *const without[] = {"import", "output", "format", "resolution", "set", NULL};
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    MCV_TRY(
        mcv_options_read(options, NULL, MCV_VERB_CAMERA_MODEL, arguments, without, &given, error));
    given.command.import = file;
    const mcv_result result = add(rig, &given.command, report, error);
    mcv_options_free(&given);
    return result;
}

mcv_result mcv_rig_add_camera(mcv_rig *rig, const char *file, const char *options, char **report,
                              mcv_error *error) {
    mcv_result result;
    if (report) *report = NULL;
    MCV_NEED(rig);
    MCV_NEED(file);
    MCV_INSIDE(result, add_camera(rig, file, options, report, error));
    return result;
}
