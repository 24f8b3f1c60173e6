/* SPDX-License-Identifier: Apache-2.0 */
/* glTF primitives to triangle meshes. */
#include "loader/loader.h"

#include "scene/materials.h"
#include "scene/memory.h"
#include "scene/mesh.h"

#include <math.h>
#include <stdlib.h>

enum { MODE_TRIANGLES = 4, MODE_STRIP = 5, MODE_FAN = 6 };

/* The vertices of triangle t in a list of vertices, as glTF 2.0 3.7.2.1 numbers them. */
static void triangle_at(uint64_t mode, uint64_t t, uint64_t vertices[3]) {
    if (mode == MODE_TRIANGLES) {
        for (int i = 0; i < 3; ++i) vertices[i] = 3 * t + (uint64_t)i;
    } else if (mode == MODE_STRIP) {
        vertices[0] = t;
        vertices[1] = t + 1 + t % 2;
        vertices[2] = t + 2 - t % 2;
    } else {
        vertices[0] = t + 1;
        vertices[1] = t + 2;
        vertices[2] = 0;
    }
}

/*
 * Makes triangles of `count` vertices (of the list, or in their order if list is NULL). Strips are
 * joined by degenerate triangles, which are dropped. Takes ownership of `list`.
 */
static mcv_result make_triangles(mcv_memory *memory, uint64_t mode, uint64_t count, uint32_t *list,
                                 mcv_mesh *mesh, const mcv_json_path *place, mcv_error *error) {
    const uint64_t triangles = mode == MODE_TRIANGLES ? count / 3 : count < 3 ? 0 : count - 2;
    if (triangles > INT32_MAX) {
        free(list);
        return mcv_fail_at(place, error, "%llu triangles are more than %d",
                           (unsigned long long)triangles, INT32_MAX);
    }
    if (mode == MODE_TRIANGLES && list) {
        mesh->indices = list;
        mesh->triangle_count = (uint32_t)triangles;
        return MCV_OK;
    }
    const uint64_t bytes = 3 * triangles * sizeof *mesh->indices;
    mcv_result result = mcv_memory_take(memory, &memory->geometry, bytes, place, error);
    if (result == MCV_OK && !(mesh->indices = malloc(bytes + 1)))
        result = mcv_fail_memory(place, error);
    if (result != MCV_OK) {
        free(list);
        return result;
    }
    for (uint64_t t = 0; t < triangles; ++t) {
        uint32_t *triangle = mesh->indices + 3 * (size_t)mesh->triangle_count;
        uint64_t at[3];
        triangle_at(mode, t, at);
        for (int i = 0; i < 3; ++i) triangle[i] = list ? list[at[i]] : (uint32_t)at[i];
        if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
            ++mesh->triangle_count;
    }
    free(list);
    return MCV_OK;
}

static mcv_result read_attribute(const mcv_loader *loader, const json_t *attributes,
                                 const char *key, float **values, uint64_t *count,
                                 const mcv_json_path *place, mcv_error *error) {
    mcv_accessor accessor;
    bool given;
    const mcv_json_path here = mcv_json_path_key(place, key);
    MCV_TRY(mcv_accessor_get(loader->root, attributes, key, &given, &accessor, place, error));
    if (!given) return MCV_OK;
    *count = accessor.count;
    return mcv_accessor_floats(loader->gltf, &accessor, values, &here, error);
}

static mcv_result read_indices(const mcv_loader *loader, const json_t *primitive, uint32_t **list,
                               uint64_t *count, const mcv_json_path *place, mcv_error *error) {
    mcv_accessor accessor;
    bool given;
    const mcv_json_path here = mcv_json_path_key(place, "indices");
    MCV_TRY(mcv_accessor_get(loader->root, primitive, "indices", &given, &accessor, place, error));
    if (!given) return MCV_OK;
    *count = accessor.count;
    MCV_TRY(mcv_accessor_indices(loader->gltf, &accessor, list, &here, error));
    const uint32_t restart = accessor.component_type == MCV_GLTF_UNSIGNED_BYTE    ? UINT8_MAX
                             : accessor.component_type == MCV_GLTF_UNSIGNED_SHORT ? UINT16_MAX
                                                                                  : UINT32_MAX;
    for (uint64_t i = 0; i < *count; ++i)
        if ((*list)[i] == restart)
            return mcv_fail_at(&here, error, "%u restarts a primitive, which glTF does not allow",
                               restart);
    return MCV_OK;
}

/* Vertex normals by the asset's crease angle, in place of the file's. */
static mcv_result make_normals(mcv_loader *loader, mcv_mesh *mesh, const mcv_json_path *place,
                               mcv_error *error) {
    const uint64_t floats =
        3 + 3 + (mesh->texcoords ? 2 : 0) + (mesh->texcoords1 ? 2 : 0) + (mesh->tangents ? 4 : 0);
    MCV_TRY(mcv_memory_take(loader->memory, &loader->memory->geometry,
                            3 * floats * sizeof(float) * mesh->triangle_count, place, error));
    return mcv_mesh_make_normals(mesh, loader->crease_angle, place, error);
}

/* Reads the arrays of one primitive; on failure the caller frees them. */
static mcv_result read_primitive(mcv_loader *loader, const json_t *primitive, uint64_t mode,
                                 bool needs_tangents, mcv_mesh *mesh, const mcv_json_path *place,
                                 mcv_error *error) {
    const json_t *attributes = json_object_get(primitive, "attributes");
    const mcv_json_path here = mcv_json_path_key(place, "attributes");
    uint64_t vertices = 0;
    MCV_TRY(
        read_attribute(loader, attributes, "POSITION", &mesh->positions, &vertices, &here, error));
    MCV_TRY(read_attribute(loader, attributes, "NORMAL", &mesh->normals, &vertices, &here, error));
    if (needs_tangents)
        MCV_TRY(read_attribute(loader, attributes, "TANGENT", &mesh->tangents, &vertices, &here,
                               error));
    MCV_TRY(read_attribute(loader, attributes, "TEXCOORD_0", &mesh->texcoords, &vertices, &here,
                           error));
    MCV_TRY(read_attribute(loader, attributes, "TEXCOORD_1", &mesh->texcoords1, &vertices, &here,
                           error));
    mesh->vertex_count = (uint32_t)vertices;
    uint64_t listed = vertices;
    uint32_t *list = NULL;
    const mcv_result result = read_indices(loader, primitive, &list, &listed, place, error);
    if (result != MCV_OK) {
        free(list);
        return result;
    }
    MCV_TRY(make_triangles(loader->memory, mode, listed, list, mesh, place, error));
    if (mode == MODE_TRIANGLES && listed % 3 != 0)
        MCV_TRY(mcv_scene_warn(loader->scene, error,
                               "mesh \"%s\": %u vertices at its end make no triangle", mesh->name,
                               (unsigned)(listed % 3)));
    uint32_t repaired;
    MCV_TRY(mcv_mesh_check(mesh, &repaired, place, error));
    if (!isnan(loader->crease_angle)) return make_normals(loader, mesh, place, error);
    return repaired ? mcv_scene_warn(
                          loader->scene, error,
                          "mesh \"%s\": %u normals of length 0 are replaced by those of the faces",
                          mesh->name, repaired)
                    : MCV_OK;
}

static mcv_result load_primitive(mcv_loader *loader, const json_t *primitive,
                                 mcv_loaded_mesh *loaded, const char *name,
                                 const mcv_json_path *place, mcv_error *error) {
    uint64_t mode = MODE_TRIANGLES;
    uint32_t material;
    MCV_TRY(mcv_json_uint(primitive, "mode", 0, MODE_FAN, &mode, place, error));
    if (mode < MODE_TRIANGLES)
        return mcv_scene_warn(loader->scene, error, "mesh \"%s\": points and lines are ignored",
                              name);
    if (!json_object_get(json_object_get(primitive, "attributes"), "POSITION"))
        return mcv_scene_warn(loader->scene, error,
                              "mesh \"%s\": a primitive without POSITION is ignored", name);
    MCV_TRY(mcv_json_index(primitive, "material",
                           json_array_size(json_object_get(loader->root, "materials")), "materials",
                           &material, place, error));
    material = material == MCV_NONE ? loader->asset_material : loader->materials[material];
    if (material == MCV_NONE) MCV_TRY(mcv_load_plain(loader, &material, error));
    const bool directed =
        mcv_material_roughness(&loader->scene->materials[material]).anisotropy > 0;
    mcv_mesh mesh = {.name = strdup(name)};
    const mcv_result result =
        mesh.name ? read_primitive(loader, primitive, mode, directed, &mesh, place, error)
                  : mcv_fail_memory(place, error);
    if (result != MCV_OK) {
        mcv_mesh_free(&mesh);
        return result;
    }
    MCV_TRY(mcv_scene_take_mesh(loader->scene, &mesh, error));
    loaded->materials[loaded->count++] = material;
    return MCV_OK;
}

mcv_result mcv_load_mesh(mcv_loader *loader, uint32_t index, mcv_error *error) {
    mcv_loaded_mesh *loaded = loader->meshes + index;
    if (loaded->loaded) return MCV_OK;
    const json_t *mesh = json_array_get(json_object_get(loader->root, "meshes"), index);
    const json_t *primitives = json_object_get(mesh, "primitives");
    const mcv_json_path meshes = mcv_json_path_key(&loader->file, "meshes"),
                        place = mcv_json_path_element(&meshes, mcv_json_name(mesh), index);
    const mcv_json_path here = mcv_json_path_key(&place, "primitives");
    loaded->first = loader->scene->mesh_count;
    loaded->materials = malloc(json_array_size(primitives) * sizeof *loaded->materials);
    if (!loaded->materials) return mcv_fail_memory(&here, error);
    for (size_t i = 0; i < json_array_size(primitives); ++i) {
        const mcv_json_path primitive = mcv_place_index(&here, i);
        MCV_TRY(load_primitive(loader, json_array_get(primitives, i), loaded, mcv_json_name(mesh),
                               &primitive, error));
    }
    loaded->loaded = true;
    return MCV_OK;
}
