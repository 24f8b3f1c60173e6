/* SPDX-License-Identifier: Apache-2.0 */
/* A glTF document to a scene: read, split, parse, override, validate, open buffers, then walk the
 * nodes. */
#include "loader/load.h"

#include "core/basics.h"
#include "scene/emitters.h"
#include "loader/overrides.h"
#include "scene/params.h"
#include "scene/transform.h"
#include "loader/validate.h"

#include <stdlib.h>

/* Extensions that are read; a file may require no other. */
static const char *const known_extensions[] = {"MCVISI_sensors",
                                               "MCVISI_emitters",
                                               "MCVISI_materials",
                                               "MCVISI_assets",
                                               "MCVISI_pose",
                                               "MCVISI_surfaces",
                                               "KHR_materials_transmission",
                                               "KHR_materials_volume",
                                               "KHR_materials_ior",
                                               "KHR_materials_emissive_strength",
                                               "KHR_lights_punctual",
                                               "KHR_mesh_quantization",
                                               "KHR_texture_transform",
                                               "KHR_materials_anisotropy",
                                               "KHR_materials_diffuse_transmission",
                                               "KHR_materials_dispersion",
                                               "MCVISI_spectrum"};
static bool is_known(const char *name) {
    for (size_t i = 0; i < sizeof known_extensions / sizeof known_extensions[0]; ++i)
        if (strcmp(known_extensions[i], name) == 0) return true;
    return false;
}

static mcv_result check_extensions(const json_t *root, const mcv_json_path *file,
                                   mcv_error *error) {
    const size_t known = sizeof known_extensions / sizeof known_extensions[0];
    const json_t *required = json_object_get(root, "extensionsRequired");
    for (size_t i = 0; i < json_array_size(required); ++i) {
        const char *name = json_string_value(json_array_get(required, i));
        if (is_known(name)) continue;
        const mcv_json_path place = mcv_json_path_key(file, "extensionsRequired"),
                            here = mcv_place_index(&place, i);
        const char *nearest = mcv_nearest_word(name, known_extensions, known);
        return mcv_fail_at(&here, error, "%s is required, but this program does not read it%s%s",
                           name, nearest ? "; it reads " : ": export without it",
                           nearest ? nearest : "");
    }
    return MCV_OK;
}

/* --- one line about what was ignored
 * ---------------------------------------------------------------------------- */

/* Objects with extras other than a note, below `value`. jansson bounds the depth of a document. */
static size_t count_extras(const json_t *value) {
    size_t count = 0, i;
    const char *key;
    json_t *child;
    if (json_is_object(value)) {
        const json_t *extras = json_object_get(value, "extras");
        const size_t notes = json_object_get(extras, "note") ? 1 : 0;
        if (extras && !(json_is_object(extras) && json_object_size(extras) <= notes)) ++count;
        json_object_foreach((json_t *)value, key, child) {
            if (strcmp(key, "extras") != 0) count += count_extras(child);
        }
    } else if (json_is_array(value)) {
        json_array_foreach(value, i, child) { count += count_extras(child); }
    }
    return count;
}

static mcv_result warn_ignored(mcv_loader *loader, mcv_error *error) {
    const json_t *used = json_object_get(loader->root, "extensionsUsed");
    const size_t extras = count_extras(loader->root);
    char *text = NULL;
    size_t size = 0, unknown = 0;
    FILE *stream = open_memstream(&text, &size);
    if (!stream) return mcv_fail_memory(&loader->file, error);
    for (size_t i = 0; i < json_array_size(used); ++i) {
        const char *name = json_string_value(json_array_get(used, i));
        if (!is_known(name)) fprintf(stream, "%s%s", unknown++ ? ", " : "extensions ", name);
    }
    if (json_array_size(json_object_get(loader->root, "animations")))
        fprintf(stream, "%sanimations", unknown++ ? ", " : "");
    if (json_array_size(json_object_get(loader->root, "skins")))
        fprintf(stream, "%sskins", unknown++ ? ", " : "");
    if (extras) fprintf(stream, "%sextras of %zu objects", unknown++ ? ", " : "", extras);
    fclose(stream);
    const mcv_result result =
        unknown && text ? mcv_scene_warn(loader->scene, error, "ignored: %s", text) : MCV_OK;
    free(text);
    return result;
}

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

/* Directions of float32 are known to 6e-8. */
static const double least_cone = 1e-7;

static mcv_result warn_of_needles(mcv_scene *scene, mcv_error *error) {
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const double half_angle = mcv_emitter_half_angle(&scene->emitters[i]);
        if (half_angle < least_cone)
            MCV_TRY(mcv_scene_warn(
                scene, error,
                "emitter \"%s\": a half-angle of %.3g rad is less than directions are known to (%g "
                "rad), a sensor that "
                "looks into it may see black: let it be wider, or make it a collimatedBeam",
                scene->emitters[i].name, half_angle, least_cone));
    }
    return MCV_OK;
}

/* --- nodes
 * ------------------------------------------------------------------------------------------------------
 */

static mcv_result load_nodes(mcv_loader *loader, const mcv_transform *document, mcv_error *error);

/* The document of an asset below the node that places it. */
static mcv_result place_asset(mcv_loader *asset, const char *name, const mcv_transform *to_world,
                              mcv_error *error) {
    mcv_transform scaled = *to_world;
    for (int i = 0; i < 9; ++i) scaled.m[i] *= asset->unit;
    if (asset->solid != MCV_NONE) {
        const mcv_instance instance = {.name = (char *)name,
                                       .mesh = asset->solid,
                                       .material = asset->asset_material,
                                       .emitter = MCV_NONE,
                                       .to_world = scaled};
        return mcv_scene_add_instance(asset->scene, &instance, error);
    }
    return load_nodes(asset, &scaled, error);
}

/* `document`: the frame of the document's root in the world; `material`: what is put on the node,
 * or MCV_NONE for its own. */
static mcv_result load_node(mcv_loader *loader, uint32_t index, const mcv_transform *document,
                            const mcv_transform *parent, uint32_t material, mcv_error *error) {
    const json_t *nodes = json_object_get(loader->root, "nodes"),
                 *node = json_array_get(nodes, index);
    const mcv_json_path place = mcv_json_path_key(&loader->file, "nodes"),
                        here = mcv_json_path_element(&place, mcv_json_name(node), index);
    mcv_transform local;
    bool posed;
    MCV_TRY(mcv_load_pose(loader, node, 0, &posed, &local, &here, error));
    if (!posed) MCV_TRY(mcv_load_local(node, &local, &here, error));
    const mcv_transform to_world = mcv_transform_compose(posed ? document : parent, &local);
    MCV_TRY(mcv_scene_add_frame(loader->scene, mcv_json_name(node), loader->is_asset, &to_world,
                                error));
    const uint32_t first = loader->scene->instance_count;
    uint32_t mesh;
    if (loader->node_materials && loader->node_materials[index] != MCV_NONE)
        material = loader->node_materials[index];
    MCV_TRY(mcv_json_index(node, "mesh", json_array_size(json_object_get(loader->root, "meshes")),
                           "meshes", &mesh, &here, error));
    if (mesh != MCV_NONE) {
        MCV_TRY(mcv_load_mesh(loader, mesh, error));
        const mcv_loaded_mesh *loaded = loader->meshes + mesh;
        for (uint32_t i = 0; i < loaded->count; ++i) {
            const mcv_instance instance = {.name = (char *)mcv_json_name(node),
                                           .mesh = loaded->first + i,
                                           .material = material == MCV_NONE ? loaded->materials[i]
                                                                            : material,
                                           .to_world = to_world};
            MCV_TRY(mcv_scene_add_instance(loader->scene, &instance, error));
        }
    }
    MCV_TRY(mcv_load_emitter(loader, node, &to_world, first, loader->scene->instance_count, &here,
                             error));
    MCV_TRY(mcv_load_body(loader, node, &to_world, &here, error));
    MCV_TRY(mcv_load_light_path(loader, node, &to_world, &here, error));
    MCV_TRY(mcv_load_sensors(loader, node, &to_world, &here, error));
    mcv_loader *asset;
    MCV_TRY(mcv_load_asset_of(loader, node, &asset, &here, error));
    if (asset) MCV_TRY(place_asset(asset, mcv_json_name(node), &to_world, error));
    const json_t *children = json_object_get(node, "children");
    for (size_t i = 0; i < json_array_size(children); ++i)
        MCV_TRY(load_node(loader, (uint32_t)json_number_value(json_array_get(children, i)),
                          document, &to_world, material, error));
    return MCV_OK;
}

static mcv_result load_nodes(mcv_loader *loader, const mcv_transform *document, mcv_error *error) {
    const json_t *scenes = json_object_get(loader->root, "scenes"),
                 *scene = json_object_get(loader->root, "scene");
    const json_t *nodes =
        json_object_get(json_array_get(scenes, (size_t)json_number_value(scene)), "nodes");
    for (size_t i = 0; i < json_array_size(nodes); ++i)
        MCV_TRY(load_node(loader, (uint32_t)json_number_value(json_array_get(nodes, i)), document,
                          document, MCV_NONE, error));
    return MCV_OK;
}

/* --- document
 * ---------------------------------------------------------------------------------------------------
 */

/* Each word is mixed by multiplication and shift, the size before all. */
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
    if (loader->is_asset && loader->kept) MCV_TRY(mcv_stamp_add(loader, path, place, error));
    MCV_TRY(mcv_file_read(path, bytes, place, error));
    mcv_load_count(loader, bytes->data, bytes->size);
    return MCV_OK;
}

/* What tinygltf asks for: "buffers/3" or "images/5", by the names that describe_data() has given.
 */
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
        bytes->data = calloc(1, 1); /* stands for no data: nothing that is read fits into it */
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
        return mcv_fail_at(&place, error, "\"%s\" has %zu bytes, but byteLength says %zu", uri,
                           bytes->size, length);
    }
    bytes->size = length; /* tinygltf takes no more and no less */
    return MCV_OK;
}

/* A data: URI stays; anything else is asked for by read_external. A longer data: URI raises
 * byteLength, for the same reason. */
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
    if (loader->has_kept_data) return MCV_OK;
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
 * CAD exporters write U+0000 into texts, where those of C end. It becomes the replacement character
 * U+FFFD, so that what is not read does not matter and what is read shows it. Some fill up a GLB's
 * JSON with zeros in place of blanks.
 */
static void replace_nul(mcv_bytes *json) {
    while (json->size > 0 && json->data[json->size - 1] == 0) --json->size;
    for (size_t i = 0; i + 6 <= json->size; ++i) {
        if (json->data[i] != '\\') continue;
        if (memcmp(json->data + i, "\\u0000", 6) == 0) memcpy(json->data + i, "\\ufffd", 6);
        ++i; /* what is escaped begins no escape */
    }
}

/* To a document that holds what glTF asks for. */
static mcv_result parse(mcv_loader *loader, mcv_overrides overrides, mcv_error *error) {
    mcv_bytes json;
    json_error_t wrong;
    MCV_TRY(mcv_glb_split(loader->bytes, &json, &loader->binary, &loader->file, error));
    replace_nul(&json);
    loader->root = json_loadb((const char *)json.data, json.size, JSON_REJECT_DUPLICATES, &wrong);
    if (!loader->root)
        return mcv_fail_at(&loader->file, error, "line %d column %d is no JSON: %s", wrong.line,
                           wrong.column, mcv_json_wrong(&wrong));
    if (!loader->binary.data) { /* all of a .gltf is in the tree now */
        free(loader->bytes.data);
        loader->bytes = (mcv_bytes){NULL, 0};
    }
    MCV_TRY(mcv_overrides_apply(overrides, loader->root, &loader->file, error));
    MCV_TRY(mcv_gltf_validate(loader->root, loader->binary, &loader->file, error));
    return check_extensions(loader->root, &loader->file, error);
}

mcv_result mcv_load_open(mcv_loader *loader, mcv_overrides overrides, mcv_error *error) {
    if (!loader->has_kept_data) MCV_TRY(parse(loader, overrides, error));
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
    return warn_ignored(loader, error);
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
    if (!loader->has_kept_data) mcv_gltf_close(loader->gltf);
    mcv_stamps_free(loader->stamps, loader->stamp_count);
    json_decref(loader->root);
    free(loader->bytes.data);
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
                "must be a length as in \"587.6nm\", or three, for red, green and blue");
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

/* Files that are parts, and formats that are not read, by their names. */
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
    return mcv_scene_load_again(path, overrides, NULL, scene, error);
}

mcv_result mcv_scene_load_again(const char *path, mcv_overrides overrides, mcv_asset_cache *kept,
                                mcv_scene **scene, mcv_error *error) {
    mcv_loader loader = {.file = mcv_place_file(path),
                         .solid = MCV_NONE,
                         .asset_material = MCV_NONE,
                         .plain = MCV_NONE,
                         .absorber = MCV_NONE,
                         .kept = kept};
    if (kept) mcv_kept_forget_changed(kept);
    *scene = loader.scene = mcv_scene_new(path);
    if (!loader.scene) return mcv_fail_memory(&loader.file, error);
    const mcv_transform world = mcv_transform_identity();
    mcv_result result = mcv_load_file(&loader, path, &loader.bytes, &loader.file, error);
    if (result == MCV_OK) result = check_format(path, &loader.file, error);
    if (result == MCV_OK) result = mcv_load_open(&loader, overrides, error);
    if (result == MCV_OK) result = load_spectrum(&loader, error);
    if (result == MCV_OK) result = load_nodes(&loader, &world, error);
    if (result == MCV_OK) mcv_scene_settle_spectra(*scene);
    if (result == MCV_OK) result = warn_unused(&loader, error);
    if (result == MCV_OK) result = warn_of_needles(*scene, error);
    (*scene)->fingerprint = loader.fingerprint;
    mcv_load_finish(&loader);
    if (result == MCV_OK) return MCV_OK;
    mcv_scene_free(*scene);
    *scene = NULL;
    return result;
}
