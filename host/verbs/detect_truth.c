/* SPDX-License-Identifier: Apache-2.0 */
/* Which pixels see a defect, by geometry, beside those that show it. */
#include "verbs/detect.h"

#include "io/values.h"
#include "loader/load.h"
#include "reference/defect_mask.h"
#include "scene/sensor_find.h"
#include "scene/sensors.h"

#include <math.h>

/* The mask of the scene's sensor at the size of the picture, and the set-up for the page. */
static mcv_result look_through(const mcv_command *command, mcv_scene *scene, mcv_detected *detected,
                               mcv_error *error) {
    const mcv_image *like = &detected->sigmas;
    uint32_t sensor = 0;
    if (scene->sensor_count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no sensor", scene->path);
    if (command->sensor) MCV_TRY(mcv_sensor_find(scene, command->sensor, &sensor, error));
    MCV_TRY(mcv_sensor_resize(scene->sensors + sensor, like->width, like->height, scene, error));
    MCV_TRY(ref_defect_mask(scene, sensor, &detected->truth, error));
    if (command->detected && !(detected->setup = mcv_detect_draw(scene, sensor)))
        return mcv_fail(error, MCV_FAILED, "no memory for the drawing of the set-up");
    return MCV_OK;
}

static mcv_result save(const char *path, const mcv_image *truth, mcv_error *error) {
    mcv_image grey;
    if (!mcv_values_named(path))
        return mcv_fail(error, MCV_USAGE, "--truth %s: must end in " MCV_VALUES_ENDINGS, path);
    MCV_TRY(mcv_image_new(&grey, truth->width, truth->height, 1, error));
    for (size_t i = 0; i < (size_t)grey.width * grey.height; ++i)
        grey.pixels[i] = roundf(255 * truth->pixels[i]);
    const mcv_result result = mcv_values_write(path, &grey, 8, error);
    mcv_image_free(&grey);
    return result;
}

mcv_result mcv_detect_look(const mcv_command *command, mcv_detected *detected, mcv_error *error) {
    const mcv_overrides set = {command->set.items, command->set.count};
    mcv_scene *scene;
    if (!command->marred_rig && (command->truth || command->sensor || command->set.count))
        return mcv_fail(error, MCV_USAGE,
                        "--rig is missing: --truth, --sensor and --set are for the rig with the "
                        "defect");
    if (!command->marred_rig) return MCV_OK;
    MCV_TRY(mcv_scene_load(command->marred_rig, set, &scene, error));
    const mcv_result result = look_through(command, scene, detected, error);
    mcv_scene_free(scene);
    MCV_TRY(result);
    return command->truth ? save(command->truth, &detected->truth, error) : MCV_OK;
}

void mcv_detect_report_truth(const mcv_command *command, const mcv_detected *detected,
                             mcv_report *report) {
    const mcv_image *truth = &detected->truth;
    double area = 0, seeing = 0, showing = 0, elsewhere = 0;
    if (!truth->pixels) return;
    for (size_t i = 0; i < (size_t)truth->width * truth->height; ++i) {
        const bool shows = (double)detected->sigmas.pixels[i] >= command->visible;
        area += (double)truth->pixels[i];
        seeing += truth->pixels[i] > 0;
        showing += truth->pixels[i] > 0 && shows;
        elsewhere += truth->pixels[i] == 0 && shows;
    }
    mcv_report_open(report, "truth");
    mcv_report_number(report, "area", "px", area);
    mcv_report_number(report, "pixels", "", seeing);
    mcv_report_number(report, "visible", "", showing);
    mcv_report_number(report, "visible_elsewhere", "", elsewhere);
    mcv_report_close(report);
}
