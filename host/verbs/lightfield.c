/* SPDX-License-Identifier: Apache-2.0 */
#include "verbs/lightfield.h"

#include "io/exr_make.h"

#include <string.h>

const char *const mcv_emd_forms[2] = {"normalized", "mass"};

/* Attributes that are no longer valid: the result has no macro pixels and no black level. */
static bool is_past(const char *attribute) {
    return strcmp(attribute, "mcvisi:angularResolution") == 0 ||
           strcmp(attribute, "mcvisi:blackLevel") == 0;
}

/* An image, which changes owners, with its own attributes and those of its source that still hold.
 */
static mcv_result make(const mcv_exr *source, mcv_image image, const mcv_attribute *own,
                       uint32_t own_count, mcv_exr *exr, mcv_error *error) {
    *exr = (mcv_exr){0};
    mcv_result result = mcv_exr_add_part(exr, "image", image, NULL, error);
    if (result == MCV_OK) result = mcv_exr_set_attributes(exr, own, own_count, error);
    for (uint32_t i = 0; i < source->attribute_count && result == MCV_OK; ++i) {
        const mcv_attribute *a = source->attributes + i;
        if (!is_past(a->name) && !mcv_exr_attribute(exr, a->name))
            result = mcv_exr_set_attributes(exr, a, 1, error);
    }
    if (result != MCV_OK) mcv_exr_free(exr);
    return result;
}

/* The views of each other part that is as large: its errors. */
static mcv_result add_views(const mcv_light_field_file *file, mcv_exr *views, mcv_error *error) {
    const mcv_exr *exr = &file->exr;
    for (uint32_t i = 1; i < exr->part_count; ++i) {
        mcv_image light, image;
        if (exr->parts[i].image.width != file->image.width ||
            exr->parts[i].image.height != file->image.height)
            continue;
        MCV_TRY(mcv_light_field_light(exr->parts[i].name, exr->parts + i, &light, error));
        MCV_TRY(mcv_light_field_views(&light, file->angular, &image, error));
        MCV_TRY(mcv_exr_add_part(views, exr->parts[i].name, image, NULL, error));
    }
    return MCV_OK;
}

mcv_result mcv_views_make(const mcv_light_field_file *file, mcv_exr *views, mcv_error *error) {
    const mcv_attribute own[] = {{.name = "mcvisi:layout", .text = "sub-aperture views"}};
    mcv_image image;
    MCV_TRY(mcv_light_field_views(&file->image, file->angular, &image, error));
    MCV_TRY(make(&file->exr, image, own, 1, views, error));
    const mcv_result result = add_views(file, views, error);
    if (result != MCV_OK) mcv_exr_free(views);
    return result;
}

/* The noise floor and the gradient over it, where the image states its errors. */
static mcv_result add_floor(const mcv_command *command, const mcv_light_field_file *file,
                            mcv_exr *gradient, mcv_error *error) {
    const mcv_image *errors = mcv_exr_error(&file->exr);
    mcv_image noise_floor, ratio;
    if (!errors) return MCV_OK;
    MCV_TRY(mcv_light_field_floor(&file->image, errors, file->angular,
                                  command->form ? MCV_EMD_MASS : MCV_EMD_NORMALIZED,
                                  (uint32_t)command->threads, &noise_floor, error));
    mcv_result result = mcv_image_copy(&gradient->parts[0].image, &ratio, error);
    if (result != MCV_OK) {
        mcv_image_free(&noise_floor);
        return result;
    }
    for (size_t i = 0; i < (size_t)ratio.width * ratio.height; ++i)
        ratio.pixels[i] /= noise_floor.pixels[i];
    result = mcv_exr_add_part(gradient, MCV_GRADIENT_FLOOR, noise_floor, NULL, error);
    if (result == MCV_OK)
        result = mcv_exr_add_part(gradient, MCV_GRADIENT_RATIO, ratio, NULL, error);
    else
        mcv_image_free(&ratio);
    return result;
}

mcv_result mcv_gradient_make(const mcv_command *command, const mcv_light_field_file *file,
                             mcv_exr *gradient, mcv_error *error) {
    static const char *const units[] = {"fraction of the pupil",
                                        "fraction of the pupil x median mass"};
    const mcv_attribute own[] = {{.name = "mcvisi:quantity", .text = "Earth Mover's gradient"},
                                 {.name = "mcvisi:unit", .text = units[command->form]},
                                 {.name = "mcvisi:form", .text = mcv_emd_forms[command->form]}};
    mcv_image image;
    MCV_TRY(mcv_light_field_gradient(&file->image, file->angular,
                                     command->form ? MCV_EMD_MASS : MCV_EMD_NORMALIZED,
                                     (uint32_t)command->threads, &image, error));
    MCV_TRY(make(&file->exr, image, own, sizeof own / sizeof own[0], gradient, error));
    const mcv_result result = add_floor(command, file, gradient, error);
    if (result != MCV_OK) mcv_exr_free(gradient);
    return result;
}
