/* SPDX-License-Identifier: Apache-2.0 */
/* Writes OpenEXR files of several parts. */
#include "io/exr_stream.h"

#include <stdlib.h>
#include <string.h>

static int64_t on_write(exr_const_context_t context, void *user, const void *bytes, uint64_t count,
                        uint64_t offset, exr_stream_error_func_ptr_t report) {
    mcv_exr_stream *s = user;
    (void)context;
    (void)report;
    s->result = mcv_output_write_at(s->output, bytes, (size_t)count, offset, s->error);
    return s->result == MCV_OK ? (int64_t)count : -1;
}

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

static exr_attr_box2i_t window_of(const mcv_image *image) {
    return (exr_attr_box2i_t){.max.x = (int32_t)image->width - 1,
                              .max.y = (int32_t)image->height - 1};
}

/* `first`: part 0, whose window is what all parts are shown in: the library wants them alike. */
static exr_result_t put_part(exr_context_t context, const mcv_exr_part *first,
                             const mcv_exr_part *part) {
    const exr_attr_box2i_t shown = window_of(&first->image), own = window_of(&part->image);
    const exr_attr_v2f_t centre = {.x = 0, .y = 0};
    int index;
    MCV_TRY_EXR(exr_add_part(context, part->name, EXR_STORAGE_SCANLINE, &index));
    MCV_TRY_EXR(exr_initialize_required_attr(context, index, &shown, &own, 1, &centre, 1,
                                             EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP));
    for (uint32_t c = 0; c < part->image.channels; ++c) {
        MCV_TRY_EXR(exr_add_channel(context, index, mcv_exr_channel_name(part, c), EXR_PIXEL_FLOAT,
                                    EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1));
    }
    return EXR_ERR_SUCCESS;
}

/* OpenEXR's own compression, which compress_chunk calls. */
typedef exr_result_t compressor(exr_encode_pipeline_t *pipeline);

/*
 * Readers take a chunk for uncompressed when it is as long as that. OpenEXR 3.1 stores the
 * compressed bytes even if they are exactly as many, and so loses the chunk: then the plain ones
 * belong there.
 */
static exr_result_t compress_chunk(exr_encode_pipeline_t *pipeline) {
    MCV_TRY_EXR((*(compressor *const *)pipeline->encoding_user_data)(pipeline));
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
    MCV_TRY_EXR(exr_get_scanlines_per_chunk(context, index, &lines));
    for (uint32_t row = 0; row < part->image.height && result == EXR_ERR_SUCCESS;
         row += (uint32_t)lines) {
        exr_chunk_info_t chunk;
        result = exr_write_scanline_chunk_info(context, index, (int)row, &chunk);
        if (result != EXR_ERR_SUCCESS) break;
        result = row == 0 ? exr_encoding_initialize(context, index, &chunk, &pipeline)
                          : exr_encoding_update(context, index, &chunk, &pipeline);
        if (result != EXR_ERR_SUCCESS) break;
        if (!mcv_exr_attach_planes(pipeline.channels, pipeline.channel_count, part, row))
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
    for (uint32_t p = 0; p < part_count; ++p) MCV_TRY_EXR(put_part(context, parts, &parts[p]));
    for (uint32_t a = 0; a < attribute_count; ++a)
        MCV_TRY_EXR(put_attribute(context, &attributes[a]));
    MCV_TRY_EXR(exr_write_header(context));
    for (uint32_t p = 0; p < part_count; ++p) MCV_TRY_EXR(encode_part(context, (int)p, &parts[p]));
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
                                "%s: two parts are named %s; each must have its own name", path,
                                parts[p].name);
            }
        }
        if (!parts[p].channel_names && image->channels != 1 && image->channels != 3) {
            return mcv_fail(
                error, MCV_FAILED,
                "%s: part %s has %u channels without names; only 1 and 3 have default names", path,
                parts[p].name, image->channels);
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

/* The library calls it while it holds the context, which its every question waits for. */
static void ignore_message(exr_const_context_t context, exr_result_t code, const char *message) {
    (void)context, (void)code, (void)message;
}

mcv_result mcv_exr_write(const char *path, const mcv_exr_part *parts, uint32_t part_count,
                         const mcv_attribute *attributes, uint32_t attribute_count,
                         mcv_error *error) {
    MCV_TRY(check_arguments(path, parts, part_count, attributes, attribute_count, error));
    mcv_output output;
    MCV_TRY(mcv_output_open(&output, path, error));
    mcv_exr_stream s = {.path = path, .output = &output, .error = error};
    exr_context_initializer_t initializer = EXR_DEFAULT_CONTEXT_INITIALIZER;
    initializer.error_handler_fn = ignore_message;
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
        return mcv_exr_failed(&s, MCV_FAILED, result);
    }
    return mcv_output_commit(&output, error);
}
