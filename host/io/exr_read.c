/* SPDX-License-Identifier: Apache-2.0 */
/* Reads OpenEXR files whose header and chunk tables hold (io/exr_header.h). */
#include "io/exr_decode.h"
#include "io/exr_header.h"

#include "core/output_file.h"

#include <stdlib.h>
#include <string.h>

/* Makes the part's empty image; R, G, B come first where all three are there. */
static mcv_result make_part(const mcv_exr_part_header *header, mcv_exr_part *part,
                            mcv_error *error) {
    static const char *const rgb[] = {"R", "G", "B"};
    MCV_TRY(
        mcv_image_new(&part->image, header->width, header->height, header->channel_count, error));
    part->name = strdup(header->name);
    part->channel_names = calloc(header->channel_count, sizeof *part->channel_names);
    if (!part->name || !part->channel_names)
        return mcv_fail(error, MCV_FAILED, "no memory for the names of %u channels",
                        header->channel_count);

    bool placed[MCV_EXR_MAX_CHANNELS] = {false};
    uint32_t order[MCV_EXR_MAX_CHANNELS] = {0}, count = 0;
    for (int k = 0; k < 3; ++k) {
        for (uint32_t c = 0; c < header->channel_count; ++c) {
            if (strcmp(header->channels[c].name, rgb[k]) == 0) order[count++] = c;
        }
    }
    if (count < 3) count = 0;
    for (uint32_t i = 0; i < count; ++i) placed[order[i]] = true;
    for (uint32_t c = 0; c < header->channel_count; ++c) {
        if (!placed[c]) order[count++] = c;
    }
    for (uint32_t i = 0; i < count; ++i) {
        part->channel_names[i] = strdup(header->channels[order[i]].name);
        if (!part->channel_names[i])
            return mcv_fail(error, MCV_FAILED, "no memory for the name of a channel");
    }
    return MCV_OK;
}

mcv_result mcv_exr_read(const char *path, mcv_exr *exr, mcv_error *error) {
    *exr = (mcv_exr){0};
    uint8_t *bytes;
    size_t size;
    MCV_TRY(mcv_file_load(path, &bytes, &size, error));
    mcv_exr_header header;
    mcv_result result = mcv_exr_header_read(path, bytes, size, &header, error);
    if (result == MCV_OK) {
        exr->parts = calloc(header.part_count, sizeof *exr->parts);
        if (!exr->parts) result = mcv_fail(error, MCV_FAILED, "%s: no memory for its parts", path);
        for (uint32_t p = 0; exr->parts && p < header.part_count && result == MCV_OK; ++p) {
            exr->part_count = p + 1;
            result = make_part(&header.parts[p], &exr->parts[p], error);
        }
        mcv_exr_hide_attributes(bytes, size);
        if (result == MCV_OK) result = mcv_exr_decode(path, bytes, size, exr, error);
        /* The attributes change owners. */
        exr->attributes = header.attributes;
        exr->attribute_count = header.attribute_count;
        header.attributes = NULL;
        header.attribute_count = 0;
        mcv_exr_header_free(&header);
        const double shared = mcv_exr_channel_correlation(exr);
        if (result == MCV_OK && !(shared >= -1 && shared <= 1))
            result = mcv_fail(error, MCV_BAD_INPUT, "%s: %s is %g; it must be -1 to 1", path,
                              MCV_EXR_CHANNELS, shared);
    }
    free(bytes);
    if (result != MCV_OK) mcv_exr_free(exr);
    return result;
}

mcv_result mcv_exr_size(const char *path, uint64_t *values, uint64_t *pixels, mcv_error *error) {
    uint8_t *bytes;
    size_t size;
    mcv_exr_header header;
    MCV_TRY(mcv_file_load(path, &bytes, &size, error));
    const mcv_result result = mcv_exr_header_read(path, bytes, size, &header, error);
    free(bytes);
    MCV_TRY(result);
    *values = 0;
    *pixels = (uint64_t)header.parts[0].width * header.parts[0].height;
    for (uint32_t p = 0; p < header.part_count; ++p)
        *values += (uint64_t)header.parts[p].width * header.parts[p].height *
                   header.parts[p].channel_count;
    mcv_exr_header_free(&header);
    return MCV_OK;
}
