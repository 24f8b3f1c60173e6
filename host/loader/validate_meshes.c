/* SPDX-License-Identifier: Apache-2.0 */
#include "loader/validate.h"

#include "loader/accessor.h"

#include "mcvisi/dialect.h"

static mcv_result check_accessor(const json_t *root, const json_t *object, mcv_bytes binary,
                                 const mcv_json_path *place, mcv_error *error) {
    (void)binary;
    mcv_accessor accessor;
    return mcv_accessor_check(root, object, &accessor, place, error);
}

/* Attributes that are read must have their glTF type; KHR_mesh_quantization adds integers for
 * positions and normals. */
static mcv_result check_attribute(const char *key, const mcv_accessor *accessor,
                                  const mcv_json_path *place, mcv_error *error) {
    const bool floats = accessor->component_type == MCV_GLTF_FLOAT;
    const bool integers = accessor->component_type < MCV_GLTF_UNSIGNED_INT;
    if (strcmp(key, "POSITION") == 0 || strcmp(key, "NORMAL") == 0) {
        if (accessor->components == 3 && (floats || integers)) return MCV_OK;
        return mcv_fail_at(place, error, "must be a VEC3 of floats, or of 8- or 16-bit integers");
    }
    if (strcmp(key, "TEXCOORD_0") == 0 || strcmp(key, "TEXCOORD_1") == 0) {
        if (accessor->components == 2 && (floats || integers)) return MCV_OK;
        return mcv_fail_at(place, error, "must be a VEC2 of floats, or of 8- or 16-bit integers");
    }
    return MCV_OK;
}

static mcv_result check_attributes(const json_t *root, json_t *attributes,
                                   const mcv_json_path *place, mcv_error *error) {
    uint64_t count = 0;
    const char *key;
    json_t *value;
    json_object_foreach(attributes, key, value) {
        mcv_accessor accessor;
        bool given;
        const mcv_json_path here = mcv_json_path_key(place, key);
        MCV_TRY(mcv_accessor_get(root, attributes, key, &given, &accessor, place, error));
        MCV_TRY(check_attribute(key, &accessor, &here, error));
        if (accessor.elements.view != MCV_NONE &&
            (accessor.elements.offset % 4 != 0 || accessor.elements.stride % 4 != 0))
            return mcv_fail_at(
                &here, error,
                "its elements must begin at multiples of 4 bytes, not at byte %llu and every %llu",
                (unsigned long long)accessor.elements.offset,
                (unsigned long long)accessor.elements.stride);
        if (count == 0) count = accessor.count;
        if (accessor.count != count)
            return mcv_fail_at(
                &here, error,
                "has %llu elements, but must have as many as the other attributes: %llu",
                (unsigned long long)accessor.count, (unsigned long long)count);
    }
    return MCV_OK;
}

int mcv_texcoord_set(const json_t *info) {
    const json_t *moved =
        json_object_get(mcv_json_extension(info, "KHR_texture_transform"), "texCoord");
    return (int)fmin(fmax(json_number_value(moved ? moved : json_object_get(info, "texCoord")), 0),
                     1000);
}

/* The set of texture coordinates that the material's textures ask for but the attributes lack; -1
 * if there is none. */
static int missing_texcoord(const json_t *material, const json_t *attributes) {
    const json_t *core = json_object_get(material, "pbrMetallicRoughness");
    const json_t *infos[] = {json_object_get(core, "baseColorTexture"),
                             json_object_get(core, "metallicRoughnessTexture"),
                             json_object_get(material, "emissiveTexture")};
    for (int i = 0; i < 3; ++i) {
        const int set = mcv_texcoord_set(infos[i]);
        char name[32];
        snprintf(name, sizeof name, "TEXCOORD_%d", set);
        if (infos[i] && !json_object_get(attributes, name)) return set;
    }
    return -1;
}

static mcv_result check_primitive(const json_t *root, const json_t *primitive,
                                  const mcv_json_path *place, mcv_error *error) {
    json_t *attributes;
    mcv_accessor accessor;
    bool given;
    uint64_t mode = 4;
    uint32_t material;
    const json_t *materials = json_object_get(root, "materials");
    const mcv_json_path here = mcv_json_path_key(place, "attributes"),
                        indices = mcv_json_path_key(place, "indices");
    if (!json_is_object(primitive)) return mcv_fail_at(place, error, "must be an object");
    MCV_TRY(mcv_json_object(primitive, "attributes", &attributes, place, error));
    if (json_object_size(attributes) == 0) return mcv_fail_at(place, error, "must have attributes");
    MCV_TRY(check_attributes(root, attributes, &here, error));
    MCV_TRY(mcv_json_uint(primitive, "mode", 0, 6, &mode, place, error));
    MCV_TRY(mcv_json_index(primitive, "material", json_array_size(materials), "materials",
                           &material, place, error));
    MCV_TRY(mcv_accessor_get(root, primitive, "indices", &given, &accessor, place, error));
    if (given && (accessor.components != 1 || (accessor.component_type != MCV_GLTF_UNSIGNED_BYTE &&
                                               accessor.component_type != MCV_GLTF_UNSIGNED_SHORT &&
                                               accessor.component_type != MCV_GLTF_UNSIGNED_INT)))
        return mcv_fail_at(&indices, error, "must be a SCALAR of unsigned integers");
    if (given && (accessor.normalized || accessor.elements.has_stride))
        return mcv_fail_at(&indices, error, "must not be normalized, nor have a byteStride");
    const int missing = material == MCV_NONE
                            ? -1
                            : missing_texcoord(json_array_get(materials, material), attributes);
    if (missing >= 0)
        return mcv_fail_at(&here, error, "must have TEXCOORD_%d for the texture of its material %u",
                           missing, material);
    return MCV_OK;
}

static mcv_result check_mesh(const json_t *root, const json_t *mesh, mcv_bytes binary,
                             const mcv_json_path *place, mcv_error *error) {
    (void)binary;
    json_t *primitives;
    const mcv_json_path here = mcv_json_path_key(place, "primitives");
    MCV_TRY(mcv_json_array(mesh, "primitives", &primitives, place, error));
    if (!primitives) return mcv_fail_at(place, error, "must have primitives");
    for (size_t i = 0; i < json_array_size(primitives); ++i) {
        const mcv_json_path primitive = mcv_place_index(&here, i);
        MCV_TRY(check_primitive(root, json_array_get(primitives, i), &primitive, error));
    }
    return MCV_OK;
}

mcv_result mcv_validate_meshes(const json_t *root, const mcv_json_path *file, mcv_error *error) {
    const mcv_bytes none = {NULL, 0};
    MCV_TRY(mcv_validate_each(root, "accessors", check_accessor, none, file, error));
    return mcv_validate_each(root, "meshes", check_mesh, none, file, error);
}
