/* SPDX-License-Identifier: Apache-2.0 */
#include "io/picture_header.h"

#include "scene/aperture.h"
#include "scene/camera_model.h"
#include "scene/params.h"
#include "scene/sensors.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

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

char *mcv_header_mask(const mcv_sensor *sensor, bool *has) {
    const mcv_aperture_shape shape = mcv_sensor_aperture(sensor);
    char *text = NULL;
    size_t size;
    *has = shape.shape == MCV_APERTURE_MASK;
    FILE *out = *has ? open_memstream(&text, &size) : NULL;
    if (!out) return NULL;
    fprintf(out, "%u", shape.mask->side);
    for (uint32_t i = 0; i < shape.mask->side * shape.mask->side; ++i)
        fprintf(out, " %.9g", (double)shape.mask->values[i]);
    if (fclose(out) == 0) return text;
    free(text);
    return NULL;
}

bool mcv_header_read_mask(const char *text, mcv_mask *mask) {
    char *end;
    const double side = strtod(text, &end);
    *mask = (mcv_mask){.side = 0};
    if (!(side >= 1 && side <= MCV_MASK_SIDE) || side != floor(side)) return false;
    for (uint32_t i = 0; i < (uint32_t)side * (uint32_t)side; ++i) {
        const char *from = end;
        const double value = strtod(from, &end);
        if (end == from || !(value >= 0 && value <= 1)) return false;
        mask->values[i] = (float)value;
    }
    mask->side = (uint32_t)side;
    return *end == '\0';
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
            param->kind == MCV_PARAM_mask || param->kind == MCV_PARAM_curve ||
            param->kind == MCV_PARAM_text)
            continue; /* of the scene */
        if (mcv_param_unset(param, &sensor->as)) continue;
        snprintf(names[count], MCV_EXR_ATTRIBUTE_NAME, "mcvisi:%s", param->key);
        for (uint32_t k = 0; k < a.count; ++k)
            a.numbers[k] = mcv_param_integral(param->kind) ? integers[k] : numbers[k];
        attributes[count++] = a;
    }
    return count;
}
