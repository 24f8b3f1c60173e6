/* SPDX-License-Identifier: Apache-2.0 */
#include "io/exr_make.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static mcv_result fail_memory(mcv_error *error) {
    return mcv_fail(error, MCV_FAILED, "no memory for the picture");
}

static char *copy_channel_name(const char *const *names, uint32_t channel, uint32_t count) {
    static const char *const colours[] = {"R", "G", "B"};
    char number[16];
    if (names) return strdup(names[channel]);
    if (count == 1) return strdup("Y");
    if (count == 3) return strdup(colours[channel]);
    snprintf(number, sizeof number, "%u", channel);
    return strdup(number);
}

mcv_result mcv_exr_add_part(mcv_exr *exr, const char *name, mcv_image image,
                            const char *const *channel_names, mcv_error *error) {
    mcv_exr_part *parts = realloc(exr->parts, (exr->part_count + 1) * sizeof *parts);
    if (!parts) {
        mcv_image_free(&image);
        return fail_memory(error);
    }
    exr->parts = parts;
    mcv_exr_part *part = parts + exr->part_count++;
    *part = (mcv_exr_part){.name = strdup(name),
                           .image = image,
                           .channel_names = calloc(image.channels, sizeof *part->channel_names)};
    if (!part->name || !part->channel_names) return fail_memory(error);
    for (uint32_t c = 0; c < image.channels; ++c) {
        part->channel_names[c] = copy_channel_name(channel_names, c, image.channels);
        if (!part->channel_names[c]) return fail_memory(error);
    }
    return MCV_OK;
}

static mcv_attribute *find(const mcv_exr *exr, const char *name) {
    for (uint32_t i = 0; i < exr->attribute_count; ++i)
        if (strcmp(exr->attributes[i].name, name) == 0) return exr->attributes + i;
    return NULL;
}

static mcv_result set_attribute(mcv_exr *exr, const mcv_attribute *a, mcv_error *error) {
    char *text = a->text ? strdup(a->text) : NULL;
    mcv_attribute *to = find(exr, a->name);
    if (a->text && !text) return fail_memory(error);
    if (!to) {
        mcv_attribute *attributes =
            realloc(exr->attributes, (exr->attribute_count + 1) * sizeof *attributes);
        if (attributes) exr->attributes = attributes;
        char *name = attributes ? strdup(a->name) : NULL;
        if (!name) {
            free(text);
            return fail_memory(error);
        }
        to = attributes + exr->attribute_count++;
        *to = (mcv_attribute){.name = name};
    }
    free((void *)to->text);
    const char *name = to->name;
    *to = *a;
    to->name = name;
    to->text = text;
    return MCV_OK;
}

mcv_result mcv_exr_set_attributes(mcv_exr *exr, const mcv_attribute *attributes, uint32_t count,
                                  mcv_error *error) {
    for (uint32_t i = 0; i < count; ++i) MCV_TRY(set_attribute(exr, attributes + i, error));
    return MCV_OK;
}

mcv_result mcv_image_copy(const mcv_image *image, mcv_image *copy, mcv_error *error) {
    const size_t count = (size_t)image->width * image->height * image->channels;
    MCV_TRY(mcv_image_new(copy, image->width, image->height, image->channels, error));
    memcpy(copy->pixels, image->pixels, count * sizeof *copy->pixels);
    copy->description = image->description ? strdup(image->description) : NULL;
    if (!image->description || copy->description) return MCV_OK;
    mcv_image_free(copy);
    return fail_memory(error);
}

static mcv_result copy_parts(const mcv_exr *exr, mcv_exr *copy, mcv_error *error) {
    for (uint32_t p = 0; p < exr->part_count; ++p) {
        mcv_image image;
        MCV_TRY(mcv_image_copy(&exr->parts[p].image, &image, error));
        MCV_TRY(
            mcv_exr_add_part(copy, exr->parts[p].name, image, exr->parts[p].channel_names, error));
    }
    return mcv_exr_set_attributes(copy, exr->attributes, exr->attribute_count, error);
}

mcv_result mcv_exr_copy(const mcv_exr *exr, mcv_exr *copy, mcv_error *error) {
    *copy = (mcv_exr){0};
    const mcv_result result = copy_parts(exr, copy, error);
    if (result != MCV_OK) mcv_exr_free(copy);
    return result;
}
