/* SPDX-License-Identifier: Apache-2.0 */
#include "loader/validate.h"

#include "loader/data_uri.h"

#include "mcvisi/dialect.h"

#include <stdlib.h>

/* A relative URI is checked without being opened. */
static mcv_result check_uri(const char *uri, const mcv_json_path *place, mcv_error *error) {
    const mcv_json_path *file = place;
    while (file->parent) file = file->parent;
    char *path;
    const mcv_result result = mcv_file_resolve(file->key, uri, &path, place, error);
    free(path);
    return result;
}

bool mcv_buffer_is_chunk(const json_t *root, const json_t *buffer, mcv_bytes binary) {
    return binary.data && !json_object_get(buffer, "uri") &&
           buffer == json_array_get(json_object_get(root, "buffers"), 0);
}

static mcv_result check_buffer(const json_t *root, const json_t *buffer, mcv_bytes binary,
                               const mcv_json_path *place, mcv_error *error) {
    uint64_t length = 0, available = 0;
    const char *uri = NULL;
    const mcv_json_path here = mcv_json_path_key(place, "uri");
    MCV_TRY(mcv_json_uint(buffer, "byteLength", 1, 1ull << 53, &length, place, error));
    MCV_TRY(mcv_json_string(buffer, "uri", &uri, place, error));
    if (length == 0) return mcv_fail_at(place, error, "must have a byteLength");
    if (uri && strncmp(uri, "data:", 5) != 0) return check_uri(uri, &here, error);
    if (uri)
        MCV_TRY(mcv_data_uri_length(uri, mcv_buffer_types, &available, &here, error));
    else if (mcv_buffer_is_chunk(root, buffer, binary))
        available = binary.size;
    else /* declared without data, which matters to what reads it */
        available = length;
    if (length <= available) return MCV_OK;
    return mcv_fail_at(place, error, "byteLength %llu exceeds the %llu bytes of its data",
                       (unsigned long long)length, (unsigned long long)available);
}

static mcv_result check_view(const json_t *root, const json_t *view, mcv_bytes binary,
                             const mcv_json_path *place, mcv_error *error) {
    (void)binary;
    const json_t *buffers = json_object_get(root, "buffers");
    uint32_t buffer;
    uint64_t offset = 0, length = 0, stride = 0, size = 0;
    MCV_TRY(
        mcv_json_index(view, "buffer", json_array_size(buffers), "buffers", &buffer, place, error));
    MCV_TRY(mcv_json_uint(view, "byteOffset", 0, 1ull << 53, &offset, place, error));
    MCV_TRY(mcv_json_uint(view, "byteLength", 1, 1ull << 53, &length, place, error));
    MCV_TRY(mcv_json_uint(view, "byteStride", 4, 252, &stride, place, error));
    if (buffer == MCV_NONE || length == 0)
        return mcv_fail_at(place, error, "must have a buffer and a byteLength");
    if (stride % 4 != 0)
        return mcv_fail_at(place, error, "byteStride %u must be a multiple of 4", (unsigned)stride);
    if (stride > length)
        return mcv_fail_at(place, error, "byteStride %u exceeds its byteLength", (unsigned)stride);
    MCV_TRY(mcv_json_uint(json_array_get(buffers, buffer), "byteLength", 1, 1ull << 53, &size,
                          place, error));
    if (offset <= size && length <= size - offset) return MCV_OK;
    return mcv_fail_at(
        place, error, "%llu bytes from byte %llu on exceed the %llu bytes of buffer %u",
        (unsigned long long)length, (unsigned long long)offset, (unsigned long long)size, buffer);
}

static mcv_result check_image(const json_t *root, const json_t *image, mcv_bytes binary,
                              const mcv_json_path *place, mcv_error *error) {
    (void)binary;
    static const char *const types[] = {"image/png", "image/jpeg", "image/webp", "image/ktx2",
                                        NULL};
    const char *uri = NULL, *mime = NULL;
    uint32_t view;
    uint64_t length;
    const mcv_json_path here = mcv_json_path_key(place, "uri");
    MCV_TRY(mcv_json_string(image, "uri", &uri, place, error));
    MCV_TRY(mcv_json_string(image, "mimeType", &mime, place, error));
    MCV_TRY(mcv_json_index(image, "bufferView",
                           json_array_size(json_object_get(root, "bufferViews")), "bufferViews",
                           &view, place, error));
    if (!uri == (view == MCV_NONE))
        return mcv_fail_at(place, error, "must have either a uri or a bufferView");
    if (!uri)
        return mime ? MCV_OK : mcv_fail_at(place, error, "in a bufferView must have a mimeType");
    if (strncmp(uri, "data:", 5) == 0)
        return mcv_data_uri_length(uri, types, &length, &here, error);
    return check_uri(uri, &here, error);
}

mcv_result mcv_validate_buffers(const json_t *root, mcv_bytes binary, const mcv_json_path *file,
                                mcv_error *error) {
    MCV_TRY(mcv_validate_each(root, "buffers", check_buffer, binary, file, error));
    MCV_TRY(mcv_validate_each(root, "bufferViews", check_view, binary, file, error));
    return mcv_validate_each(root, "images", check_image, binary, file, error);
}
