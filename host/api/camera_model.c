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

static mcv_result edit(const mcv_rig *rig, const mcv_command *command, json_t *root,
                       mcv_report *report, mcv_error *error) {
    (void)rig;
    return mcv_camera_model_import(command, root, report, error);
}

static mcv_result add_camera(mcv_rig *rig, const char *file, const char *options, char **report,
                             mcv_error *error) {
    static const char *const without[] = {"import", "output", "format", "resolution", "set", NULL};
    const char *const arguments[2] = {rig->document.path};
    mcv_options_given given;
    MCV_TRY(
        mcv_options_read(options, NULL, MCV_VERB_CAMERA_MODEL, arguments, without, &given, error));
    given.command.import = file;
    const mcv_result result = mcv_rig_change(rig, &given.command, edit, report, error);
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
