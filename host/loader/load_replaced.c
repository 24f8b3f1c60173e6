/* SPDX-License-Identifier: Apache-2.0 */
/* Materials of the scene that replace those of an asset, by name and by node (mcvisi/asset.h);
 * finding materials by name. */
#include "loader/loader.h"

#include "scene/params.h"

#include <stdlib.h>

/* An emissive material is refused, because its emission would be lost. */
mcv_result mcv_load_find_material(const mcv_loader *loader, const json_t *object, const char *key,
                                  uint32_t *material, const mcv_json_path *place,
                                  mcv_error *error) {
    const json_t *materials = json_object_get(loader->root, "materials"),
                 *value = json_object_get(object, key);
    const mcv_json_path here = mcv_json_path_key(place, key);
    uint32_t index = MCV_NONE;
    *material = MCV_NONE;
    if (!value) return MCV_OK;
    for (size_t i = 0; json_is_string(value) && i < json_array_size(materials); ++i)
        if (strcmp(mcv_json_name(json_array_get(materials, i)), json_string_value(value)) == 0) {
            if (index != MCV_NONE)
                return mcv_fail_at(&here, error, "the name \"%s\" is ambiguous: use the index",
                                   json_string_value(value));
            index = (uint32_t)i;
        }
    if (json_is_string(value) && index == MCV_NONE) {
        const char *names[256];
        size_t n = 0;
        for (size_t i = 0; i < json_array_size(materials) && n < 256; ++i)
            names[n++] = mcv_json_name(json_array_get(materials, i));
        const char *nearest = mcv_nearest_word(json_string_value(value), names, n);
        char metals[256];
        if (mcv_is_metal(json_string_value(value), metals) &&
            !(nearest && mcv_is_metal(nearest, metals)))
            return mcv_fail_at(&here, error,
                               "there is no material \"%s\": give the file one of this name, "
                               "{\"type\": \"conductor\", \"metal\": \"iron\", "
                               "\"roughness\": 0.3}; %s",
                               json_string_value(value), metals);
        return mcv_fail_at(&here, error, "there is no material \"%s\"%s%s%s",
                           json_string_value(value), nearest ? ": did you mean \"" : "",
                           nearest ? nearest : "", nearest ? "\"?" : "");
    }
    if (!json_is_string(value))
        MCV_TRY(mcv_json_index(object, key, json_array_size(materials), "materials", &index, place,
                               error));
    const double *radiance = loader->emission[index].radiance;
    if (radiance[0] + radiance[1] + radiance[2] > 0)
        return mcv_fail_at(
            &here, error,
            "the material emits light, but only meshes of glTF files can: choose another");
    *material = loader->materials[index];
    return MCV_OK;
}

/* Has element i of an array this name? Those without a name go by their index. */
static bool is_called(const json_t *element, size_t i, const char *name) {
    char number[32];
    snprintf(number, sizeof number, "%zu", i);
    return strcmp(*mcv_json_name(element) ? mcv_json_name(element) : number, name) == 0;
}

static mcv_result fail_unknown(const mcv_loader *asset, const char *of, const char *name,
                               const mcv_json_path *place, mcv_error *error) {
    const json_t *elements = json_object_get(asset->root, of);
    const char *names[256];
    char list[1024] = "";
    size_t n = 0;
    for (size_t i = 0; i < json_array_size(elements) && n < 256; ++i)
        if (*mcv_json_name(json_array_get(elements, i)))
            names[n++] = mcv_json_name(json_array_get(elements, i));
    const mcv_json_path here = mcv_json_path_key(place, name);
    const char *nearest = mcv_nearest_word(name, names, n), *slash = strrchr(asset->file.key, '/');
    const char *file = slash ? slash + 1 : asset->file.key;
    if (nearest)
        return mcv_fail_at(&here, error,
                           "there is none among the %s of \"%s\": did you mean \"%s\"?", of, file,
                           nearest);
    for (size_t i = 0; i < n; ++i)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s\"%s\"", i ? ", " : "",
                 names[i]);
    return mcv_fail_at(&here, error, "there is none among the %s of \"%s\": they are %s", of, file,
                       n ? list : "without names");
}

/* The entry's object `key`, {NAME: material}, for the elements of the asset's array `of`. */
static mcv_result replace_named(const mcv_loader *asset, const char *key, const char *of,
                                uint32_t *replaced, mcv_error *error) {
    const json_t *elements = json_object_get(asset->root, of);
    const mcv_json_path here = mcv_json_path_key(asset->entry_place, key);
    json_t *map, *value;
    const char *name;
    MCV_TRY(mcv_json_object(asset->entry, key, &map, asset->entry_place, error));
    json_object_foreach(map, name, value) {
        uint32_t material;
        bool found = false;
        MCV_TRY(mcv_load_find_material(asset->placer, map, name, &material, &here, error));
        for (size_t i = 0; i < json_array_size(elements); ++i) {
            if (!is_called(json_array_get(elements, i), i, name)) continue;
            replaced[i] = material;
            found = true;
        }
        if (!found) return fail_unknown(asset, of, name, &here, error);
    }
    return MCV_OK;
}

mcv_result mcv_load_replaced(mcv_loader *asset, mcv_error *error) {
    const size_t materials = json_array_size(json_object_get(asset->root, "materials"));
    const size_t nodes = json_array_size(json_object_get(asset->root, "nodes"));
    asset->node_materials = malloc((nodes + 1) * sizeof *asset->node_materials);
    if (!asset->node_materials) return mcv_fail_memory(&asset->file, error);
    MCV_TRY(mcv_load_find_material(asset->placer, asset->entry, "material", &asset->asset_material,
                                   asset->entry_place, error));
    for (size_t i = 0; i < materials; ++i) asset->materials[i] = asset->asset_material;
    for (size_t i = 0; i < nodes; ++i) asset->node_materials[i] = MCV_NONE;
    MCV_TRY(replace_named(asset, "materials", "materials", asset->materials, error));
    return replace_named(asset, "nodeMaterials", "nodes", asset->node_materials, error);
}
