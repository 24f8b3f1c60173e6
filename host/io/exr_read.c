/* SPDX-License-Identifier: Apache-2.0 */
/* Reads OpenEXR files whose header and chunk tables hold (io/exr_header.h). */
#include "io/exr_stream.h"

#include "io/exr_header.h"

#include <stdlib.h>
#include <string.h>

static int64_t on_read(exr_const_context_t context, void *user, void *bytes, uint64_t count,
                       uint64_t offset, exr_stream_error_func_ptr_t report) {
    const mcv_exr_stream *s = user;
    (void)context;
    (void)report;
    if (offset >= s->size) return 0;
    if (count > s->size - offset) count = s->size - offset;
    memcpy(bytes, s->bytes + offset, count);
    return (int64_t)count;
}

static int64_t on_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const mcv_exr_stream *)user)->size;
}

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

static exr_result_t decode_part(exr_context_t context, int index, const mcv_exr_part_header *header,
                                const mcv_exr_part *part) {
    exr_decode_pipeline_t pipeline = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t result = EXR_ERR_SUCCESS;
    const uint32_t lines = mcv_exr_lines_per_chunk(header->compression);
    for (uint32_t row = 0; row < header->height && result == EXR_ERR_SUCCESS; row += lines) {
        exr_chunk_info_t chunk;
        result = exr_read_scanline_chunk_info(context, index, header->y_min + (int)row, &chunk);
        if (result != EXR_ERR_SUCCESS) break;
        result = row == 0 ? exr_decoding_initialize(context, index, &chunk, &pipeline)
                          : exr_decoding_update(context, index, &chunk, &pipeline);
        if (result != EXR_ERR_SUCCESS) break;
        if (!mcv_exr_attach_planes(pipeline.channels, pipeline.channel_count, part, row))
            result = EXR_ERR_INVALID_ARGUMENT;
        if (result == EXR_ERR_SUCCESS && row == 0)
            result = exr_decoding_choose_default_routines(context, index, &pipeline);
        if (result == EXR_ERR_SUCCESS) result = exr_decoding_run(context, index, &pipeline);
    }
    exr_decoding_destroy(context, &pipeline);
    return result;
}

static mcv_result decode(mcv_exr_stream *s, const mcv_exr_header *header, mcv_exr *exr) {
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.error_handler_fn = mcv_exr_on_error;
    initializer.user_data = s;
    initializer.read_fn = on_read;
    initializer.size_fn = on_size;
    initializer.max_image_width = MCV_EXR_MAX_SIDE;
    initializer.max_image_height = MCV_EXR_MAX_SIDE;
    exr_context_t context = NULL;
    exr_result_t result = exr_start_read(&context, s->path, &initializer);
    int count = 0;
    if (result == EXR_ERR_SUCCESS) result = exr_get_count(context, &count);
    if (result == EXR_ERR_SUCCESS && (uint32_t)count != header->part_count)
        result = EXR_ERR_FILE_BAD_HEADER;
    for (int p = 0; p < count && result == EXR_ERR_SUCCESS; ++p)
        result = decode_part(context, p, &header->parts[p], &exr->parts[p]);
    if (context) exr_finish(&context);
    return result == EXR_ERR_SUCCESS ? MCV_OK : mcv_exr_failed(s, MCV_BAD_INPUT, result);
}

mcv_result mcv_exr_read(const char *path, mcv_exr *exr, mcv_error *error) {
    *exr = (mcv_exr){0};
    mcv_exr_stream s = {.path = path, .error = error};
    uint8_t *bytes;
    MCV_TRY(mcv_file_load(path, &bytes, &s.size, error));
    s.bytes = bytes;
    mcv_exr_header header;
    mcv_result result = mcv_exr_header_read(path, bytes, s.size, &header, error);
    if (result == MCV_OK) {
        exr->parts = calloc(header.part_count, sizeof *exr->parts);
        if (!exr->parts) result = mcv_fail(error, MCV_FAILED, "%s: no memory for its parts", path);
        for (uint32_t p = 0; exr->parts && p < header.part_count && result == MCV_OK; ++p) {
            exr->part_count = p + 1;
            result = make_part(&header.parts[p], &exr->parts[p], error);
        }
        if (result == MCV_OK) result = decode(&s, &header, exr);
        /* The attributes change owners. */
        exr->attributes = header.attributes;
        exr->attribute_count = header.attribute_count;
        header.attributes = NULL;
        header.attribute_count = 0;
        mcv_exr_header_free(&header);
    }
    free(bytes);
    if (result != MCV_OK) mcv_exr_free(exr);
    return result;
}
