/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR files in memory: their attributes, images and errors. */
#include "io/exr_stream.h"

#include "io/exr_header.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void mcv_exr_on_error(exr_const_context_t context, exr_result_t code, const char *message) {
    void *user = NULL;
    (void)code;
    if (exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user) {
        mcv_exr_stream *s = user;
        snprintf(s->message, sizeof s->message, "%s", message);
    }
}

mcv_result mcv_exr_failed(mcv_exr_stream *s, mcv_result code, exr_result_t result) {
    if (s->result != MCV_OK) return s->result;
    return mcv_fail(s->error, code, "%s: %s: %s", s->path,
                    s->output ? "OpenEXR cannot write it" : "damaged OpenEXR file",
                    s->message[0] ? s->message : exr_get_default_error_message(result));
}

const char *mcv_exr_channel_name(const mcv_exr_part *part, uint32_t channel) {
    if (part->channel_names) return part->channel_names[channel];
    if (part->image.channels == 1) return "Y";
    return channel == 0 ? "R" : channel == 1 ? "G" : "B";
}

/* The plane of the channel of this name. */
static float *find_plane(const mcv_exr_part *part, const char *name) {
    for (uint32_t c = 0; c < part->image.channels; ++c) {
        if (strcmp(mcv_exr_channel_name(part, c), name) == 0) {
            return part->image.pixels + (size_t)c * part->image.width * part->image.height;
        }
    }
    return NULL;
}

bool mcv_exr_attach_planes(exr_coding_channel_info_t *channels, int count, const mcv_exr_part *part,
                           uint32_t row) {
    for (int i = 0; i < count; ++i) {
        float *plane = find_plane(part, channels[i].channel_name);
        if (!plane) return false;
        channels[i].user_pixel_stride = sizeof(float);
        channels[i].user_line_stride = (int32_t)(part->image.width * sizeof(float));
        channels[i].user_bytes_per_element = sizeof(float);
        channels[i].user_data_type = EXR_PIXEL_FLOAT;
        channels[i].decode_to_ptr = (uint8_t *)(plane + (size_t)row * part->image.width);
    }
    return true;
}

const mcv_attribute *mcv_exr_attribute(const mcv_exr *exr, const char *name) {
    for (uint32_t i = 0; i < exr->attribute_count; ++i) {
        if (strcmp(exr->attributes[i].name, name) == 0) return &exr->attributes[i];
    }
    return NULL;
}

const double *mcv_exr_numbers(const mcv_exr *exr, const char *name, uint32_t count) {
    const mcv_attribute *a = mcv_exr_attribute(exr, name);
    return a && !a->text && a->count == count ? a->numbers : NULL;
}

mcv_image *mcv_exr_image(const mcv_exr *exr, const char *name) {
    const mcv_image *image = &exr->parts[0].image;
    for (uint32_t i = 1; i < exr->part_count; ++i) {
        mcv_image *part = &exr->parts[i].image;
        if (strcmp(exr->parts[i].name, name) == 0 && part->width == image->width &&
            part->height == image->height && part->channels == image->channels)
            return part;
    }
    return NULL;
}

double mcv_exr_channel_correlation(const mcv_exr *exr) {
    const double *shared = mcv_exr_numbers(exr, MCV_EXR_CHANNELS, 1);
    return shared ? *shared : 1;
}

mcv_image *mcv_exr_error(const mcv_exr *exr) { return mcv_exr_image(exr, "error"); }

void mcv_exr_free(mcv_exr *exr) {
    for (uint32_t p = 0; p < exr->part_count; ++p) {
        mcv_exr_part *part = &exr->parts[p];
        for (uint32_t c = 0; part->channel_names && c < part->image.channels; ++c)
            free((void *)part->channel_names[c]);
        free(part->channel_names);
        free((void *)part->name);
        mcv_image_free(&part->image);
    }
    free(exr->parts);
    mcv_exr_header rest = {.attributes = exr->attributes, .attribute_count = exr->attribute_count};
    mcv_exr_header_free(&rest);
    *exr = (mcv_exr){0};
}
