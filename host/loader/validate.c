/* SPDX-License-Identifier: Apache-2.0 */
#include "loader/validate.h"

#include "mcvisi/dialect.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>

mcv_result mcv_validate_each(const json_t *root, const char *of, mcv_validate_one *check,
                             mcv_bytes binary, const mcv_json_path *file, mcv_error *error) {
    const json_t *array = json_object_get(root, of);
    const mcv_json_path place = mcv_json_path_key(file, of);
    for (size_t i = 0; i < json_array_size(array); ++i) {
        const mcv_json_path here = mcv_place_index(&place, i);
        MCV_TRY(check(root, json_array_get(array, i), binary, &here, error));
    }
    return MCV_OK;
}

static mcv_result check_collections(const json_t *root, const mcv_json_path *file,
                                    mcv_error *error) {
    static const char *const objects[] = {
        "accessors", "animations", "buffers",  "bufferViews", "cameras", "images",  "materials",
        "meshes",    "nodes",      "samplers", "scenes",      "skins",   "textures"};
    static const char *const strings[] = {"extensionsUsed", "extensionsRequired"};
    json_t *array;
    for (size_t k = 0; k < sizeof objects / sizeof objects[0]; ++k) {
        const mcv_json_path place = mcv_json_path_key(file, objects[k]);
        MCV_TRY(mcv_json_array(root, objects[k], &array, file, error));
        for (size_t i = 0; i < json_array_size(array); ++i) {
            const mcv_json_path here = mcv_place_index(&place, i);
            if (!json_is_object(json_array_get(array, i)))
                return mcv_fail_at(&here, error, "must be an object");
        }
    }
    for (size_t k = 0; k < 2; ++k) {
        const mcv_json_path place = mcv_json_path_key(file, strings[k]);
        MCV_TRY(mcv_json_array(root, strings[k], &array, file, error));
        for (size_t i = 0; i < json_array_size(array); ++i) {
            const mcv_json_path here = mcv_place_index(&place, i);
            if (!json_is_string(json_array_get(array, i)))
                return mcv_fail_at(&here, error, "must be a string");
        }
    }
    return mcv_json_object(root, "extensions", &array, file, error);
}

/* "2.0" and nothing else; false where the text is no version. */
static bool read_version(const char *text, unsigned *major, unsigned *minor) {
    int end = -1;
    // NOLINTNEXTLINE(cert-err34-c): five digits always fit
    return sscanf(text, "%5u.%5u%n", major, minor, &end) == 2 && end == (int)strlen(text) &&
           text[0] != '+' && text[0] != '-';
}

static mcv_result check_asset(const json_t *root, const mcv_json_path *file, mcv_error *error) {
    json_t *asset;
    const char *version = NULL, *least = "2.0";
    unsigned major, minor, least_major, least_minor;
    const mcv_json_path here = mcv_json_path_key(file, "asset");
    MCV_TRY(mcv_json_object(root, "asset", &asset, file, error));
    MCV_TRY(mcv_json_string(asset, "version", &version, &here, error));
    MCV_TRY(mcv_json_string(asset, "minVersion", &least, &here, error));
    if (!version) return mcv_fail_at(file, error, "must have \"asset\": {\"version\": \"2.0\"}");
    if (!read_version(version, &major, &minor) || major != 2)
        return mcv_fail_at(&here, error, "version \"%.32s\" must be 2.x", version);
    if (!read_version(least, &least_major, &least_minor) || least_major != 2 || least_minor > 0)
        return mcv_fail_at(&here, error,
                           "minVersion \"%.32s\" must be 2.0: this program reads glTF 2.0", least);
    return MCV_OK;
}

/* --- nodes and scenes --- */

static mcv_result check_transform(const json_t *node, const mcv_json_path *place,
                                  mcv_error *error) {
    double translation[3] = {0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1}, matrix[16];
    MCV_TRY(mcv_json_numbers(node, "translation", 3, -DBL_MAX, DBL_MAX, translation, place, error));
    MCV_TRY(mcv_json_numbers(node, "rotation", 4, -1, 1, rotation, place, error));
    MCV_TRY(mcv_json_numbers(node, "scale", 3, -DBL_MAX, DBL_MAX, scale, place, error));
    MCV_TRY(mcv_json_numbers(node, "matrix", 16, -DBL_MAX, DBL_MAX, matrix, place, error));
    /* Files write four digits or more. */
    const double length = sqrt(rotation[0] * rotation[0] + rotation[1] * rotation[1] +
                               rotation[2] * rotation[2] + rotation[3] * rotation[3]);
    if (fabs(length - 1) > 1e-3)
        return mcv_fail_at(place, error, "rotation must be a quaternion of length 1, not %g",
                           length);
    if (!json_object_get(node, "matrix")) return MCV_OK;
    if (json_object_get(node, "translation") || json_object_get(node, "rotation") ||
        json_object_get(node, "scale"))
        return mcv_fail_at(
            place, error,
            "has a matrix and a translation, rotation or scale: give one or the other");
    if (matrix[3] != 0 || matrix[7] != 0 || matrix[11] != 0 || matrix[15] != 1)
        return mcv_fail_at(place, error,
                           "the last row of its matrix must be 0 0 0 1 (every fourth number)");
    for (int i = 0; i < 3; ++i) {
        const double *a = matrix + 4 * i, *b = matrix + 4 * ((i + 1) % 3);
        const double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        const double lengths = hypot(hypot(a[0], a[1]), a[2]) * hypot(hypot(b[0], b[1]), b[2]);
        if (!(fabs(dot) <= 1e-3 * lengths))
            return mcv_fail_at(
                place, error,
                "its matrix shears: glTF allows translation, rotation and scale only");
    }
    return MCV_OK;
}

static mcv_result check_node(const json_t *root, const json_t *node, mcv_bytes binary,
                             const mcv_json_path *place, mcv_error *error) {
    (void)binary;
    uint32_t index;
    MCV_TRY(check_transform(node, place, error));
    MCV_TRY(mcv_json_index(node, "camera", json_array_size(json_object_get(root, "cameras")),
                           "cameras", &index, place, error));
    MCV_TRY(mcv_json_index(node, "skin", json_array_size(json_object_get(root, "skins")), "skins",
                           &index, place, error));
    MCV_TRY(mcv_json_index(node, "mesh", json_array_size(json_object_get(root, "meshes")), "meshes",
                           &index, place, error));
    return MCV_OK;
}

/* Index i of an array of node indices. */
static mcv_result node_index(const json_t *array, size_t i, size_t count, uint32_t *index,
                             const mcv_json_path *place, mcv_error *error) {
    const json_t *value = json_array_get(array, i);
    const double number = json_number_value(value);
    const mcv_json_path here = mcv_place_index(place, i);
    if (!json_is_number(value) || !(number >= 0 && number < (double)count) ||
        number != floor(number))
        return mcv_fail_at(&here, error, "must be the index of a node: nodes go from 0 to %zu",
                           count - 1);
    *index = (uint32_t)number;
    return MCV_OK;
}

/* Fills parents[]; a node has one at most. */
static mcv_result find_parents(const json_t *nodes, uint32_t *parents, const mcv_json_path *place,
                               mcv_error *error) {
    const size_t count = json_array_size(nodes);
    for (size_t i = 0; i < count; ++i) parents[i] = MCV_NONE;
    for (size_t i = 0; i < count; ++i) {
        const mcv_json_path here = mcv_place_index(place, i),
                            children_place = mcv_json_path_key(&here, "children");
        json_t *children;
        MCV_TRY(mcv_json_array(json_array_get(nodes, i), "children", &children, &here, error));
        for (size_t k = 0; k < json_array_size(children); ++k) {
            uint32_t child = 0;
            MCV_TRY(node_index(children, k, count, &child, &children_place, error));
            if (parents[child] != MCV_NONE)
                return mcv_fail_at(&children_place, error,
                                   "node %u is a child of node %u already: a node has one parent",
                                   child, parents[child]);
            parents[child] = (uint32_t)i;
        }
    }
    return MCV_OK;
}

static mcv_result check_depths(const uint32_t *parents, size_t count, const mcv_json_path *place,
                               mcv_error *error) {
    for (size_t i = 0; i < count; ++i) {
        int depth = 0;
        for (uint32_t node = parents[i]; node != MCV_NONE; node = parents[node])
            if (++depth > MCV_NODE_DEPTH) {
                const mcv_json_path here = mcv_place_index(place, i);
                return mcv_fail_at(&here, error,
                                   "is its own ancestor, or lies more than %d nodes deep",
                                   MCV_NODE_DEPTH);
            }
    }
    return MCV_OK;
}

/* listed[node]: the last scene that lists it. */
static mcv_result check_scenes(const json_t *root, const uint32_t *parents, uint32_t *listed,
                               size_t count, const mcv_json_path *file, mcv_error *error) {
    const json_t *scenes = json_object_get(root, "scenes");
    const mcv_json_path place = mcv_json_path_key(file, "scenes");
    uint32_t index;
    MCV_TRY(mcv_json_index(root, "scene", json_array_size(scenes), "scenes", &index, file, error));
    for (size_t i = 0; i < count; ++i) listed[i] = MCV_NONE;
    for (size_t i = 0; i < json_array_size(scenes); ++i) {
        const mcv_json_path here = mcv_place_index(&place, i),
                            nodes_place = mcv_json_path_key(&here, "nodes");
        json_t *nodes;
        MCV_TRY(mcv_json_array(json_array_get(scenes, i), "nodes", &nodes, &here, error));
        for (size_t k = 0; k < json_array_size(nodes); ++k) {
            MCV_TRY(node_index(nodes, k, count, &index, &nodes_place, error));
            if (parents[index] != MCV_NONE)
                return mcv_fail_at(&nodes_place, error,
                                   "node %u is a child of node %u, but a scene lists roots", index,
                                   parents[index]);
            if (listed[index] == i)
                return mcv_fail_at(&nodes_place, error, "node %u occurs twice", index);
            listed[index] = (uint32_t)i;
        }
    }
    return MCV_OK;
}

static mcv_result check_nodes(const json_t *root, const mcv_json_path *file, mcv_error *error) {
    const json_t *nodes = json_object_get(root, "nodes");
    const mcv_json_path place = mcv_json_path_key(file, "nodes");
    const size_t count = json_array_size(nodes);
    uint32_t *parents = calloc(2 * count + 1, sizeof *parents);
    if (!parents) return mcv_fail_memory(file, error);
    mcv_result result = find_parents(nodes, parents, &place, error);
    if (result == MCV_OK) result = check_depths(parents, count, &place, error);
    if (result == MCV_OK) result = check_scenes(root, parents, parents + count, count, file, error);
    free(parents);
    return result;
}

/* --- cameras, textures --- */

static mcv_result check_camera(const json_t *root, const json_t *camera, mcv_bytes binary,
                               const mcv_json_path *place, mcv_error *error) {
    (void)root;
    (void)binary;
    const char *type = "";
    json_t *perspective, *orthographic;
    MCV_TRY(mcv_json_string(camera, "type", &type, place, error));
    MCV_TRY(mcv_json_object(camera, "perspective", &perspective, place, error));
    MCV_TRY(mcv_json_object(camera, "orthographic", &orthographic, place, error));
    const bool flat = strcmp(type, "orthographic") == 0;
    if (!flat && strcmp(type, "perspective") != 0)
        return mcv_fail_at(place, error, "type must be \"perspective\" or \"orthographic\"");
    if (flat ? !orthographic || perspective : !perspective || orthographic)
        return mcv_fail_at(place, error, "must have one object \"%s\", like its type", type);
    const json_t *lens = flat ? orthographic : perspective;
    const mcv_json_path here = mcv_json_path_key(place, type);
    double yfov = 0, xmag = 0, ymag = 0, aspect = 1, near = flat ? -1 : 0, far = INFINITY;
    MCV_TRY(mcv_json_number(lens, "yfov", DBL_MIN, nextafter(M_PI, 0), &yfov, &here, error));
    MCV_TRY(mcv_json_number(lens, "aspectRatio", DBL_MIN, DBL_MAX, &aspect, &here, error));
    MCV_TRY(mcv_json_number(lens, "xmag", -DBL_MAX, DBL_MAX, &xmag, &here, error));
    MCV_TRY(mcv_json_number(lens, "ymag", -DBL_MAX, DBL_MAX, &ymag, &here, error));
    MCV_TRY(mcv_json_number(lens, "znear", flat ? 0 : DBL_MIN, DBL_MAX, &near, &here, error));
    MCV_TRY(mcv_json_number(lens, "zfar", DBL_MIN, DBL_MAX, &far, &here, error));
    if (flat && (xmag == 0 || ymag == 0))
        return mcv_fail_at(&here, error, "must have xmag and ymag other than 0");
    if (!flat && yfov == 0) return mcv_fail_at(&here, error, "must have yfov");
    if (near == (flat ? -1 : 0) || (flat && !isfinite(far)))
        return mcv_fail_at(&here, error, "must have %s", flat ? "znear and zfar" : "znear");
    return far > near ? MCV_OK
                      : mcv_fail_at(&here, error, "zfar %g must exceed znear %g", far, near);
}

static mcv_result check_texture(const json_t *root, const json_t *texture, mcv_bytes binary,
                                const mcv_json_path *place, mcv_error *error) {
    (void)binary;
    uint32_t index;
    MCV_TRY(mcv_json_index(texture, "sampler", json_array_size(json_object_get(root, "samplers")),
                           "samplers", &index, place, error));
    return mcv_json_index(texture, "source", json_array_size(json_object_get(root, "images")),
                          "images", &index, place, error);
}

static mcv_result check_sampler(const json_t *root, const json_t *sampler, mcv_bytes binary,
                                const mcv_json_path *place, mcv_error *error) {
    (void)root;
    (void)binary;
    uint64_t filter = 9728, wrap[2] = {10497, 10497};
    MCV_TRY(mcv_json_uint(sampler, "magFilter", 9728, 9729, &filter, place, error));
    MCV_TRY(mcv_json_uint(sampler, "wrapS", 0, UINT32_MAX, wrap, place, error));
    MCV_TRY(mcv_json_uint(sampler, "wrapT", 0, UINT32_MAX, wrap + 1, place, error));
    for (int i = 0; i < 2; ++i)
        if (wrap[i] != 10497 && wrap[i] != 33071 && wrap[i] != 33648)
            return mcv_fail_at(place, error, "wrap mode %u must be 10497, 33071 or 33648",
                               (unsigned)wrap[i]);
    return MCV_OK;
}

mcv_result mcv_gltf_validate(const json_t *root, mcv_bytes binary, const mcv_json_path *file,
                             mcv_error *error) {
    if (!json_is_object(root)) return mcv_fail_at(file, error, "must be a JSON object");
    MCV_TRY(check_asset(root, file, error));
    MCV_TRY(check_collections(root, file, error));
    MCV_TRY(mcv_validate_buffers(root, binary, file, error));
    MCV_TRY(mcv_validate_meshes(root, file, error));
    MCV_TRY(mcv_validate_each(root, "cameras", check_camera, binary, file, error));
    MCV_TRY(mcv_validate_each(root, "textures", check_texture, binary, file, error));
    MCV_TRY(mcv_validate_each(root, "samplers", check_sampler, binary, file, error));
    MCV_TRY(mcv_validate_each(root, "nodes", check_node, binary, file, error));
    return check_nodes(root, file, error);
}
