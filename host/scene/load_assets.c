/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MCVISI_assets: other glTF files that nodes place, {"uri": "part.glb", "unit": "mm"}. The unit is that of the file's
 * lengths, metres by default. Only meshes and emissive materials of an asset count.
 */
#include "scene/load.h"

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

static mcv_result open_asset(mcv_loader *loader, const json_t *object, size_t index, const mcv_place *place, mcv_error *error) {
    static const char *const others[] = {"name", "uri", "unit", "extras", "extensions", NULL};
    const char *uri = NULL;
    mcv_loader *asset = loader->assets + index;
    const mcv_place here = mcv_place_key(place, "uri");
    MCV_TRY(mcv_params_parse((mcv_param_table){0}, object, others, NULL, place, error));
    MCV_TRY(mcv_json_string(object, "uri", &uri, place, error));
    if (!uri) return mcv_fail_at(&here, error, "is missing: a .gltf or .glb file");
    const char *dot = strrchr(uri, '.');
    if (!dot || (strcmp(dot, ".gltf") != 0 && strcmp(dot, ".glb") != 0))
        return mcv_fail_at(&here, error, "\"%s\" must be a .gltf or .glb file: convert other formats", uri);
    if (loader->is_asset) return mcv_fail_at(place, error, "an asset may not place assets itself: place them from the scene");
    MCV_TRY(mcv_file_resolve(loader->file.key, uri, loader->asset_paths + index, &here, error));
    *asset = (mcv_loader){.scene = loader->scene,
                          .file = mcv_place_file(loader->asset_paths[index]),
                          .is_asset = true,
                          .plain = MCV_NONE,
                          .absorber = MCV_NONE};
    MCV_TRY(read_unit(object, &asset->unit, place, error));
    MCV_TRY(mcv_file_read(asset->file.key, &asset->bytes, &here, error));
    return mcv_load_open(asset, (mcv_overrides){NULL, 0}, error);
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
