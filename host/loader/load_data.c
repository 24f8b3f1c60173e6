/* SPDX-License-Identifier: Apache-2.0 */
/* The data of a document: the parts of its buffers that are needed, and its images, each file
 * decoded once. All of it is counted before it is read or decoded. */
#include "loader/loader.h"

#include "loader/data_uri.h"
#include "loader/image.h"
#include "loader/validate.h"
#include "scene/memory.h"

#include <stdlib.h>
#include <string.h>

static const char *const image_types[] = {"image/png", "image/jpeg", "image/webp", "image/ktx2",
                                          NULL};

static bool is_data(const char *uri) { return strncmp(uri, "data:", 5) == 0; }

/* --- which part of each buffer is needed --- */

static void need(mcv_gltf *gltf, uint64_t buffer, uint64_t begin, uint64_t end) {
    mcv_gltf_part *part = &gltf->buffers[buffer];
    const uint64_t last = part->first + part->size;
    if (part->size == 0 || begin < part->first) part->first = begin;
    part->size = (part->size && last > end ? last : end) - part->first;
}

static void need_span(mcv_gltf *gltf, const mcv_buffer_span *span) {
    if (span->view != MCV_NONE) need(gltf, span->buffer, span->offset, span->end);
}

/* Adds the bytes that its elements take as floats or indices to *bytes. */
static mcv_result need_accessor(mcv_loader *loader, const json_t *object, const char *key,
                                uint64_t *bytes, const mcv_json_path *place, mcv_error *error) {
    mcv_accessor accessor;
    bool given;
    MCV_TRY(mcv_accessor_get(loader->root, object, key, &given, &accessor, place, error));
    if (!given) return MCV_OK;
    need_span(loader->gltf, &accessor.elements);
    if (accessor.sparse_count) need_span(loader->gltf, &accessor.sparse_indices);
    if (accessor.sparse_count) need_span(loader->gltf, &accessor.sparse_values);
    *bytes += 4 * accessor.count * accessor.components;
    return MCV_OK;
}

static mcv_result need_mesh(mcv_loader *loader, size_t index, mcv_error *error) {
    static const char *const keys[] = {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1"};
    const json_t *mesh = json_array_get(json_object_get(loader->root, "meshes"), index),
                 *primitives = json_object_get(mesh, "primitives");
    const mcv_json_path meshes = mcv_json_path_key(&loader->file, "meshes"),
                        place = mcv_json_path_element(&meshes, mcv_json_name(mesh), index);
    uint64_t bytes = 0;
    for (size_t i = 0; i < json_array_size(primitives); ++i) {
        const json_t *primitive = json_array_get(primitives, i),
                     *attributes = json_object_get(primitive, "attributes");
        for (size_t k = 0; k < sizeof keys / sizeof keys[0]; ++k)
            MCV_TRY(need_accessor(loader, attributes, keys[k], &bytes, &place, error));
        MCV_TRY(need_accessor(loader, primitive, "indices", &bytes, &place, error));
    }
    mcv_memory *memory = loader->memory;
    return mcv_memory_take(memory, &memory->geometry, bytes, &place, error);
}

/* Meshes that a node has, each once. */
static mcv_result need_meshes(mcv_loader *loader, mcv_error *error) {
    const json_t *nodes = json_object_get(loader->root, "nodes");
    const size_t count = json_array_size(json_object_get(loader->root, "meshes"));
    bool *seen = calloc(count + 1, sizeof *seen);
    if (!seen) return mcv_fail_memory(&loader->file, error);
    mcv_result result = MCV_OK;
    for (size_t i = 0; i < json_array_size(nodes) && result == MCV_OK; ++i) {
        const json_t *mesh = json_object_get(json_array_get(nodes, i), "mesh");
        const size_t index = mesh ? (size_t)json_number_value(mesh) : count;
        if (index < count && !seen[index]) result = need_mesh(loader, index, error);
        seen[index] = true;
    }
    free(seen);
    return result;
}

/* --- buffers --- */

static mcv_result read_file_part(mcv_loader *loader, const char *uri, uint64_t length,
                                 mcv_gltf_part *part, const mcv_json_path *place,
                                 mcv_error *error) {
    char *path;
    uint64_t size = 0;
    MCV_TRY(mcv_file_resolve(loader->file.key, uri, &path, place, error));
    mcv_result result = MCV_OK;
    if (loader->is_asset && loader->cache) result = mcv_stamp_add(loader, path, place, error);
    if (result == MCV_OK) result = mcv_file_size(path, &size, place, error);
    if (result == MCV_OK && size < length)
        result = mcv_fail_at(place, error, "\"%s\" has %llu bytes, but byteLength is %llu", uri,
                             (unsigned long long)size, (unsigned long long)length);
    if (result == MCV_OK && part->size)
        result = mcv_file_read_part(path, part->first, part->size, part->data, place, error);
    free(path);
    return result;
}

static mcv_result read_buffer(mcv_loader *loader, size_t index, mcv_error *error) {
    const mcv_json_path buffers = mcv_json_path_key(&loader->file, "buffers"),
                        here = mcv_place_index(&buffers, index),
                        place = mcv_json_path_key(&here, "uri");
    const json_t *object = json_array_get(json_object_get(loader->root, "buffers"), index);
    const char *uri = json_string_value(json_object_get(object, "uri"));
    const uint64_t length = (uint64_t)json_number_value(json_object_get(object, "byteLength"));
    mcv_gltf_part *part = &loader->gltf->buffers[index];
    mcv_memory *memory = loader->memory;
    const bool is_chunk = mcv_buffer_is_chunk(loader->root, object, loader->binary);
    if (!uri && !is_chunk) return MCV_OK; /* whatever needs it says that it has no data */
    if (part->size) {
        MCV_TRY(mcv_memory_take(memory, &memory->files, part->size, &here, error));
        part->data = malloc(part->size);
        if (!part->data) return mcv_fail_memory(&here, error);
    }
    if (uri && !is_data(uri)) {
        MCV_TRY(read_file_part(loader, uri, length, part, &place, error));
        if (part->size) mcv_load_count(loader, part->data, part->size);
    } else if (part->size && uri) {
        mcv_data_uri_decode(uri, part->first, part->size, part->data);
    } else if (part->size) {
        memcpy(part->data, loader->binary.data + part->first, part->size);
    }
    return MCV_OK;
}

/* --- images --- */

/* The view of an image as a part of its buffer, with the same rules as check_view's. */
static void view_of(const json_t *root, const json_t *image, size_t *buffer, uint64_t *first,
                    uint64_t *size) {
    const size_t index = (size_t)json_number_value(json_object_get(image, "bufferView"));
    const json_t *view = json_array_get(json_object_get(root, "bufferViews"), index);
    *buffer = (size_t)json_number_value(json_object_get(view, "buffer"));
    *first = (uint64_t)json_number_value(json_object_get(view, "byteOffset"));
    *size = (uint64_t)json_number_value(json_object_get(view, "byteLength"));
}

/* The file of an image; the caller frees file->data. */
static mcv_result read_image(mcv_loader *loader, const json_t *image, mcv_bytes *file,
                             const mcv_json_path *here, mcv_error *error) {
    const char *uri = json_string_value(json_object_get(image, "uri"));
    const mcv_json_path place = mcv_json_path_key(here, "uri");
    mcv_memory *memory = loader->memory;
    uint64_t first = 0, size = 0;
    size_t buffer = 0;
    if (uri && !is_data(uri)) {
        char *path;
        MCV_TRY(mcv_file_resolve(loader->file.key, uri, &path, &place, error));
        const mcv_result result = mcv_load_file(loader, path, file, &place, error);
        free(path);
        return result;
    }
    if (uri)
        MCV_TRY(mcv_data_uri_length(uri, image_types, &size, &place, error));
    else
        view_of(loader->root, image, &buffer, &first, &size);
    const uint8_t *data = uri ? NULL : mcv_gltf_bytes(loader->gltf, buffer, first, size);
    if (!uri && !data)
        return mcv_fail_at(here, error, "buffer %zu has no data: give it a uri", buffer);
    MCV_TRY(mcv_memory_take(memory, &memory->files, size, here, error));
    *file = (mcv_bytes){malloc(size), size};
    if (!file->data) return mcv_fail_memory(here, error);
    if (uri)
        mcv_data_uri_decode(uri, 0, size, file->data);
    else
        memcpy(file->data, data, size);
    return MCV_OK;
}

/* All are read and counted before the first is decoded. */
static mcv_result read_images(mcv_loader *loader, const uint32_t *sources, mcv_bytes *files,
                              mcv_error *error) {
    const json_t *images = json_object_get(loader->root, "images");
    const mcv_json_path place = mcv_json_path_key(&loader->file, "images");
    mcv_gltf *gltf = loader->gltf;
    mcv_memory *memory = loader->memory;
    for (size_t i = 0; i < gltf->picture_count; ++i) {
        const mcv_json_path here = mcv_place_index(&place, sources[i]);
        uint32_t width, height;
        MCV_TRY(read_image(loader, json_array_get(images, sources[i]), files + i, &here, error));
        MCV_TRY(mcv_image_size(files[i], &width, &height, &here, error));
        MCV_TRY(mcv_memory_take(memory, &memory->images, (uint64_t)MCV_PIXEL_BYTES * width * height,
                                &here, error));
    }
    for (size_t i = 0; i < gltf->picture_count; ++i) {
        const mcv_json_path here = mcv_place_index(&place, sources[i]);
        MCV_TRY(mcv_image_decode(files[i], &gltf->pictures[i], &here, error));
    }
    return MCV_OK;
}

static mcv_result open_images(mcv_loader *loader, mcv_error *error) {
    const size_t count = loader->gltf->picture_count,
                 images = json_array_size(json_object_get(loader->root, "images"));
    mcv_bytes *files = calloc(count + 1, sizeof *files);
    uint32_t *sources = calloc(count + 1, sizeof *sources);
    for (size_t i = images; sources && i-- > 0;) /* the first that has this picture */
        if (loader->images[i] != MCV_NONE) sources[loader->images[i]] = (uint32_t)i;
    const mcv_result result = files && sources ? read_images(loader, sources, files, error)
                                               : mcv_fail_memory(&loader->file, error);
    for (size_t i = 0; files && i < count; ++i) free(files[i].data);
    free(files);
    free(sources);
    return result;
}

/* Are two images one file? */
static bool is_same(const mcv_loader *loader, const json_t *a, const json_t *b) {
    const char *uris[] = {json_string_value(json_object_get(a, "uri")),
                          json_string_value(json_object_get(b, "uri"))};
    if (!uris[0] && !uris[1])
        return json_number_value(json_object_get(a, "bufferView")) ==
               json_number_value(json_object_get(b, "bufferView"));
    if (!uris[0] || !uris[1] || is_data(uris[0]) != is_data(uris[1])) return false;
    if (is_data(uris[0])) return strcmp(uris[0], uris[1]) == 0;
    return mcv_file_is_same(loader->file.key, uris[0], uris[1]);
}

void mcv_load_need_image(mcv_loader *loader, uint32_t source, uint32_t *count) {
    const json_t *images = json_object_get(loader->root, "images");
    const json_t *image = json_array_get(images, source);
    if (loader->images[source] != MCV_NONE) return;
    for (size_t i = 0; i < json_array_size(images); ++i)
        if (loader->images[i] != MCV_NONE && is_same(loader, image, json_array_get(images, i))) {
            loader->images[source] = loader->images[i];
            return;
        }
    loader->images[source] = (*count)++;
}

mcv_result mcv_load_data(mcv_loader *loader, uint32_t picture_count, mcv_error *error) {
    const json_t *images = json_object_get(loader->root, "images");
    const size_t buffers = json_array_size(json_object_get(loader->root, "buffers"));
    loader->gltf = mcv_gltf_new(buffers, picture_count);
    if (!loader->gltf) return mcv_fail_memory(&loader->file, error);
    MCV_TRY(need_meshes(loader, error));
    for (size_t i = 0; i < json_array_size(images); ++i) {
        const json_t *image = json_array_get(images, i);
        uint64_t first, size;
        size_t buffer;
        if (loader->images[i] == MCV_NONE || !json_object_get(image, "bufferView")) continue;
        view_of(loader->root, image, &buffer, &first, &size);
        need(loader->gltf, buffer, first, first + size);
    }
    for (size_t i = 0; i < buffers; ++i) MCV_TRY(read_buffer(loader, i, error));
    return open_images(loader, error);
}
