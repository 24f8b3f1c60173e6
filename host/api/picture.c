/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of the public interface: made, read and looked into. */
#include "api/handles.h"
#include "core/basics.h"
#include "io/exr_json.h"
#include "io/png.h"
#include "io/values.h"
#include "scene/camera_model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void free_picture(mcv_picture *picture) {
    mcv_exr_free(&picture->exr);
    free(picture->path);
    free(picture);
}

void mcv_picture_free(mcv_picture *picture) {
    if (picture) free_picture(picture);
}

mcv_result mcv_picture_of(mcv_exr *exr, const char *name, mcv_picture **picture, mcv_error *error) {
    mcv_picture *p = calloc(1, sizeof *p);
    if (p) {
        p->exr = *exr;
        p->path = strdup(name);
        if (p->path) {
            *picture = p;
            return MCV_OK;
        }
        free_picture(p);
    } else {
        mcv_exr_free(exr);
    }
    *exr = (mcv_exr){0};
    mcv_fail(error, MCV_FAILED, "no memory for the picture");
    return MCV_FAILED;
}

/* --- files --- */

/* Of a file of grey values: its description is the camera model. */
static mcv_result read_values(const char *path, mcv_exr *exr, mcv_error *error) {
    mcv_image image;
    MCV_TRY(mcv_values_read(path, &image, error));
    MCV_TRY(mcv_exr_add_part(exr, "image", image, NULL, error));
    const mcv_attribute attributes[] = {
        {.name = "mcvisi:quantity", .text = "grey value"},
        {.name = "mcvisi:unit", .text = "DN"},
        {.name = MCV_CAMERA_MODEL_KEY, .text = exr->parts[0].image.description}};
    return mcv_exr_set_attributes(exr, attributes, exr->parts[0].image.description ? 3 : 2, error);
}

static mcv_result read_picture(const char *path, mcv_picture **picture, mcv_error *error) {
    const bool is_exr = mcv_ends_in(path, ".exr");
    mcv_exr exr = {0};
    const mcv_result result =
        is_exr ? mcv_exr_read(path, &exr, error) : read_values(path, &exr, error);
    if (result != MCV_OK) {
        mcv_exr_free(&exr);
        return result;
    }
    MCV_TRY(mcv_picture_of(&exr, path, picture, error));
    (*picture)->values = !is_exr;
    (*picture)->srgb = !is_exr && mcv_png_is_srgb(path);
    return MCV_OK;
}

mcv_result mcv_picture_read(const char *path, mcv_picture **picture, mcv_error *error) {
    mcv_result result;
    MCV_NEED(picture);
    *picture = NULL;
    MCV_NEED(path);
    MCV_INSIDE(result, read_picture(path, picture, error));
    return result;
}

/* --- from memory --- */

static mcv_result set_attributes(mcv_exr *exr, const char *text, mcv_error *error) {
    json_error_t wrong;
    json_t *object = json_loads(text, JSON_REJECT_DUPLICATES, &wrong);
    const mcv_result result = mcv_attributes_set_json(exr, object, error);
    json_decref(object);
    return result;
}

static mcv_result add_planes(mcv_exr *exr, const char *name, uint32_t width, uint32_t height,
                             uint32_t channels, const float *planes, mcv_error *error) {
    const size_t plane = (size_t)width * height, count = plane * channels;
    const bool signed_values = strcmp(name, "image") == 0;
    mcv_image image;
    for (size_t i = 0; i < count; ++i)
        if (!isfinite(planes[i]) || (!signed_values && planes[i] < 0))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "the %s in channel %zu, row %zu, column %zu is %g: must be finite%s",
                            signed_values ? "value" : "standard uncertainty", i / plane,
                            i % plane / width, i % width, (double)planes[i],
                            signed_values ? "" : " and not negative");
    MCV_TRY(mcv_image_new(&image, width, height, channels, error));
    memcpy(image.pixels, planes, count * sizeof *planes);
    return mcv_exr_add_part(exr, name, image, NULL, error);
}

static mcv_result make_parts(uint32_t width, uint32_t height, uint32_t channels,
                             const float *planes, const float *deviation, const char *attributes,
                             mcv_exr *exr, mcv_error *error) {
    if ((channels != 1 && channels != 3) || width < 1 || height < 1 || width > MCV_EXR_MAX_SIDE ||
        height > MCV_EXR_MAX_SIDE)
        return mcv_fail(error, MCV_USAGE,
                        "a picture of %u x %u pixels and %u channels: must have 1 to %d pixels on "
                        "a side, and 1 or 3 channels",
                        width, height, channels, MCV_EXR_MAX_SIDE);
    MCV_TRY(add_planes(exr, "image", width, height, channels, planes, error));
    if (deviation) MCV_TRY(add_planes(exr, "error", width, height, channels, deviation, error));
    return attributes && attributes[0] ? set_attributes(exr, attributes, error) : MCV_OK;
}

static mcv_result make_picture(uint32_t width, uint32_t height, uint32_t channels,
                               const float *planes, const float *deviation, const char *attributes,
                               mcv_picture **picture, mcv_error *error) {
    mcv_exr exr = {0};
    const mcv_result result =
        make_parts(width, height, channels, planes, deviation, attributes, &exr, error);
    if (result == MCV_OK) return mcv_picture_of(&exr, "the picture", picture, error);
    mcv_exr_free(&exr);
    return result;
}

mcv_result mcv_picture_make(uint32_t width, uint32_t height, uint32_t channels, const float *planes,
                            const float *deviation, const char *attributes, mcv_picture **picture,
                            mcv_error *error) {
    mcv_result result;
    MCV_NEED(picture);
    *picture = NULL;
    MCV_NEED(planes);
    MCV_INSIDE(result, make_picture(width, height, channels, planes, deviation, attributes, picture,
                                    error));
    return result;
}

/* --- what is in it --- */

uint32_t mcv_picture_part_count(const mcv_picture *picture) { return picture->exr.part_count; }

mcv_result mcv_picture_part(const mcv_picture *picture, uint32_t index, mcv_part *part,
                            mcv_error *error) {
    MCV_NEED(picture);
    MCV_NEED(part);
    if (part->size < sizeof *part)
        return mcv_fail(error, MCV_USAGE, "mcv_picture_part: part->size must be sizeof(mcv_part)");
    if (index >= picture->exr.part_count)
        return mcv_fail(error, MCV_USAGE, "there is no part %u: the picture has %u", index,
                        picture->exr.part_count);
    const mcv_exr_part *from = picture->exr.parts + index;
    part->name = from->name;
    part->width = from->image.width;
    part->height = from->image.height;
    part->channels = from->image.channels;
    part->planes = from->image.pixels;
    return MCV_OK;
}

static mcv_result list_attributes(const mcv_picture *picture, char **json, mcv_error *error) {
    json_t *object = mcv_attributes_json(&picture->exr);
    *json = object ? json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(object);
    return *json ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for the attributes");
}

mcv_result mcv_picture_attributes(const mcv_picture *picture, char **json, mcv_error *error) {
    mcv_result result;
    MCV_NEED(json);
    *json = NULL;
    MCV_NEED(picture);
    MCV_INSIDE(result, list_attributes(picture, json, error));
    return result;
}
