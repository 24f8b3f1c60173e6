/* SPDX-License-Identifier: Apache-2.0 */
/* MCVISI_assets: other files, which nodes place (mcvisi/asset.h). An STL file without a given
 * material has the default one. */
#include "loader/loader.h"
#include "loader/load_stl.h"

#include "core/basics.h"
#include "scene/memory.h"
#include "scene/mesh.h"
#include "scene/params.h"

#include <stdlib.h>

/* Bytes of a mesh and of the table that numbers its vertices, for each of the file. */
enum { STL_GROWTH = 3 };

typedef struct asset_params {
    MCV_ASSET_PARAMS(MCV_DEFINE_FIELD)
} asset_params;

mcv_param_table mcv_asset_table(void) {
    typedef asset_params element_params;
    static const mcv_param rows[] = {MCV_ASSET_PARAMS(MCV_PARAM_ROW)};
    return (mcv_param_table){rows, sizeof rows / sizeof rows[0], sizeof(element_params)};
}

static mcv_result read_unit(const json_t *object, double *unit, const mcv_json_path *place,
                            mcv_error *error) {
    const char *name = "m";
    char one[32];
    const mcv_json_path here = mcv_json_path_key(place, "unit");
    MCV_TRY(mcv_json_string(object, "unit", &name, place, error));
    snprintf(one, sizeof one, "1%s", name);
    if (*name && mcv_parse_quantity(one, MCV_PARAM_length, unit)) return MCV_OK;
    return mcv_fail_at(&here, error, "\"%s\" must be one of nm, um, mm, cm, m, inch", name);
}

static mcv_result open_stl(mcv_loader *loader, mcv_loader *asset, const json_t *object,
                           const char *uri, const mcv_json_path *place, mcv_error *error) {
    const mcv_cached_asset *cached = mcv_asset_cache_find(loader->cache, asset->file.key);
    double size[3] = {0};
    const mcv_json_path here = mcv_json_path_key(place, "unit"),
                        there = mcv_json_path_key(place, "uri");
    const char *slash = strrchr(uri, '/');
    if (cached) {
        MCV_TRY(mcv_memory_take(loader->memory, &loader->memory->geometry,
                                mcv_mesh_bytes(cached->solid->meshes), &there, error));
        memcpy(size, cached->size, sizeof size);
        asset->fingerprint = cached->fingerprint;
        asset->solid = asset->scene->mesh_count;
        MCV_TRY(mcv_scene_add_mesh(asset->scene, cached->solid->meshes, error));
    } else {
        MCV_TRY(mcv_load_file(asset, asset->file.key, &asset->bytes, &there, error));
        MCV_TRY(mcv_memory_take(loader->memory, &loader->memory->geometry,
                                STL_GROWTH * (uint64_t)asset->bytes.size, &there, error));
        const mcv_result result = mcv_load_stl(asset->scene, asset->bytes, slash ? slash + 1 : uri,
                                               &asset->solid, size, &asset->file, error);
        free(asset->bytes.data);
        asset->bytes = (mcv_bytes){NULL, 0};
        MCV_TRY(result);
        MCV_TRY(mcv_asset_cache_add(asset, size, place, error));
    }
    if (!json_object_get(object, "unit"))
        return mcv_fail_at(
            &here, error,
            "is missing, and \"%s\" does not state it: the part is %.4g x %.4g x %.4g units "
            "large, and most files use \"mm\"",
            uri, size[0], size[1], size[2]);
    if (!isnan(asset->crease_angle))
        MCV_TRY(mcv_mesh_make_normals(asset->scene->meshes + asset->solid, asset->crease_angle,
                                      place, error));
    MCV_TRY(
        mcv_load_find_material(loader, object, "material", &asset->asset_material, place, error));
    return asset->asset_material == MCV_NONE ? mcv_load_plain(loader, &asset->asset_material, error)
                                             : MCV_OK;
}

static mcv_result open_gltf(mcv_loader *asset, const mcv_json_path *place, mcv_error *error) {
    const mcv_cached_asset *cached = mcv_asset_cache_find(asset->cache, asset->file.key);
    if (cached) {
        asset->is_cached = true;
        asset->root = json_incref(cached->root);
        asset->gltf = cached->gltf;
        asset->fingerprint = cached->fingerprint;
        return mcv_load_open(asset, (mcv_overrides){NULL, 0}, error);
    }
    MCV_TRY(mcv_load_file(asset, asset->file.key, &asset->bytes, place, error));
    MCV_TRY(mcv_load_open(asset, (mcv_overrides){NULL, 0}, error));
    return mcv_asset_cache_add(asset, NULL, place, error);
}

static mcv_result open_asset(mcv_loader *loader, const json_t *object, size_t index,
                             const mcv_json_path *place, mcv_error *error) {
    static const char *const others[] = {"name",     "uri",        "unit",
                                         "material", "materials",  "nodeMaterials",
                                         "extras",   "extensions", NULL};
    static const char *const of_gltf[] = {"materials", "nodeMaterials"};
    const char *uri = NULL;
    asset_params params;
    mcv_loader *asset = loader->assets + index;
    const mcv_json_path here = mcv_json_path_key(place, "uri");
    mcv_params_set_defaults(mcv_asset_table(), &params);
    MCV_TRY(mcv_params_parse(mcv_asset_table(), object, others, &params, place, error));
    MCV_TRY(mcv_params_check(mcv_asset_table(), &params, place, error));
    MCV_TRY(mcv_json_string(object, "uri", &uri, place, error));
    if (!uri) return mcv_fail_at(&here, error, "is missing: a .gltf, .glb or .stl file");
    const bool stl = mcv_ends_in(uri, ".stl");
    if (!stl && !mcv_ends_in(uri, ".gltf") && !mcv_ends_in(uri, ".glb"))
        return mcv_fail_at(&here, error, "\"%s\" must be a .gltf, .glb or .stl file: %s", uri,
                           mcv_conversion(uri));
    for (size_t i = 0; stl && i < 2; ++i) {
        const mcv_json_path of = mcv_json_path_key(place, of_gltf[i]);
        if (json_object_get(object, of_gltf[i]))
            return mcv_fail_at(&of, error,
                               "is for .gltf and .glb files: \"%s\" has neither names nor "
                               "materials, give it a \"material\"",
                               uri);
    }
    if (loader->is_asset)
        return mcv_fail_at(place, error,
                           "an asset may not place assets itself: place them from the scene");
    MCV_TRY(mcv_file_resolve(loader->file.key, uri, loader->asset_paths + index, &here, error));
    *asset = (mcv_loader){.scene = loader->scene,
                          .memory = loader->memory,
                          .file = mcv_place_file(loader->asset_paths[index]),
                          .is_asset = true,
                          .cache = loader->cache,
                          .solid = MCV_NONE,
                          .asset_material = MCV_NONE,
                          .crease_angle = params.creaseAngle,
                          .placer = loader,
                          .entry = object,
                          .entry_place = place,
                          .plain = MCV_NONE,
                          .absorber = MCV_NONE};
    MCV_TRY(read_unit(object, &asset->unit, place, error));
    MCV_TRY(stl ? open_stl(loader, asset, object, uri, place, error)
                : open_gltf(asset, &here, error));
    mcv_load_count(loader, &asset->fingerprint, sizeof asset->fingerprint);
    return MCV_OK;
}

mcv_result mcv_load_assets(mcv_loader *loader, mcv_error *error) {
    json_t *array;
    const mcv_json_path place = mcv_json_path_key(&loader->file, "assets");
    MCV_TRY(mcv_load_array(loader, "MCVISI_assets", "assets", &array, error));
    loader->assets = calloc(json_array_size(array) + 1, sizeof *loader->assets);
    loader->asset_paths = calloc(json_array_size(array) + 1, sizeof *loader->asset_paths);
    if (!loader->assets || !loader->asset_paths) return mcv_fail_memory(&place, error);
    loader->asset_count = json_array_size(array);
    for (size_t i = 0; i < loader->asset_count; ++i) {
        const json_t *object = json_array_get(array, i);
        const mcv_json_path here = mcv_json_path_element(&place, mcv_json_name(object), i);
        MCV_TRY(open_asset(loader, object, i, &here, error));
    }
    return MCV_OK;
}

mcv_result mcv_load_asset_of(const mcv_loader *loader, const json_t *node, mcv_loader **asset,
                             const mcv_json_path *place, mcv_error *error) {
    uint32_t index;
    MCV_TRY(mcv_load_reference(node, "MCVISI_assets", "asset", loader->asset_count, "assets",
                               &index, place, error));
    *asset = index == MCV_NONE ? NULL : loader->assets + index;
    return MCV_OK;
}
