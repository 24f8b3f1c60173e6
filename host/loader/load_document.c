/* SPDX-License-Identifier: Apache-2.0 */
/* A document: reads, splits, parses, overrides and validates it, then opens its buffers and
 * images. */
#include "loader/loader.h"

#include "loader/overrides.h"
#include "loader/validate.h"
#include "scene/memory.h"

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
    uint64_t size;
    MCV_TRY(mcv_file_size(path, &size, place, error));
    MCV_TRY(mcv_memory_take(loader->memory, &loader->memory->files, size, place, error));
    MCV_TRY(mcv_file_read(path, bytes, place, error));
    mcv_load_count(loader, bytes->data, bytes->size);
    return MCV_OK;
}

static mcv_result open_data(mcv_loader *loader, mcv_error *error) {
    uint32_t image_count;
    MCV_TRY(mcv_load_needed_images(loader, &image_count, error));
    MCV_TRY(mcv_load_needed_emitter_images(loader, &image_count, error));
    if (loader->is_cached) return MCV_OK;
    MCV_TRY(mcv_load_data(loader, image_count, error));
    free(loader->bytes.data);
    loader->bytes = loader->binary = (mcv_bytes){NULL, 0};
    return MCV_OK;
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
    MCV_TRY(mcv_memory_take(loader->memory, &loader->memory->files,
                            mcv_memory_of_json((const char *)json.data, json.size), &loader->file,
                            error));
    loader->root =
        mcv_json_parse((const char *)json.data, json.size, JSON_REJECT_DUPLICATES, &wrong);
    if (!loader->root && !wrong.text[0]) return mcv_fail_memory(&loader->file, error);
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
    loader->pixels = malloc((images + 1) * sizeof *loader->pixels);
    loader->data_pixels = malloc((images + 1) * sizeof *loader->data_pixels);
    loader->materials = malloc((materials + 1) * sizeof *loader->materials);
    loader->emission = calloc(materials + 1, sizeof *loader->emission);
    loader->meshes = calloc(meshes + 1, sizeof *loader->meshes);
    if (!loader->images || !loader->textures || !loader->data_textures || !loader->materials ||
        !loader->emission || !loader->meshes || !loader->pixels || !loader->data_pixels)
        return mcv_fail_memory(&loader->file, error);
    for (size_t i = 0; i < images; ++i) loader->pixels[i] = loader->data_pixels[i] = MCV_NONE;
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
    free(loader->pixels);
    free(loader->data_pixels);
    free(loader->images);
    free(loader->sensors);
    free(loader->emitters);
    free(loader->lights);
    mcv_load_free_bodies(loader);
    mcv_load_free_frames(loader);
    free(loader->presets);
    free(loader->sensor_uses);
    free(loader->emitter_uses);
    if (!loader->is_cached) mcv_gltf_free(loader->gltf);
    mcv_stamps_free(loader->stamps, loader->stamp_count);
    json_decref(loader->root);
    free(loader->bytes.data);
}
