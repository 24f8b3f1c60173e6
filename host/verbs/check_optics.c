/* SPDX-License-Identifier: Apache-2.0 */
/* The report of mcvisi check about sensors: their optics, and the growth of edges in their
 * images. */
#include "verbs/check_report.h"

#include "check/growth.h"
#include "reference/filling.h"
#include "scene/camera_model.h"
#include "scene/emitters.h"
#include "scene/params.h"
#include "scene/sensor_find.h"
#include "scene/sensors.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A smaller share of a pupil, or of the directions, is probably a mistake. Of the square of
 * directions a cone half as wide fills π/16, which shows the largest deflections on both sides. */
static const double little_of_pupil = 0.5, little_of_directions = 0.19;

/* The share of a sensor's pupil, or of its directions, that each emitter with a cone fills. */
static mcv_result report_fillings(mcv_report *report, const mcv_scene *scene, uint32_t index,
                                  mcv_findings *findings, mcv_error *error) {
    const mcv_sensor *sensor = scene->sensors + index;
    const bool directions = sensor->type == MCV_SENSOR_LIGHT_FIELD;
    ref_filling *fillings;
    uint32_t count;
    mcv_result result = ref_sensor_fillings(scene, index, &fillings, &count, error);
    if (result == MCV_OK && count > 0) mcv_report_list(report, "faces_emitters");
    for (uint32_t i = 0; i < count && result == MCV_OK; ++i) {
        const mcv_emitter *emitter = scene->emitters + fillings[i].emitter;
        mcv_report_element(report, emitter->name, mcv_emitter_types[emitter->type]);
        mcv_report_number(report, directions ? "share_of_directions_lit" : "share_of_pupil_lit", "",
                          fillings[i].share);
        mcv_report_close(report);
        if (fillings[i].share < (directions ? little_of_directions : little_of_pupil))
            result = mcv_findings_add(
                findings, MCV_SEVERITY_WARNING, "emitters", emitter->name, NULL, error,
                "emitter \"%s\" fills %.2g %% of the %s of sensor \"%s\" that looks into it: its "
                "cone is narrower than the sensor's acceptance",
                emitter->name, 100 * fillings[i].share, directions ? "J x K directions" : "pupil",
                sensor->name);
    }
    if (result == MCV_OK && count > 0) mcv_report_close(report);
    free(fillings);
    return result;
}

/* The growth of edges before a backlight. */
static void report_growth(mcv_report *report, const mcv_scene *scene, const mcv_sensor *sensor) {
    mcv_growth growth;
    char sentence[512];
    if (!mcv_growth_of(scene, sensor, &growth)) return;
    mcv_growth_sentence(scene, &growth, sentence);
    mcv_report_open(report, "silhouettes");
    mcv_report_text(report, "backlight", scene->emitters[growth.emitter].name);
    mcv_report_text(report, "part", scene->instances[growth.instance].name);
    mcv_report_number(report, "thickness", "m", growth.thickness);
    mcv_report_number(report, "tangent_of_cone", "", growth.cone);
    mcv_report_quantity(report, "growth_of_edge", "m", growth.edge.value, growth.edge.uncertainty);
    if (report->json)
        mcv_report_text(report, "note", sentence); /* people read it in the findings */
    mcv_report_close(report);
}

/* As in headers, without the nodes. */
static mcv_result report_model(mcv_report *report, const mcv_scene *scene, const mcv_sensor *sensor,
                               mcv_error *error) {
    mcv_camera_model model;
    if (!report->json) return MCV_OK;
    MCV_TRY(mcv_camera_model_of(scene, sensor, &model, error));
    char *text = mcv_camera_model_write(&model);
    json_t *object = text ? json_loads(text, 0, NULL) : NULL;
    mcv_camera_model_free(&model);
    free(text);
    if (!object)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for the camera model", scene->path);
    json_object_del(object, "nodes");
    mcv_report_value(report, "camera_model", object);
    return MCV_OK;
}

mcv_result mcv_check_report_sensor(mcv_report *report, const mcv_scene *scene, uint32_t index,
                                   mcv_findings *findings, mcv_error *error) {
    const mcv_sensor *sensor = scene->sensors + index;
    const mcv_optics optics = mcv_sensor_optics(sensor);
    const uint32_t type = mcv_sensor_told_type(sensor);
    uint32_t width, height;
    char label[128];
    mcv_sensor_film_size(sensor, &width, &height);
    mcv_sensor_label(scene, index, label, sizeof label);
    mcv_report_element(report, label, mcv_sensor_types[type]);
    mcv_check_report_place(report, &sensor->to_world);
    mcv_report_numbers(report, "image", "", " x ", (const double[]){width, height}, 2);
    mcv_check_report_parameters(report, mcv_sensor_table(type), &sensor->as);
    mcv_report_open(report, "optics");
    mcv_report_number(report, "magnification", "", optics.magnification);
    mcv_report_number(report, "working_distance", "m", optics.focused_depth);
    mcv_report_number(report, "tilt_of_plane_in_focus", "rad", optics.object_tilt);
    if (isfinite(optics.object_tilt))
        mcv_report_numbers(report, "depths_in_focus", "m", " to ", optics.plane_depths, 2);
    mcv_report_numbers(report, "depth_of_field", "m", " to ", optics.depth_of_field, 2);
    mcv_report_numbers(report, "field_of_view", "m", " x ", optics.field, 2);
    mcv_report_numbers(report, "angle_of_view", "rad", " x ", optics.field_angle, 2);
    mcv_report_number(report, "f_number", "", optics.f_number);
    mcv_report_number(report, "numerical_aperture", "", optics.numerical_aperture);
    mcv_report_numbers(report, "macro_pixel_pitch", "m", " x ", optics.macro_pixel, 2);
    mcv_report_close(report);
    MCV_TRY(report_model(report, scene, sensor, error));
    MCV_TRY(report_fillings(report, scene, index, findings, error));
    report_growth(report, scene, sensor);
    mcv_report_close(report);
    return MCV_OK;
}
