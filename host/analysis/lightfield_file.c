/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/lightfield_file.h"

#include <math.h>
#include <string.h>

mcv_result mcv_light_field_attribute(const char *path, const mcv_exr *exr, const char *name,
                                     double *numbers, uint32_t count, mcv_error *error) {
    const mcv_attribute *a = mcv_exr_attribute(exr, name);
    if (!a)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: the header has no %s: must be an image of a light field camera", path,
                        name);
    if (a->text || a->count != count)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: %s in the header must be %u number%s", path,
                        name, count, count > 1 ? "s" : "");
    memcpy(numbers, a->numbers, count * sizeof *numbers);
    return MCV_OK;
}

static mcv_result find_angular(const char *path, const mcv_exr *exr, uint32_t angular[2],
                               mcv_error *error) {
    static const char name[] = "mcvisi:angularResolution";
    double numbers[2] = {0};
    if (!mcv_exr_attribute(exr, name))
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: its header has no %s: give the pixels of a macro pixel by --angular JxK, or an "
            "image of a light field camera",
            path, name);
    MCV_TRY(mcv_light_field_attribute(path, exr, name, numbers, 2, error));
    for (int i = 0; i < 2; ++i) {
        if (!(numbers[i] >= 1 && numbers[i] <= MCV_EXR_MAX_SIDE) || numbers[i] != floor(numbers[i]))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: %s %g x %g in the header: must be two integers of at least 1",
                            path, name, numbers[0], numbers[1]);
        angular[i] = (uint32_t)numbers[i];
    }
    return MCV_OK;
}

/* The first three channels are R, G, B where there are any; without them Y, or the only channel, is
 * the light. */
mcv_result mcv_light_field_light(const char *path, const mcv_exr_part *part, mcv_image *light,
                                 mcv_error *error) {
    *light = part->image;
    if (light->channels >= 3 && strcmp(part->channel_names[0], "R") == 0) {
        light->channels = 3;
        return MCV_OK;
    }
    for (uint32_t c = 0; c < part->image.channels; ++c) {
        if (part->image.channels > 1 && strcmp(part->channel_names[c], "Y") != 0) continue;
        light->pixels = part->image.pixels + (size_t)c * light->width * light->height;
        light->channels = 1;
        return MCV_OK;
    }
    return mcv_fail(error, MCV_BAD_INPUT, "%s: its %u channels must be Y, or R, G and B", path,
                    part->image.channels);
}

static mcv_result understand(const char *path, const uint64_t angular[2],
                             mcv_light_field_file *file, mcv_error *error) {
    double black = 0;
    MCV_TRY(mcv_light_field_light(path, file->exr.parts, &file->image, error));
    if (angular[0] > 0) {
        file->angular[0] = (uint32_t)angular[0];
        file->angular[1] = (uint32_t)angular[1];
    } else {
        MCV_TRY(find_angular(path, &file->exr, file->angular, error));
    }
    if (mcv_exr_attribute(&file->exr, "mcvisi:blackLevel"))
        MCV_TRY(mcv_light_field_attribute(path, &file->exr, "mcvisi:blackLevel", &black, 1, error));
    const size_t count = (size_t)file->image.width * file->image.height * file->image.channels;
    for (size_t i = 0; i < count; ++i) file->image.pixels[i] -= (float)black;
    return mcv_light_field_check(path, &file->image, file->angular, error);
}

mcv_result mcv_light_field_of(mcv_exr *exr, const char *path, const uint64_t angular[2],
                              mcv_light_field_file *file, mcv_error *error) {
    file->exr = *exr;
    *exr = (mcv_exr){0};
    const mcv_result result = understand(path, angular, file, error);
    if (result != MCV_OK) mcv_light_field_free(file);
    return result;
}

mcv_result mcv_light_field_read(const char *path, const uint64_t angular[2],
                                mcv_light_field_file *file, mcv_error *error) {
    mcv_exr exr;
    MCV_TRY(mcv_exr_read(path, &exr, error));
    return mcv_light_field_of(&exr, path, angular, file, error);
}

void mcv_light_field_free(mcv_light_field_file *file) { mcv_exr_free(&file->exr); }
