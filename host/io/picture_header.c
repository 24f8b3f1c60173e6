/* SPDX-License-Identifier: Apache-2.0 */
#include "io/picture_header.h"

#include "scene/aperture.h"
#include "scene/camera_model.h"
#include "scene/params.h"
#include "scene/sensors.h"

#include <stdio.h>

mcv_result mcv_header_describe(const mcv_scene *scene, uint32_t sensor, mcv_image *image,
                               mcv_error *error) {
    mcv_camera_model model;
    MCV_TRY(mcv_camera_model_of(scene, scene->sensors + sensor, &model, error));
    image->description = mcv_camera_model_write(&model);
    mcv_camera_model_free(&model);
    return image->description
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "%s: no memory for the camera model", scene->path);
}

uint32_t mcv_header_attributes(const mcv_sensor *sensor,
                               mcv_attribute attributes[MCV_PICTURE_PARAMETERS],
                               char names[MCV_PICTURE_PARAMETERS][MCV_EXR_ATTRIBUTE_NAME]) {
    const mcv_param_table table = mcv_sensor_table(sensor->type);
    const int aperture = mcv_sensor_aperture(sensor).shape;
    uint32_t count = 0;
    if (aperture != MCV_APERTURE_DISC) {
        snprintf(names[count], MCV_EXR_ATTRIBUTE_NAME, "%s", MCV_PICTURE_APERTURE);
        attributes[count] =
            (mcv_attribute){.name = names[count], .text = mcv_param_options("aperture")[aperture]};
        ++count;
    }
    for (size_t i = 0; i < table.count && count < MCV_PICTURE_PARAMETERS; ++i) {
        const mcv_param *param = table.params + i;
        const void *field = (const char *)&sensor->as + param->offset;
        const uint32_t *integers = field;
        const double *numbers = field;
        mcv_attribute a = {.name = names[count],
                           .count = (uint32_t)mcv_param_components(param->kind)};
        if (param->kind == MCV_PARAM_choice || param->kind == MCV_PARAM_flag ||
            param->kind == MCV_PARAM_image || param->kind == MCV_PARAM_pattern ||
            param->kind == MCV_PARAM_mask)
            continue; /* of the scene */
        if (mcv_param_unset(param, &sensor->as)) continue;
        snprintf(names[count], MCV_EXR_ATTRIBUTE_NAME, "mcvisi:%s", param->key);
        for (uint32_t k = 0; k < a.count; ++k)
            a.numbers[k] = mcv_param_integral(param->kind) ? integers[k] : numbers[k];
        attributes[count++] = a;
    }
    return count;
}
