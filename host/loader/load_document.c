/* SPDX-License-Identifier: Apache-2.0 */
/* A document: reads, splits, parses, overrides and validates it, then opens its buffers and
 * images. */
#include "loader/loader.h"

#include "loader/overrides.h"
#include "loader/validate.h"

#include <stdlib.h>
#include <string.h>

/* The size first, then each word, mixed by multiplication and shift. */
void mcv_load_count(mcv_loader *loader, const void *data, size_t size) {
    const unsigned char *bytes = data;
    uint64_t hash = loader->fingerprint ^ size;
    for (size_t i = 0; i < size; i += sizeof hash) {
        uint64_t word = 0;
        memcpy(&word, bytes + i, size - i < sizeof word ? size - i : sizeof word);
        hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
    }
    loader->fingerprint = hash;
}

mcv_result mcv_load_file(mcv_loader *loader, const char *path, mcv_bytes *bytes,
                         const mcv_json_path *place, mcv_error *error) {
    if (loader->is_asset && loader->cache) MCV_TRY(mcv_stamp_add(loader, path, place, error));
    MCV_TRY(mcv_file_read(path, bytes, place, error));
    mcv_load_count(loader, bytes->data, bytes->size);
    return MCV_OK;
}

/* Answers requests of tinygltf: "buffers/3" or "images/5", the names that describe_data() has
 * given. */
static mcv_result read_external(void *user, const char *name, mcv_bytes *bytes, mcv_error *error) {
    mcv_loader *loader = user;
    const char *slash = strchr(name, '/');
    const bool is_buffer = slash && strncmp(name, "buffers/", 8) == 0;
    const size_t index = slash ? strtoul(slash + 1, NULL, 10) : 0;
    const mcv_json_path of = mcv_json_path_key(&loader->file, is_buffer ? "buffers" : "images");
    const mcv_json_path element = mcv_place_index(&of, index),
                        place = mcv_json_path_key(&element, "uri");
    const json_t *object =
        json_array_get(json_object_get(loader->root, is_buffer ? "buffers" : "images"), index);
    const char *uri = json_string_value(json_object_get(object, "uri"));
    const size_t length = (size_t)json_number_value(json_object_get(object, "byteLength"));
    if (is_buffer && !uri && !mcv_buffer_is_chunk(loader->root, object, loader->binary)) {
        bytes->data = calloc(1, 1); /* no data; nothing that is read fits into it */
        bytes->size = 1;
        return bytes->data ? MCV_OK : mcv_fail_memory(&element, error);
    }
    if (uri) {
        char *path;
        MCV_TRY(mcv_file_resolve(loader->file.key, uri, &path, &place, error));
        const mcv_result result = mcv_load_file(loader, path, bytes, &place, error);
        free(path);
        MCV_TRY(result);
    } else {
        bytes->data = malloc(length);
        bytes->size = length;
        if (!bytes->data) return mcv_fail_memory(&element, error);
        memcpy(bytes->data, loader->binary.data, length);
    }
    if (!is_buffer) return MCV_OK;
    if (bytes->size < length) {
        free(bytes->data);
        return mcv_fail_at(&place, error, "\"%s\" has %zu bytes, but byteLength is %zu", uri,
                           bytes->size, length);
    }
    bytes->size = length; /* tinygltf requires exactly this size */
    return MCV_OK;
}

/* A data: URI stays; everything else is read by read_external. A data: URI with more bytes raises
 * byteLength, because tinygltf requires the exact size. */
static json_t *describe_data(const mcv_loader *loader, const json_t *object, const char *of,
                             size_t index) {
    static const char *const types[] = {"application/octet-stream", "application/gltf-buffer",
                                        "text/plain", NULL};
    const char *uri = json_string_value(json_object_get(object, "uri"));
    json_t *copy = json_object();
    mcv_error ignored;
    const mcv_json_path place = mcv_place_file("");
    uint64_t length;
    json_object_set_new(copy, "name", json_sprintf("%s/%zu", of, index));
    if (json_object_get(object, "bufferView")) {
        json_object_set(copy, "bufferView", json_object_get(object, "bufferView"));
        json_object_set(copy, "mimeType", json_object_get(object, "mimeType"));
        return copy;
    }
    if (json_object_get(object, "byteLength"))
        json_object_set_new(
            copy, "byteLength",
            json_integer((json_int_t)json_number_value(json_object_get(object, "byteLength"))));
    if (strcmp(of, "buffers") == 0 && !uri &&
        !mcv_buffer_is_chunk(loader->root, object, loader->binary))
        json_object_set_new(copy, "byteLength", json_integer(1)); /* see read_external */
    if (!uri || strncmp(uri, "data:", 5) != 0) {
        json_object_set_new(copy, "uri", json_sprintf("%s/%zu", of, index));
        return copy;
    }
    json_object_set(copy, "uri", json_object_get(object, "uri"));
    if (strcmp(of, "buffers") == 0 &&
        mcv_data_uri_length(uri, types, &length, &place, &ignored) == MCV_OK)
        json_object_set_new(copy, "byteLength", json_integer((json_int_t)length));
    return copy;
}

/* The part of the document that tinygltf sees. */
static json_t *describe_document(const mcv_loader *loader, uint32_t image_count) {
    const json_t *buffers = json_object_get(loader->root, "buffers"),
                 *images = json_object_get(loader->root, "images");
    json_t *data = json_array(), *pictures = json_array(), *document = json_object();
    for (size_t i = 0; i < json_array_size(buffers); ++i)
        json_array_append_new(data,
                              describe_data(loader, json_array_get(buffers, i), "buffers", i));
    for (uint32_t slot = 0; slot < image_count; ++slot)
        for (size_t i = 0; i < json_array_size(images); ++i)
            if (loader->images[i] == slot)
                json_array_append_new(
                    pictures, describe_data(loader, json_array_get(images, i), "images", i));
    json_object_set_new(document, "buffers", data);
    json_object_set_new(document, "images", pictures);
    if (json_object_get(loader->root, "bufferViews"))
        json_object_set(document, "bufferViews", json_object_get(loader->root, "bufferViews"));
    return document;
}

static mcv_result open_data(mcv_loader *loader, mcv_error *error) {
    uint32_t image_count;
    MCV_TRY(mcv_load_needed_images(loader, &image_count, error));
    MCV_TRY(mcv_load_needed_emitter_images(loader, &image_count, error));
    if (loader->is_cached) return MCV_OK;
    json_t *document = describe_document(loader, image_count);
    char *text = json_dumps(document, JSON_COMPACT);
    json_decref(document);
    if (!text) return mcv_fail_memory(&loader->file, error);
    const mcv_result result = mcv_gltf_open(text, strlen(text), read_external, loader,
                                            &loader->gltf, &loader->file, error);
    free(text);
    free(loader->bytes.data);
    loader->bytes = loader->binary = (mcv_bytes){NULL, 0};
    return result;
}

/*
 * CAD exporters write U+0000 into strings, where strings of C end. It becomes the replacement
 * character U+FFFD: harmless in strings that are not read, visible in others. Some exporters fill
 * the JSON of a GLB with zeros instead of spaces.
 */
static void replace_nul(mcv_bytes *json) {
    while (json->size > 0 && json->data[json->size - 1] == 0) --json->size;
    for (size_t i = 0; i + 6 <= json->size; ++i) {
        if (json->data[i] != '\\') continue;
        if (memcmp(json->data + i, "\\u0000", 6) == 0) memcpy(json->data + i, "\\ufffd", 6);
        ++i; /* an escaped character does not start an escape */
    }
}

mcv_result mcv_load_json(mcv_loader *loader, mcv_error *error) {
    mcv_bytes json;
    json_error_t wrong;
    MCV_TRY(mcv_glb_split(loader->bytes, &json, &loader->binary, &loader->file, error));
    replace_nul(&json);
    loader->root = json_loadb((const char *)json.data, json.size, JSON_REJECT_DUPLICATES, &wrong);
    if (!loader->root)
        return mcv_fail_at(&loader->file, error, "line %d column %d is not JSON: %s", wrong.line,
                           wrong.column, mcv_json_wrong(&wrong));
    if (!loader->binary.data) { /* the tree now holds the whole .gltf */
        free(loader->bytes.data);
        loader->bytes = (mcv_bytes){NULL, 0};
    }
    return MCV_OK;
}

/* Parses the document, applies overrides and validates it. */
static mcv_result parse(mcv_loader *loader, mcv_overrides overrides, mcv_error *error) {
    if (!loader->root) MCV_TRY(mcv_load_json(loader, error));
    MCV_TRY(mcv_overrides_apply(overrides, loader->root, &loader->file, error));
    MCV_TRY(mcv_gltf_validate(loader->root, loader->binary, &loader->file, error));
    return mcv_check_extensions(loader->root, &loader->file, error);
}

mcv_result mcv_load_open(mcv_loader *loader, mcv_overrides overrides, mcv_error *error) {
    if (!loader->is_cached) MCV_TRY(parse(loader, overrides, error));
    const size_t images = json_array_size(json_object_get(loader->root, "images"));
    const size_t textures = json_array_size(json_object_get(loader->root, "textures"));
    const size_t materials = json_array_size(json_object_get(loader->root, "materials"));
    const size_t meshes = json_array_size(json_object_get(loader->root, "meshes"));
    loader->images = malloc((images + 1) * sizeof *loader->images);
    loader->textures = malloc((textures + 1) * sizeof *loader->textures);
    loader->data_textures = malloc((textures + 1) * sizeof *loader->data_textures);
    loader->materials = malloc((materials + 1) * sizeof *loader->materials);
    loader->emission = calloc(materials + 1, sizeof *loader->emission);
    loader->meshes = calloc(meshes + 1, sizeof *loader->meshes);
    if (!loader->images || !loader->textures || !loader->data_textures || !loader->materials ||
        !loader->emission || !loader->meshes)
        return mcv_fail_memory(&loader->file, error);
    for (size_t i = 0; i < textures; ++i) loader->textures[i] = loader->data_textures[i] = MCV_NONE;
    for (size_t i = 0; i < materials; ++i) loader->materials[i] = MCV_NONE;
    if (loader->is_asset) MCV_TRY(mcv_load_replaced(loader, error));
    if (!loader->is_asset) MCV_TRY(mcv_load_definitions(loader, error));
    if (!loader->is_asset) MCV_TRY(mcv_load_lights(loader, error));
    MCV_TRY(open_data(loader, error));
    MCV_TRY(mcv_load_materials(loader, error));
    MCV_TRY(mcv_load_bodies(loader, error));
    MCV_TRY(mcv_load_emitter_images(loader, error));
    MCV_TRY(mcv_load_assets(loader, error));
    return mcv_load_warn_ignored(loader, error);
}

void mcv_load_finish(mcv_loader *loader) {
    for (size_t i = 0; loader->assets && i < loader->asset_count; ++i) {
        mcv_load_finish(loader->assets + i);
        free(loader->asset_paths[i]);
    }
    free(loader->assets);
    free(loader->asset_paths);
    for (size_t i = 0;
         loader->meshes && i < json_array_size(json_object_get(loader->root, "meshes")); ++i)
        free(loader->meshes[i].materials);
    free(loader->meshes);
    free(loader->materials);
    free(loader->node_materials);
    free(loader->emission);
    free(loader->textures);
    free(loader->data_textures);
    free(loader->images);
    free(loader->sensors);
    free(loader->emitters);
    free(loader->lights);
    mcv_load_free_bodies(loader);
    free(loader->presets);
    free(loader->sensor_uses);
    free(loader->emitter_uses);
    if (!loader->is_cached) mcv_gltf_close(loader->gltf);
    mcv_stamps_free(loader->stamps, loader->stamp_count);
    json_decref(loader->root);
    free(loader->bytes.data);
}
