/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes from glTF files: opens the document and places its nodes. */
#include "loader/loader.h"

#include "core/basics.h"
#include "scene/emitters.h"
#include "scene/memory.h"
#include "scene/params.h"
#include "scene/spectra.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static mcv_result warn_unused(mcv_loader *loader, mcv_error *error) {
    for (size_t i = 0; i < loader->sensor_count; ++i)
        if (!loader->sensor_uses[i])
            MCV_TRY(mcv_scene_warn(loader->scene, error,
                                   "sensors/%zu \"%s\" is on no node of the scene", i,
                                   loader->sensors[i].name));
    for (size_t i = 0; i < loader->emitter_count; ++i)
        if (!loader->emitter_uses[i])
            MCV_TRY(mcv_scene_warn(loader->scene, error,
                                   "emitters/%zu \"%s\" is on no node of the scene", i,
                                   loader->emitters[i].name));
    return MCV_OK;
}

/* The resolution of float32 directions is 6e-8. */
static const double least_cone = 1e-7;

static mcv_result warn_of_needles(mcv_scene *scene, mcv_error *error) {
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const double half_angle = mcv_emitter_half_angle(&scene->emitters[i]);
        if (half_angle < least_cone)
            MCV_TRY(mcv_scene_warn(
                scene, error,
                "emitter \"%s\": a half-angle of %.3g rad is below the resolution of directions "
                "(%g "
                "rad): a sensor that looks into it may see black; make it wider, or use a "
                "collimatedBeam",
                scene->emitters[i].name, half_angle, least_cone));
    }
    return MCV_OK;
}

/* MCVISI_spectrum: {"wavelengths": a length, or one for each of red, green and blue}. */
static mcv_result load_spectrum(mcv_loader *loader, mcv_error *error) {
    const json_t *object = mcv_json_extension(loader->root, "MCVISI_spectrum");
    const mcv_json_path extensions = mcv_json_path_key(&loader->file, "extensions"),
                        place = mcv_json_path_key(&extensions, "MCVISI_spectrum");
    static const char *const keys[] = {"wavelengths", "extras", NULL};
    if (!object) return MCV_OK;
    if (!json_is_object(object))
        return mcv_fail_at(&place, error, "must be an object {\"wavelengths\": ...}");
    MCV_TRY(mcv_params_parse((mcv_param_table){0}, object, keys, NULL, &place, error));
    const json_t *given = json_object_get(object, "wavelengths");
    const mcv_json_path here = mcv_json_path_key(&place, "wavelengths");
    for (size_t i = 0; i < 3; ++i) {
        const json_t *one = json_is_array(given)
                                ? json_array_get(given, json_array_size(given) == 1 ? 0 : i)
                                : given;
        double *length = &loader->scene->wavelengths[i];
        const bool is_length =
            json_is_number(one) ||
            (json_is_string(one) &&
             mcv_parse_quantity(json_string_value(one), MCV_PARAM_length, length));
        if (json_is_number(one)) *length = json_number_value(one);
        if ((json_is_array(given) && json_array_size(given) != 1 && json_array_size(given) != 3) ||
            !is_length)
            return mcv_fail_at(
                &here, error,
                "must be a length such as \"587.6nm\", or three, for red, green and blue");
        if (!(*length >= MCV_LEAST_WAVELENGTH && *length <= MCV_LARGEST_WAVELENGTH))
            return mcv_fail_at(&here, error, "%g m must be from 100 nm to 100 um", *length);
    }
    return MCV_OK;
}

const char *mcv_conversion(const char *path) {
    static const char *const exact[] = {".step", ".stp", ".iges", ".igs"};
    for (size_t i = 0; i < sizeof exact / sizeof exact[0]; ++i)
        if (mcv_ends_in(path, exact[i]))
            return "convert its surfaces to triangles, with a chord tolerance of less than a tenth "
                   "of a pixel: in FreeCAD by "
                   "Mesh > Create Mesh from Shape, or in Python by "
                   "cadquery.exporters.export(cadquery.importers.importStep(\"part.step\"), "
                   "\"part.stl\", tolerance=0.005)";
    return "convert other formats, for example by Blender";
}

/* Refuses parts and unsupported formats, by the ending of the name. */
static mcv_result check_format(const char *path, const mcv_json_path *place, mcv_error *error) {
    static const char *const others[] = {".step", ".stp", ".iges", ".igs",   ".obj",
                                         ".ply",  ".3mf", ".fbx",  ".blend", ".dae"};
    if (mcv_ends_in(path, ".stl"))
        return mcv_fail_at(place, error,
                           "is a part without camera and light: `mcvisi new telecentric %s --unit "
                           "mm` writes a scene around it (or new "
                           "entocentric, new lightfield)",
                           path);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; ++i)
        if (mcv_ends_in(path, others[i]))
            return mcv_fail_at(place, error, "must be a .gltf or .glb file: %s",
                               mcv_conversion(path));
    return MCV_OK;
}

mcv_result mcv_scene_load(const char *path, mcv_overrides overrides, mcv_scene **scene,
                          mcv_error *error) {
    return mcv_scene_load_cached(path, overrides, 0, NULL, scene, error);
}

static mcv_loader new_loader(const char *path, mcv_asset_cache *cache) {
    return (mcv_loader){.file = mcv_place_file(path),
                        .solid = MCV_NONE,
                        .asset_material = MCV_NONE,
                        .crease_angle = NAN,
                        .plain = MCV_NONE,
                        .absorber = MCV_NONE,
                        .cache = cache};
}

static mcv_scene *new_scene(const char *path, uint64_t memory) {
    mcv_scene *scene = mcv_scene_new(path);
    if (scene) scene->memory.limit = memory ? memory : mcv_memory_default();
    return scene;
}

/* All that follows once the bytes or the tree of the document are there. */
static mcv_result load(mcv_loader *loader, mcv_overrides overrides, mcv_error *error) {
    const mcv_transform world = mcv_transform_identity();
    MCV_TRY(mcv_load_open(loader, overrides, error));
    MCV_TRY(load_spectrum(loader, error));
    MCV_TRY(mcv_load_nodes(loader, &world, error));
    MCV_TRY(mcv_load_defects(loader, error));
    mcv_scene_settle_spectra(loader->scene);
    MCV_TRY(warn_unused(loader, error));
    return warn_of_needles(loader->scene, error);
}

static mcv_result finish(mcv_loader *loader, mcv_result result, mcv_scene **scene) {
    loader->scene->fingerprint = loader->fingerprint;
    mcv_load_finish(loader);
    *scene = loader->scene;
    if (result == MCV_OK) return MCV_OK;
    mcv_scene_free(*scene);
    *scene = NULL;
    return result;
}

mcv_result mcv_scene_load_cached(const char *path, mcv_overrides overrides, uint64_t memory,
                                 mcv_asset_cache *cache, mcv_scene **scene, mcv_error *error) {
    mcv_loader loader = new_loader(path, cache);
    if (cache) mcv_asset_cache_drop_changed(cache);
    *scene = loader.scene = new_scene(path, memory);
    if (!loader.scene) return mcv_fail_memory(&loader.file, error);
    loader.memory = &loader.scene->memory;
    mcv_result result = mcv_load_file(&loader, path, &loader.bytes, &loader.file, error);
    if (result == MCV_OK) result = check_format(path, &loader.file, error);
    if (result == MCV_OK) result = load(&loader, overrides, error);
    return finish(&loader, result, scene);
}

/* --- documents --- */

mcv_result mcv_scene_load_document(const mcv_document *document, mcv_overrides overrides,
                                   uint64_t memory, mcv_asset_cache *cache, mcv_scene **scene,
                                   mcv_error *error) {
    mcv_loader loader = new_loader(document->path, cache);
    if (cache) mcv_asset_cache_drop_changed(cache);
    *scene = loader.scene = new_scene(document->path, memory);
    if (!loader.scene) return mcv_fail_memory(&loader.file, error);
    loader.memory = &loader.scene->memory;
    loader.scene->memory.files = document->memory;
    loader.root = json_deep_copy(document->root);
    loader.binary = document->binary;
    loader.fingerprint = document->fingerprint;
    const mcv_result result =
        loader.root ? load(&loader, overrides, error) : mcv_fail_memory(&loader.file, error);
    return finish(&loader, result, scene);
}

/* From the bytes of a file, which change owners. */
static mcv_result open_document(mcv_loader *loader, mcv_document *document, mcv_error *error) {
    mcv_result result = mcv_load_json(loader, error);
    *document = (mcv_document){.path = result == MCV_OK ? strdup(loader->file.key) : NULL,
                               .root = loader->root,
                               .file = loader->bytes,
                               .binary = loader->binary,
                               .memory = loader->memory->files,
                               .fingerprint = loader->fingerprint};
    if (result == MCV_OK && !document->path) result = mcv_fail_memory(&loader->file, error);
    if (result != MCV_OK) mcv_document_free(document);
    return result;
}

mcv_result mcv_document_read(const char *path, mcv_document *document, mcv_error *error) {
    mcv_memory memory = {.limit = mcv_memory_default()};
    mcv_loader loader = new_loader(path, NULL);
    loader.memory = &memory;
    *document = (mcv_document){0};
    MCV_TRY(mcv_load_file(&loader, path, &loader.bytes, &loader.file, error));
    const mcv_result result = check_format(path, &loader.file, error);
    if (result == MCV_OK) return open_document(&loader, document, error);
    free(loader.bytes.data);
    return result;
}

mcv_result mcv_document_parse(const char *path, const char *json, size_t size,
                              mcv_document *document, mcv_error *error) {
    mcv_memory memory = {.limit = mcv_memory_default()};
    mcv_loader loader = new_loader(path, NULL);
    loader.memory = &memory;
    *document = (mcv_document){0};
    loader.bytes = (mcv_bytes){malloc(size ? size : 1), size};
    if (!loader.bytes.data) return mcv_fail_memory(&loader.file, error);
    memcpy(loader.bytes.data, json, size);
    mcv_load_count(&loader, json, size);
    return open_document(&loader, document, error);
}

mcv_result mcv_document_copy(const mcv_document *document, mcv_document *copy, mcv_error *error) {
    const mcv_json_path place = mcv_place_file(document->path);
    *copy = (mcv_document){.path = strdup(document->path),
                           .memory = document->memory,
                           .root = json_deep_copy(document->root),
                           .fingerprint = document->fingerprint};
    bool whole = copy->path && copy->root;
    if (whole && document->binary.data) {
        copy->file = copy->binary =
            (mcv_bytes){malloc(document->binary.size + 1), document->binary.size};
        whole = copy->file.data;
        if (whole) memcpy(copy->file.data, document->binary.data, document->binary.size);
    }
    if (whole) return MCV_OK;
    mcv_document_free(copy);
    return mcv_fail_memory(&place, error);
}

void mcv_document_free(mcv_document *document) {
    json_decref(document->root);
    free(document->file.data);
    free(document->path);
    *document = (mcv_document){0};
}
