/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras, nodes, scenes and skins. */
#include "strict/strict_parts.h"

#include <stdlib.h>
#include <string.h>

static void check_camera(mcv_strict *s, const json_t *camera, const mcv_json_path *place) {
    static const char *const magnifications[] = {"xmag", "ymag"};
    const json_t *flat = json_object_get(camera, "orthographic"),
                 *deep = json_object_get(camera, "perspective");
    const mcv_json_path flat_place = mcv_json_path_key(place, "orthographic"),
                        deep_place = mcv_json_path_key(place, "perspective");
    if (!flat == !deep)
        mcv_strict_find(s, "ONE_OF_MISMATCH", place, "must have one of perspective, orthographic");
    for (int i = 0; i < 2; ++i) {
        const json_t *value = json_object_get(flat, magnifications[i]);
        const mcv_json_path here = mcv_json_path_key(&flat_place, magnifications[i]);
        if (json_is_number(value) && json_number_value(value) == 0)
            mcv_strict_find(s, "CAMERA_XMAG_YMAG_ZERO", &here, "must not be 0");
    }
    for (int i = 0; i < 2; ++i) {
        const json_t *lens = i ? deep : flat, *near = json_object_get(lens, "znear"),
                     *far = json_object_get(lens, "zfar");
        if (json_is_number(near) && json_is_number(far) &&
            json_number_value(far) <= json_number_value(near))
            mcv_strict_find(s, "CAMERA_ZFAR_LEQUAL_ZNEAR", i ? &deep_place : &flat_place,
                            "zfar must exceed znear");
    }
}

/* n numbers of an array; false where there are not as many. */
static bool read_numbers(const json_t *object, const char *key, size_t n, double *numbers) {
    const json_t *array = json_object_get(object, key);
    if (json_array_size(array) != n) return false;
    for (size_t i = 0; i < n; ++i) {
        if (!json_is_number(json_array_get(array, i))) return false;
        numbers[i] = json_number_value(json_array_get(array, i));
    }
    return true;
}

/* Whether a matrix is a translation, a rotation and a scale: no shear, and the last row 0 0 0 1. */
static bool is_trs(const double m[16]) {
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) return false;
    for (int i = 0; i < 3; ++i) {
        const double *a = m + 4 * i, *b = m + 4 * ((i + 1) % 3);
        const double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        const double lengths = hypot(hypot(a[0], a[1]), a[2]) * hypot(hypot(b[0], b[1]), b[2]);
        if (!(fabs(dot) <= 1e-3 * lengths) || lengths == 0) return false;
    }
    return true;
}

static size_t target_count(const mcv_strict *s, const json_t *mesh) {
    (void)s;
    const json_t *first = json_array_get(json_object_get(mesh, "primitives"), 0);
    return json_array_size(json_object_get(first, "targets"));
}

static void check_node(mcv_strict *s, const json_t *node, const mcv_json_path *place) {
    const json_t *mesh = mcv_strict_target(s, node, "mesh", "meshes"),
                 *weights = json_object_get(node, "weights");
    const mcv_json_path matrix_place = mcv_json_path_key(place, "matrix"),
                        rotation_place = mcv_json_path_key(place, "rotation"),
                        skin_place = mcv_json_path_key(place, "skin"),
                        weights_place = mcv_json_path_key(place, "weights");
    double m[16], q[4];
    if (json_object_get(node, "matrix") &&
        (json_object_get(node, "translation") || json_object_get(node, "rotation") ||
         json_object_get(node, "scale")))
        mcv_strict_find(s, "NODE_MATRIX_TRS", &matrix_place,
                        "stands beside translation, rotation or scale: give one or the other");
    if (read_numbers(node, "matrix", 16, m) && !is_trs(m))
        mcv_strict_find(s, "NODE_MATRIX_NON_TRS", &matrix_place,
                        "must be a translation, a rotation and a scale");
    /* Files write four digits or more. */
    if (read_numbers(node, "rotation", 4, q) &&
        fabs(hypot(hypot(q[0], q[1]), hypot(q[2], q[3])) - 1) > 1e-3)
        mcv_strict_find(s, "ROTATION_NON_UNIT", &rotation_place, "must have length 1");
    if (json_object_get(node, "skin") && !json_object_get(node, "mesh"))
        mcv_strict_find(s, "UNSATISFIED_DEPENDENCY", &skin_place, "needs a mesh");
    if (weights && !json_object_get(node, "mesh"))
        mcv_strict_find(s, "UNSATISFIED_DEPENDENCY", &weights_place, "needs a mesh");
    if (weights && mesh && json_array_size(weights) != target_count(s, mesh))
        mcv_strict_find(s, "NODE_WEIGHTS_INVALID", &weights_place,
                        "has %zu numbers for %zu morph targets", json_array_size(weights),
                        target_count(s, mesh));
}

/* parents[child]; a second parent is told. */
static void find_parents(mcv_strict *s, size_t *parents, size_t count, const mcv_json_path *place) {
    for (size_t i = 0; i < count; ++i) parents[i] = SIZE_MAX;
    for (size_t i = 0; i < count; ++i) {
        const json_t *children = json_object_get(mcv_strict_item(s, "nodes", i), "children");
        const mcv_json_path here = mcv_place_index(place, i),
                            list = mcv_json_path_key(&here, "children");
        for (size_t k = 0; k < json_array_size(children); ++k) {
            const json_t *value = json_array_get(children, k);
            const double child = json_number_value(value);
            const mcv_json_path there = mcv_place_index(&list, k);
            if (!json_is_number(value) || !(child >= 0 && child < (double)count)) continue;
            size_t *parent = parents + (size_t)child;
            if (*parent != SIZE_MAX && *parent != i)
                mcv_strict_find(s, "NODE_PARENT_OVERRIDE", &there, "node %zu has a parent already",
                                (size_t)child);
            *parent = i;
        }
    }
}

/* A node from which the parents lead back to it. */
static void find_loops(mcv_strict *s, const size_t *parents, size_t count,
                       const mcv_json_path *place) {
    for (size_t i = 0; i < count && count <= 100000; ++i) {
        size_t at = parents[i];
        for (size_t steps = 0; at != SIZE_MAX && at != i && steps < count && steps < 10000; ++steps)
            at = parents[at];
        const mcv_json_path here = mcv_place_index(place, i);
        if (at == i) mcv_strict_find(s, "NODE_LOOP", &here, "is its own ancestor");
    }
}

static void check_scenes(mcv_strict *s, const size_t *parents, size_t count) {
    const mcv_json_path place = mcv_json_path_key(&s->file, "scenes");
    for (size_t i = 0; i < json_array_size(mcv_strict_list(s, "scenes")); ++i) {
        const json_t *nodes = json_object_get(mcv_strict_item(s, "scenes", i), "nodes");
        const mcv_json_path here = mcv_place_index(&place, i),
                            list = mcv_json_path_key(&here, "nodes");
        for (size_t k = 0; k < json_array_size(nodes); ++k) {
            const json_t *value = json_array_get(nodes, k);
            const double node = json_number_value(value);
            const mcv_json_path there = mcv_place_index(&list, k);
            if (json_is_number(value) && node >= 0 && node < (double)count &&
                parents[(size_t)node] != SIZE_MAX)
                mcv_strict_find(s, "SCENE_NON_ROOT_NODE", &there, "has a parent");
        }
    }
}

/* The ancestor without parent; SIZE_MAX for what is no node. */
static size_t root_of(const json_t *index, const size_t *parents, size_t count) {
    const double node = json_number_value(index);
    if (!json_is_number(index) || !(node >= 0 && node < (double)count)) return SIZE_MAX;
    size_t at = (size_t)node;
    for (size_t steps = 0; parents[at] != SIZE_MAX && steps < count; ++steps) at = parents[at];
    return at;
}

static void check_skin(mcv_strict *s, const json_t *skin, const size_t *parents, size_t count,
                       const mcv_json_path *place) {
    const json_t *joints = json_object_get(skin, "joints"),
                 *accessor = mcv_strict_target(s, skin, "inverseBindMatrices", "accessors");
    const mcv_json_path joints_place = mcv_json_path_key(place, "joints"),
                        matrices = mcv_json_path_key(place, "inverseBindMatrices");
    bool common = json_array_size(joints) == 0 ||
                  root_of(json_array_get(joints, 0), parents, count) != SIZE_MAX;
    for (size_t i = 1; i < json_array_size(joints); ++i)
        common = common && root_of(json_array_get(joints, i), parents, count) ==
                               root_of(json_array_get(joints, 0), parents, count);
    if (!common)
        mcv_strict_find(s, "SKIN_NO_COMMON_ROOT", &joints_place, "must have a common ancestor");
    if (!accessor) return;
    if (!mcv_strict_has_format(accessor, "MAT4", "f"))
        mcv_strict_find(s, "SKIN_IBM_INVALID_FORMAT", &matrices, "must be a MAT4 of floats");
    if (mcv_strict_uint(accessor, "count", UINT64_MAX) < json_array_size(joints))
        mcv_strict_find(s, "INVALID_IBM_ACCESSOR_COUNT", &matrices, "has fewer than the joints");
    if (json_object_get(mcv_strict_target(s, accessor, "bufferView", "bufferViews"), "byteStride"))
        mcv_strict_find(s, "SKIN_IBM_ACCESSOR_WITH_BYTESTRIDE", &matrices,
                        "must have no byteStride");
}

void mcv_strict_nodes(mcv_strict *s) {
    const size_t count = json_array_size(mcv_strict_list(s, "nodes"));
    const mcv_json_path cameras = mcv_json_path_key(&s->file, "cameras"),
                        nodes = mcv_json_path_key(&s->file, "nodes"),
                        skins = mcv_json_path_key(&s->file, "skins");
    size_t *parents = malloc((count + 1) * sizeof *parents);
    if (!parents) {
        s->no_memory = true;
        return;
    }
    for (size_t i = 0; i < json_array_size(mcv_strict_list(s, "cameras")); ++i) {
        const json_t *camera = mcv_strict_item(s, "cameras", i);
        const mcv_json_path here = mcv_place_index(&cameras, i);
        if (camera) check_camera(s, camera, &here);
    }
    for (size_t i = 0; i < count; ++i) {
        const json_t *node = mcv_strict_item(s, "nodes", i);
        const mcv_json_path here = mcv_place_index(&nodes, i);
        if (node) check_node(s, node, &here);
    }
    find_parents(s, parents, count, &nodes);
    find_loops(s, parents, count, &nodes);
    check_scenes(s, parents, count);
    for (size_t i = 0; i < json_array_size(mcv_strict_list(s, "skins")); ++i) {
        const json_t *skin = mcv_strict_item(s, "skins", i);
        const mcv_json_path here = mcv_place_index(&skins, i);
        if (skin) check_skin(s, skin, parents, count, &here);
    }
    free(parents);
}
