/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/camera_model.h"

#include "core/output_file.h"
#include "scene/params.h"
#include "scene/sensor_find.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* Where a file does not state it, and nobody else does. */
static const double usual_pixel = 5e-6;

mcv_result mcv_camera_model_export(const mcv_command *command, const mcv_scene *scene,
                                   uint32_t sensor, mcv_calibration_texts *texts,
                                   mcv_error *error) {
    mcv_camera_model model;
    char label[128];
    mcv_sensor_label(scene, sensor, label, sizeof label);
    MCV_TRY(mcv_camera_model_of(scene, scene->sensors + sensor, &model, error));
    const mcv_result result =
        mcv_calibration_write(&model, label, (mcv_calibration_format)command->format, texts, error);
    mcv_camera_model_free(&model);
    return result;
}

mcv_result mcv_camera_model_save(const mcv_command *command, const mcv_calibration_texts *texts,
                                 mcv_error *error) {
    char path[PATH_MAX];
    if (!texts->items[1])
        return mcv_output_whole(command->model, texts->items[0], strlen(texts->items[0]), error);
    if (mkdir(command->model, 0777) != 0 && errno != EEXIST)
        return mcv_fail(error, MCV_BAD_INPUT, "--output %s: the folder cannot be made: %s",
                        command->model, strerror(errno));
    for (int i = 0; i < MCV_CALIBRATION_FILES; ++i) {
        if (snprintf(path, sizeof path, "%s/%s", command->model, mcv_colmap_files[i]) >= PATH_MAX)
            return mcv_fail(error, MCV_USAGE, "--output: the path is longer than %d bytes",
                            PATH_MAX);
        MCV_TRY(mcv_output_whole(path, texts->items[i], strlen(texts->items[i]), error));
    }
    return MCV_OK;
}

/* --- the other way --- */

static void tell(const mcv_calibration *camera, const char *path, const char *name,
                 mcv_report *report) {
    const mcv_camera_model *m = &camera->model;
    double place[3] = {0};
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) place[i] -= m->rotation[3 * j + i] * m->translation[j];
    mcv_report_text(report, "sensor", name);
    mcv_report_text(report, "from", path);
    mcv_report_text(report, "model", m->telecentric ? "telecentric" : "perspective");
    mcv_report_numbers(report, "size", "", " x ", (const double[]){m->size[0], m->size[1]}, 2);
    mcv_report_numbers(report, "position", "m", ", ", place, 3);
    if (!camera->posed)
        mcv_report_tell(report, "note",
                        "the file states no pose: the camera stands in the world's origin");
    if (!(m->pixel[0] > 0))
        mcv_report_tell(report, "note",
                        "the file states no size of a pixel: that of --pixel-size is taken, or "
                        "5um; directions do not depend on it");
    if (m->telecentric && !isfinite(m->focused_depth))
        mcv_report_tell(report, "note",
                        "the file states no plane in focus: the working distance is 100mm");
    if (m->telecentric && !isfinite(m->f_number))
        mcv_report_tell(report, "note", "the file states no aperture: the f-number is 8");
}

mcv_result mcv_camera_model_import(const mcv_command *command, json_t *document, mcv_report *report,
                                   mcv_error *error) {
    const char *path = command->import;
    mcv_calibration camera;
    double pixel = usual_pixel;
    if (command->pixel_size &&
        (!mcv_parse_quantity(command->pixel_size, MCV_PARAM_length, &pixel) || !(pixel > 0)))
        return mcv_fail(error, MCV_USAGE,
                        "--pixel-size %s: must be a length above 0, as in 3.45um (nm, um, mm, cm, "
                        "m, inch)",
                        command->pixel_size);
    MCV_TRY(mcv_calibration_read(path, &camera, error));
    const char *name = command->sensor ? command->sensor : camera.name[0] ? camera.name : "camera";
    MCV_TRY(mcv_calibration_add(&camera, path, name, pixel, document, error));
    tell(&camera, path, name, report);
    return MCV_OK;
}
