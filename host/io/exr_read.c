/* SPDX-License-Identifier: Apache-2.0 */
/* Reads OpenEXR files whose header and chunk tables hold (io/exr_header.h). */
#include "io/exr_decode.h"
#include "io/exr_header.h"

#include "core/memory_limit.h"
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

/* Loads a file and reads its header; both are the caller's after success. */
static mcv_result load(const char *path, uint8_t **bytes, size_t *size, mcv_exr_header *header,
                       mcv_error *error) {
    MCV_TRY(mcv_file_load(path, bytes, size, error));
    const mcv_result result = mcv_exr_header_read(path, *bytes, *size, header, error);
    if (result != MCV_OK) free(*bytes);
    return result;
}

static uint64_t pixels_of(const mcv_exr_header *header) {
    return (uint64_t)header->parts[0].width * header->parts[0].height;
}

static mcv_result read_pixels(const char *path, uint8_t *bytes, size_t size,
                              const mcv_exr_header *header, mcv_exr *exr, mcv_error *error) {
    exr->parts = calloc(header->part_count, sizeof *exr->parts);
    if (!exr->parts) return mcv_fail(error, MCV_FAILED, "%s: no memory for its parts", path);
    for (uint32_t p = 0; p < header->part_count; ++p) {
        exr->part_count = p + 1;
        MCV_TRY(make_part(&header->parts[p], &exr->parts[p], error));
    }
    mcv_exr_simplify(bytes, size, header);
    MCV_TRY(mcv_exr_decode(path, bytes, size, exr, error));
    const double shared = mcv_exr_channel_correlation(exr);
    if (shared >= -1 && shared <= 1) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT, "%s: %s is %g; it must be -1 to 1", path,
                    MCV_EXR_CHANNELS, shared);
}

static mcv_result read_file(const char *path, bool counted, mcv_exr *exr, mcv_error *error) {
    uint8_t *bytes;
    size_t size;
    mcv_exr_header header;
    mcv_result result = MCV_OK;
    *exr = (mcv_exr){0};
    MCV_TRY(load(path, &bytes, &size, &header, error));
    if (!counted)
        result = mcv_memory_check_image(path, pixels_of(&header),
                                        size + mcv_exr_reading_bytes(&header), error);
    /* The attributes change owners. */
    exr->attributes = header.attributes;
    exr->attribute_count = header.attribute_count;
    header.attributes = NULL;
    header.attribute_count = 0;
    if (result == MCV_OK) result = read_pixels(path, bytes, size, &header, exr, error);
    mcv_exr_header_free(&header);
    free(bytes);
    if (result != MCV_OK) mcv_exr_free(exr);
    return result;
}

mcv_result mcv_exr_read(const char *path, mcv_exr *exr, mcv_error *error) {
    return read_file(path, false, exr, error);
}

mcv_result mcv_exr_read_counted(const char *path, mcv_exr *exr, mcv_error *error) {
    return read_file(path, true, exr, error);
}

mcv_result mcv_exr_size(const char *path, uint64_t *pixels, uint64_t *reading, mcv_error *error) {
    uint8_t *bytes;
    size_t size;
    mcv_exr_header header;
    MCV_TRY(load(path, &bytes, &size, &header, error));
    free(bytes);
    *pixels = pixels_of(&header);
    *reading = mcv_exr_reading_bytes(&header);
    mcv_exr_header_free(&header);
    return MCV_OK;
}
