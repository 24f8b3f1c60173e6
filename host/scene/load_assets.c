/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MCVISI_assets: other files that nodes place, {"uri": "part.stl", "unit": "mm", "material": "steel"}. The unit is that of the file's
 * lengths, metres by default for glTF. Only meshes and emissive materials of a glTF asset count. An STL file knows neither unit nor
 * material: the unit must be given, the material is one of the scene's, or plain.
 */
#include "scene/load.h"

#include "core/basics.h"
#include "scene/params.h"

#include <stdlib.h>

static mcv_result read_unit(const json_t *object, double *unit, const mcv_place *place, mcv_error *error) {
    const char *name = "m";
    char one[32];
    const mcv_place here = mcv_place_key(place, "unit");
    MCV_TRY(mcv_json_string(object, "unit", &name, place, error));
    snprintf(one, sizeof one, "1%s", name);
    if (*name && mcv_parse_quantity(one, MCV_PARAM_length, unit)) return MCV_OK;
    return mcv_fail_at(&here, error, "\"%s\" must be one of nm, um, mm, cm, m", name);
}

/* The material that an emission would be lost on is refused. */
mcv_result mcv_load_find_material(const mcv_loader *loader, const json_t *object, const char *key, uint32_t *material,
                                  const mcv_place *place, mcv_error *error) {
    const json_t *materials = json_object_get(loader->root, "materials"), *value = json_object_get(object, key);
    const mcv_place here = mcv_place_key(place, key);
    uint32_t index = MCV_NONE;
    *material = MCV_NONE;
    if (!value) return MCV_OK;
    for (size_t i = 0; json_is_string(value) && i < json_array_size(materials); ++i)
        if (strcmp(mcv_json_name(json_array_get(materials, i)), json_string_value(value)) == 0) {
            if (index != MCV_NONE)
                return mcv_fail_at(&here, error, "the name \"%s\" is ambiguous: use the index", json_string_value(value));
            index = (uint32_t)i;
        }
    if (json_is_string(value) && index == MCV_NONE)
        return mcv_fail_at(&here, error, "there is no material \"%s\"", json_string_value(value));
    if (!json_is_string(value)) MCV_TRY(mcv_json_index(object, key, json_array_size(materials), "materials", &index, place, error));
    const double *radiance = loader->emission[index].radiance;
    if (radiance[0] + radiance[1] + radiance[2] > 0)
        return mcv_fail_at(&here, error, "the material emits light, which only a mesh of a glTF file can: choose another");
    *material = loader->first_material + index;
    return MCV_OK;
}

static mcv_result open_stl(mcv_loader *loader, mcv_loader *asset, const json_t *object, const char *uri, const mcv_place *place,
                           mcv_error *error) {
    const mcv_kept_asset *kept = mcv_kept_find(loader->kept, asset->file.key);
    double size[3] = {0};
    const mcv_place here = mcv_place_key(place, "unit"), there = mcv_place_key(place, "uri");
    const char *slash = strrchr(uri, '/');
    if (kept) {
        memcpy(size, kept->size, sizeof size);
        asset->fingerprint = kept->fingerprint;
        asset->solid = asset->scene->mesh_count;
        MCV_TRY(mcv_scene_add_mesh(asset->scene, kept->solid->meshes, error));
    } else {
        MCV_TRY(mcv_load_file(asset, asset->file.key, &asset->bytes, &there, error));
        const mcv_result result =
            mcv_load_stl(asset->scene, asset->bytes, slash ? slash + 1 : uri, &asset->solid, size, &asset->file, error);
        free(asset->bytes.data);
        asset->bytes = (mcv_bytes){NULL, 0};
        MCV_TRY(result);
        MCV_TRY(mcv_kept_add(asset, size, place, error));
    }
    if (!json_object_get(object, "unit"))
        return mcv_fail_at(&here, error,
                           "is missing, and \"%s\" does not tell it: the part is %.4g x %.4g x %.4g of it, most are in \"mm\"", uri,
                           size[0], size[1], size[2]);
    MCV_TRY(mcv_load_find_material(loader, object, "material", &asset->solid_material, place, error));
    return asset->solid_material == MCV_NONE ? mcv_load_plain(loader, &asset->solid_material, error) : MCV_OK;
}

static mcv_result open_gltf(mcv_loader *asset, const mcv_place *place, mcv_error *error) {
    const mcv_kept_asset *kept = mcv_kept_find(asset->kept, asset->file.key);
    if (kept) {
        asset->has_kept_data = true;
        asset->root = json_incref(kept->root);
        asset->gltf = kept->gltf;
        asset->fingerprint = kept->fingerprint;
        return mcv_load_open(asset, (mcv_overrides){NULL, 0}, error);
    }
    MCV_TRY(mcv_load_file(asset, asset->file.key, &asset->bytes, place, error));
    MCV_TRY(mcv_load_open(asset, (mcv_overrides){NULL, 0}, error));
    return mcv_kept_add(asset, NULL, place, error);
}

static mcv_result open_asset(mcv_loader *loader, const json_t *object, size_t index, const mcv_place *place, mcv_error *error) {
    static const char *const others[] = {"name", "uri", "unit", "material", "extras", "extensions", NULL};
    const char *uri = NULL;
    mcv_loader *asset = loader->assets + index;
    const mcv_place here = mcv_place_key(place, "uri"), material = mcv_place_key(place, "material");
    MCV_TRY(mcv_params_parse((mcv_param_table){0}, object, others, NULL, place, error));
    MCV_TRY(mcv_json_string(object, "uri", &uri, place, error));
    if (!uri) return mcv_fail_at(&here, error, "is missing: a .gltf, .glb or .stl file");
    const bool stl = mcv_ends_in(uri, ".stl");
    if (!stl && !mcv_ends_in(uri, ".gltf") && !mcv_ends_in(uri, ".glb"))
        return mcv_fail_at(&here, error, "\"%s\" must be a .gltf, .glb or .stl file: %s", uri, mcv_conversion(uri));
    if (!stl && json_object_get(object, "material"))
        return mcv_fail_at(&material, error, "is for .stl files: \"%s\" has its own materials", uri);
    if (loader->is_asset) return mcv_fail_at(place, error, "an asset may not place assets itself: place them from the scene");
    MCV_TRY(mcv_file_resolve(loader->file.key, uri, loader->asset_paths + index, &here, error));
    *asset = (mcv_loader){.scene = loader->scene,
                          .file = mcv_place_file(loader->asset_paths[index]),
                          .is_asset = true,
                          .kept = loader->kept,
                          .solid = MCV_NONE,
                          .plain = MCV_NONE,
                          .absorber = MCV_NONE};
    MCV_TRY(read_unit(object, &asset->unit, place, error));
    MCV_TRY(stl ? open_stl(loader, asset, object, uri, place, error) : open_gltf(asset, &here, error));
    mcv_load_count(loader, &asset->fingerprint, sizeof asset->fingerprint);
    return MCV_OK;
}

mcv_result mcv_load_assets(mcv_loader *loader, mcv_error *error) {
    json_t *array;
    const mcv_place place = mcv_place_key(&loader->file, "assets");
    MCV_TRY(mcv_load_array(loader, "MCVISI_assets", "assets", &array, error));
    loader->assets = calloc(json_array_size(array) + 1, sizeof *loader->assets);
    loader->asset_paths = calloc(json_array_size(array) + 1, sizeof *loader->asset_paths);
    if (!loader->assets || !loader->asset_paths) return mcv_fail_memory(&place, error);
    loader->asset_count = json_array_size(array);
    for (size_t i = 0; i < loader->asset_count; ++i) {
        const json_t *object = json_array_get(array, i);
        const mcv_place here = mcv_place_element(&place, mcv_json_name(object), i);
        MCV_TRY(open_asset(loader, object, i, &here, error));
    }
    return MCV_OK;
}

mcv_result mcv_load_asset_of(const mcv_loader *loader, const json_t *node, mcv_loader **asset, const mcv_place *place, mcv_error *error) {
    uint32_t index;
    MCV_TRY(mcv_load_reference(node, "MCVISI_assets", "asset", loader->asset_count, "assets", &index, place, error));
    *asset = index == MCV_NONE ? NULL : loader->assets + index;
    return MCV_OK;
}
