/* SPDX-License-Identifier: Apache-2.0 */
#include "io/exr.h"
#include "io/exr_header.h"
#include "core/output_file.h"

#include <openexr.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What the library's callbacks work on: an output file, or a whole file in memory. */
typedef struct stream {
    const char *path;
    mcv_output *output;
    const uint8_t *bytes;
    size_t size;
    mcv_error *error;
    char message[512]; /* the library's last one */
    mcv_result result; /* of mcv_output_write_at, which knows more than the library */
} stream;

static void on_error(exr_const_context_t context, exr_result_t code, const char *message) {
    void *user = NULL;
    (void)code;
    if (exr_get_user_data(context, &user) == EXR_ERR_SUCCESS && user) {
        stream *s = user;
        snprintf(s->message, sizeof s->message, "%s", message);
    }
}

static int64_t on_write(exr_const_context_t context, void *user, const void *bytes, uint64_t count,
                        uint64_t offset, exr_stream_error_func_ptr_t report) {
    stream *s = user;
    (void)context;
    (void)report;
    s->result = mcv_output_write_at(s->output, bytes, (size_t)count, offset, s->error);
    return s->result == MCV_OK ? (int64_t)count : -1;
}

static int64_t on_read(exr_const_context_t context, void *user, void *bytes, uint64_t count,
                       uint64_t offset, exr_stream_error_func_ptr_t report) {
    const stream *s = user;
    (void)context;
    (void)report;
    if (offset >= s->size) return 0;
    if (count > s->size - offset) count = s->size - offset;
    memcpy(bytes, s->bytes + offset, count);
    return (int64_t)count;
}

static int64_t on_size(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const stream *)user)->size;
}

/* Turns a failed call into the sentence for the user; what our own callback has written stands. */
static mcv_result failed(stream *s, mcv_result code, exr_result_t result) {
    if (s->result != MCV_OK) return s->result;
    return mcv_fail(s->error, code, "%s: %s: %s", s->path,
                    s->output ? "OpenEXR cannot write it" : "damaged OpenEXR file",
                    s->message[0] ? s->message : exr_get_default_error_message(result));
}

#define TRY_EXR(call) \
    do { \
        const exr_result_t try_result = (call); \
        if (try_result != EXR_ERR_SUCCESS) return try_result; \
    } while (0)

/* The standard attributes that OpenEXR defines as float, v2f or m44f. */
static bool is_float_attribute(const char *name) {
    static const char *const names[] = {
        "expTime",
        "isoSpeed",
        "aperture",
        "tStop",
        "focus",
        "xDensity",
        "whiteLuminance",
        "nominalFocalLength",
        "pinholeFocalLength",
        "effectiveFocalLength",
        "sensorOverallDimensions",
        "sensorCenterOffset",
        "sensorPhotositePitch",
        "worldToCamera",
        "worldToNDC",
    };
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strcmp(names[i], name) == 0) return true;
    }
    return false;
}

static exr_result_t put_attribute(exr_context_t context, const mcv_attribute *a) {
    if (a->text) return exr_attr_set_string(context, 0, a->name, a->text);
    const bool single = is_float_attribute(a->name);
    const double *d = a->numbers;
    if (a->count == 1) {
        return single ? exr_attr_set_float(context, 0, a->name, (float)d[0])
                      : exr_attr_set_double(context, 0, a->name, d[0]);
    }
    if (a->count == 2) {
        const exr_attr_v2f_t v2f = {{{(float)d[0], (float)d[1]}}};
        const exr_attr_v2d_t v2d = {{{d[0], d[1]}}};
        return single ? exr_attr_set_v2f(context, 0, a->name, &v2f)
                      : exr_attr_set_v2d(context, 0, a->name, &v2d);
    }
    if (a->count == 4) { /* there is no vector of double */
        const float numbers[4] = {(float)d[0], (float)d[1], (float)d[2], (float)d[3]};
        return exr_attr_set_float_vector(context, 0, a->name, 4, numbers);
    }
    exr_attr_m44f_t m44f;
    exr_attr_m44d_t m44d;
    for (int i = 0; i < 16; ++i) {
        m44f.m[i] = (float)d[i];
        m44d.m[i] = d[i];
    }
    return single ? exr_attr_set_m44f(context, 0, a->name, &m44f)
                  : exr_attr_set_m44d(context, 0, a->name, &m44d);
}

static const char *channel_name(const mcv_exr_part *part, uint32_t channel) {
    if (part->channel_names) return part->channel_names[channel];
    if (part->image.channels == 1) return "Y";
    return channel == 0 ? "R" : channel == 1 ? "G" : "B";
}

static exr_result_t put_part(exr_context_t context, const mcv_exr_part *part) {
    int index;
    TRY_EXR(exr_add_part(context, part->name, EXR_STORAGE_SCANLINE, &index));
    TRY_EXR(exr_initialize_required_attr_simple(context, index, (int32_t)part->image.width,
                                                (int32_t)part->image.height, EXR_COMPRESSION_ZIP));
    for (uint32_t c = 0; c < part->image.channels; ++c) {
        TRY_EXR(exr_add_channel(context, index, channel_name(part, c), EXR_PIXEL_FLOAT,
                                EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    }
    return EXR_ERR_SUCCESS;
}

/* The plane of the channel of this name. */
static float *find_plane(const mcv_exr_part *part, const char *name) {
    for (uint32_t c = 0; c < part->image.channels; ++c) {
        if (strcmp(channel_name(part, c), name) == 0) {
            return part->image.pixels + (size_t)c * part->image.width * part->image.height;
        }
    }
    return NULL;
}

/* Points the library's channels at row `row` of the planes. The library sorts channels by name:
 * they are found by it. */
static bool attach_planes(exr_coding_channel_info_t *channels, int count, const mcv_exr_part *part,
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

/* OpenEXR's own compression, which compress_chunk calls. */
typedef exr_result_t compressor(exr_encode_pipeline_t *pipeline);

/*
 * Readers take a chunk for uncompressed when it is as long as that. OpenEXR 3.1 stores the
 * compressed bytes even if they are exactly as many, and so loses the chunk: then the plain ones
 * belong there.
 */
static exr_result_t compress_chunk(exr_encode_pipeline_t *pipeline) {
    TRY_EXR((*(compressor *const *)pipeline->encoding_user_data)(pipeline));
    if (pipeline->compressed_bytes == pipeline->packed_bytes &&
        pipeline->compressed_buffer != pipeline->packed_buffer)
        memcpy(pipeline->compressed_buffer, pipeline->packed_buffer, pipeline->packed_bytes);
    return EXR_ERR_SUCCESS;
}

static exr_result_t encode_part(exr_context_t context, int index, const mcv_exr_part *part) {
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t result = EXR_ERR_SUCCESS;
    compressor *compress = NULL;
    int32_t lines = 0;
    TRY_EXR(exr_get_scanlines_per_chunk(context, index, &lines));
    for (uint32_t row = 0; row < part->image.height && result == EXR_ERR_SUCCESS;
         row += (uint32_t)lines) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(context, index, (int)row, &chunk);
        if (result != EXR_ERR_SUCCESS) break;
        result = row == 0 ? exr_encoding_initialize(context, index, &chunk, &pipeline)
                          : exr_encoding_update(context, index, &chunk, &pipeline);
        if (result != EXR_ERR_SUCCESS) break;
        if (!attach_planes(pipeline.channels, pipeline.channel_count, part, row))
            result = EXR_ERR_INVALID_ARGUMENT;
        if (result == EXR_ERR_SUCCESS && row == 0) {
            result = exr_encoding_choose_default_routines(context, index, &pipeline);
            compress = pipeline.compress_fn;
            pipeline.encoding_user_data = &compress;
            if (compress) pipeline.compress_fn = compress_chunk;
        }
        if (result == EXR_ERR_SUCCESS) result = exr_encoding_run(context, index, &pipeline);
    }
    exr_encoding_destroy(context, &pipeline);
    return result;
}

static exr_result_t encode(exr_context_t context, const mcv_exr_part *parts, uint32_t part_count,
                           const mcv_attribute *attributes, uint32_t attribute_count) {
    for (uint32_t p = 0; p < part_count; ++p) TRY_EXR(put_part(context, &parts[p]));
    for (uint32_t a = 0; a < attribute_count; ++a) TRY_EXR(put_attribute(context, &attributes[a]));
    TRY_EXR(exr_write_header(context));
    for (uint32_t p = 0; p < part_count; ++p) TRY_EXR(encode_part(context, (int)p, &parts[p]));
    return EXR_ERR_SUCCESS;
}

static mcv_result check_arguments(const char *path, const mcv_exr_part *parts, uint32_t part_count,
                                  const mcv_attribute *attributes, uint32_t attribute_count,
                                  mcv_error *error) {
    if (part_count < 1 || part_count > MCV_EXR_MAX_PARTS) {
        return mcv_fail(error, MCV_FAILED,
                        "%s: an OpenEXR file of %u parts; 1 to %d can be written", path, part_count,
                        MCV_EXR_MAX_PARTS);
    }
    for (uint32_t p = 0; p < part_count; ++p) {
        const mcv_image *image = &parts[p].image;
        if (image->width > MCV_EXR_MAX_SIDE || image->height > MCV_EXR_MAX_SIDE ||
            image->channels > MCV_EXR_MAX_CHANNELS) {
            return mcv_fail(
                error, MCV_FAILED,
                "%s: part %s of %u x %u pixels, %u channels; at most %d x %d, %d can be written",
                path, parts[p].name, image->width, image->height, image->channels, MCV_EXR_MAX_SIDE,
                MCV_EXR_MAX_SIDE, MCV_EXR_MAX_CHANNELS);
        }
        for (uint32_t q = 0; q < p; ++q) {
            if (strcmp(parts[p].name, parts[q].name) == 0) {
                return mcv_fail(error, MCV_FAILED,
                                "%s: two parts are named %s; each needs its own name", path,
                                parts[p].name);
            }
        }
        if (!parts[p].channel_names && image->channels != 1 && image->channels != 3) {
            return mcv_fail(
                error, MCV_FAILED,
                "%s: part %s has %u channels without names; only 1 and 3 have some by themselves",
                path, parts[p].name, image->channels);
        }
    }
    for (uint32_t a = 0; a < attribute_count; ++a) {
        const mcv_attribute *attribute = &attributes[a];
        const size_t length = strlen(attribute->name);
        if (length == 0 || length >= MCV_EXR_ATTRIBUTE_NAME) {
            return mcv_fail(error, MCV_FAILED,
                            "%s: attribute `%s`: its name must have 1 to %d bytes", path,
                            attribute->name, MCV_EXR_ATTRIBUTE_NAME - 1);
        }
        if (!attribute->text && attribute->count != 1 && attribute->count != 2 &&
            attribute->count != 4 && attribute->count != 16) {
            return mcv_fail(error, MCV_FAILED,
                            "%s: attribute `%s` has %u numbers; 1, 2, 4 or 16 can be written", path,
                            attribute->name, attribute->count);
        }
    }
    return MCV_OK;
}

mcv_result mcv_exr_write(const char *path, const mcv_exr_part *parts, uint32_t part_count,
                         const mcv_attribute *attributes, uint32_t attribute_count,
                         mcv_error *error) {
    MCV_TRY(check_arguments(path, parts, part_count, attributes, attribute_count, error));
    mcv_output output;
    MCV_TRY(mcv_output_open(&output, path, error));
    stream s = {.path = path, .output = &output, .error = error};
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.error_handler_fn = on_error;
    initializer.user_data = &s;
    initializer.write_fn = on_write;
    initializer.zip_level = 1; /* noise: level 4, the usual one, takes longer for hardly less */
    exr_context_t context = NULL;
    exr_result_t result = exr_start_write(&context, path, EXR_WRITE_FILE_DIRECTLY, &initializer);
    if (result == EXR_ERR_SUCCESS)
        result = encode(context, parts, part_count, attributes, attribute_count);
    /* The table of chunks is written by exr_finish. */
    const exr_result_t finished = context ? exr_finish(&context) : EXR_ERR_SUCCESS;
    if (result == EXR_ERR_SUCCESS) result = finished;
    if (result != EXR_ERR_SUCCESS || s.result != MCV_OK) {
        mcv_output_discard(&output);
        return failed(&s, MCV_FAILED, result);
    }
    return mcv_output_commit(&output, error);
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
        if (!attach_planes(pipeline.channels, pipeline.channel_count, part, row))
            result = EXR_ERR_INVALID_ARGUMENT;
        if (result == EXR_ERR_SUCCESS && row == 0)
            result = exr_decoding_choose_default_routines(context, index, &pipeline);
        if (result == EXR_ERR_SUCCESS) result = exr_decoding_run(context, index, &pipeline);
    }
    exr_decoding_destroy(context, &pipeline);
    return result;
}

static mcv_result decode(stream *s, const mcv_exr_header *header, mcv_exr *exr) {
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.error_handler_fn = on_error;
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
    return result == EXR_ERR_SUCCESS ? MCV_OK : failed(s, MCV_BAD_INPUT, result);
}

mcv_result mcv_exr_read(const char *path, mcv_exr *exr, mcv_error *error) {
    *exr = (mcv_exr){0};
    stream s = {.path = path, .error = error};
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
