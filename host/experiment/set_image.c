/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/set_image.h"

#include "scene/camera_model.h"
#include "scene/sensor_find.h"

#include <string.h>

mcv_result mcv_set_image_develop(const mcv_scene *scene, uint32_t sensor, const mcv_film *film,
                                 mcv_set_image *image, mcv_error *error) {
    const bool irradiance = mcv_sensor_measures_irradiance(scene->sensors + sensor);
    memset(image, 0, sizeof *image);
    mcv_attribute *attributes = image->attributes;
    mcv_exr_part *parts = image->parts;
    attributes[0] =
        (mcv_attribute){.name = "mcvisi:quantity", .text = irradiance ? "irradiance" : "radiance"};
    attributes[1] =
        (mcv_attribute){.name = "mcvisi:unit", .text = irradiance ? "W/m^2" : "W/(m^2 sr)"};
    parts[0].name = "image";
    parts[1].name = "error";
    image->exr = (mcv_exr){
        .parts = parts, .part_count = film->replicates > 1 ? 2 : 1, .attributes = attributes};
    attributes[2] = (mcv_attribute){
        .name = "mcvisi:errorFreedom", .numbers = {film->replicates - 1.0}, .count = 1};
    attributes[3] = (mcv_attribute){
        .name = MCV_EXR_CHANNELS, .numbers = {mcv_film_channel_correlation(film)}, .count = 1};
    image->exr.attribute_count =
        4 + mcv_header_attributes(scene->sensors + sensor, attributes + 4, image->names);
    MCV_TRY(mcv_film_develop(film, &parts[0].image, &parts[1].image, error));
    MCV_TRY(mcv_header_describe(scene, sensor, &parts[0].image, error));
    attributes[image->exr.attribute_count++] =
        (mcv_attribute){.name = MCV_CAMERA_MODEL_KEY, .text = parts[0].image.description};
    return MCV_OK;
}

void mcv_set_image_free(mcv_set_image *image) {
    mcv_image_free(&image->parts[0].image);
    mcv_image_free(&image->parts[1].image);
}

mcv_result mcv_set_image_keep(const char *path, const mcv_scene *scene, uint32_t sensor,
                              const mcv_film *film, uint32_t seed, const char *overrides,
                              mcv_error *error) {
    mcv_set_image image;
    mcv_attribute attributes[MCV_PICTURE_PARAMETERS + 11];
    mcv_result result = mcv_set_image_develop(scene, sensor, film, &image, error);
    uint32_t count = image.exr.attribute_count;
    memcpy(attributes, image.attributes, count * sizeof *attributes);
    attributes[count++] = (mcv_attribute){.name = "mcvisi:scene", .text = scene->path};
    attributes[count++] = (mcv_attribute){.name = "mcvisi:seed", .numbers = {seed}, .count = 1};
    attributes[count++] =
        (mcv_attribute){.name = "mcvisi:replicates", .numbers = {film->replicates}, .count = 1};
    attributes[count++] = (mcv_attribute){
        .name = "mcvisi:samplesPerReplicate", .numbers = {(double)film->samples}, .count = 1};
    attributes[count++] = (mcv_attribute){.name = "mcvisi:set", .text = overrides};
    if (result == MCV_OK)
        result = mcv_exr_write(path, image.parts, image.exr.part_count, attributes, count, error);
    mcv_set_image_free(&image);
    return result;
}
