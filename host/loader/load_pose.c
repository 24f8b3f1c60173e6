/* SPDX-License-Identifier: Apache-2.0 */
/* The transforms of nodes: translation, rotation, scale or matrix relative to their parents, or
 * MCVISI_pose. */
#include "loader/loader.h"

#include "scene/params.h"
#include "scene/transform.h"

mcv_result mcv_load_local(const json_t *node, mcv_transform *transform, const mcv_json_path *place,
                          mcv_error *error) {
    double translation[3] = {0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1}, matrix[16];
    if (json_object_get(node, "matrix")) { /* by columns */
        MCV_TRY(mcv_json_numbers(node, "matrix", 16, -INFINITY, INFINITY, matrix, place, error));
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row)
                transform->m[column < 3 ? 3 * row + column : 9 + row] = matrix[4 * column + row];
        return MCV_OK;
    }
    MCV_TRY(
        mcv_json_numbers(node, "translation", 3, -INFINITY, INFINITY, translation, place, error));
    MCV_TRY(mcv_json_numbers(node, "rotation", 4, -INFINITY, INFINITY, rotation, place, error));
    MCV_TRY(mcv_json_numbers(node, "scale", 3, -INFINITY, INFINITY, scale, place, error));
    /* Files have rounded quaternions; a length other than 1 would scale. */
    const double length = hypot(hypot(rotation[0], rotation[1]), hypot(rotation[2], rotation[3]));
    for (int i = 0; i < 4; ++i) rotation[i] /= length;
    *transform = mcv_transform_from_trs(translation, rotation, scale);
    return MCV_OK;
}

/* --- MCVISI_pose --- */

typedef struct pose_params {
    MCV_POSE_PARAMS(MCV_DEFINE_FIELD)
} pose_params;

mcv_param_table mcv_pose_table(void) {
    typedef pose_params element_params;
    static const mcv_param rows[] = {MCV_POSE_PARAMS(MCV_PARAM_ROW)};
    return (mcv_param_table){rows, sizeof rows / sizeof rows[0], sizeof(element_params)};
}

static mcv_transform stand(const double target[3], const pose_params *pose) {
    const double sa = sin(pose->azimuth), ca = cos(pose->azimuth), se = sin(pose->elevation),
                 ce = cos(pose->elevation);
    const double sr = sin(pose->roll), cr = cos(pose->roll);
    /* Columns x (level), y (up) and z (from the target to the node) before the roll. Straight up is
     * not a special case. */
    const double x[3] = {ca, 0, -sa}, y[3] = {-se * sa, ce, -se * ca},
                 z[3] = {ce * sa, se, ce * ca};
    mcv_transform transform;
    for (int i = 0; i < 3; ++i) {
        transform.m[3 * i] = cr * x[i] + sr * y[i];
        transform.m[3 * i + 1] = cr * y[i] - sr * x[i];
        transform.m[3 * i + 2] = z[i];
        transform.m[9 + i] = target[i] + pose->distance * z[i];
    }
    return transform;
}

/* A point [m], or the origin of a node in the document's frame. */
static mcv_result find_target(mcv_loader *loader, const json_t *pose, int depth, double target[3],
                              const mcv_json_path *place, mcv_error *error) {
    const json_t *nodes = json_object_get(loader->root, "nodes"),
                 *value = json_object_get(pose, "target");
    const mcv_json_path here = mcv_json_path_key(place, "target");
    uint32_t index = MCV_NONE;
    if (json_is_array(value)) {
        if (json_array_size(value) != 3)
            return mcv_fail_at(&here, error, "a point must have 3 coordinates");
        for (size_t i = 0; i < 3; ++i) {
            const json_t *element = json_array_get(value, i);
            target[i] = json_number_value(element);
            if (!json_is_number(element) &&
                (!json_is_string(element) ||
                 !mcv_parse_quantity(json_string_value(element), MCV_PARAM_length, target + i)))
                return mcv_fail_at(
                    &here, error,
                    "coordinate %zu must be a length in metres, or with a unit as in \"25mm\"", i);
        }
        return MCV_OK;
    }
    if (json_is_string(value))
        MCV_TRY(mcv_load_find_node(loader, json_string_value(value), &index, &here, error));
    else
        MCV_TRY(
            mcv_json_index(pose, "target", json_array_size(nodes), "nodes", &index, place, error));
    if (index == MCV_NONE)
        return mcv_fail_at(&here, error, "is missing: the name of a node, its index or a point");
    mcv_transform transform;
    MCV_TRY(mcv_load_transform(loader, index, depth + 1, &transform, error));
    memcpy(target, transform.m + 9, 3 * sizeof *target);
    return MCV_OK;
}

/* Warns of angles without a unit above one turn, which are probably degrees. */
static mcv_result warn_of_degrees(mcv_scene *scene, const json_t *node, const json_t *pose,
                                  const pose_params *params, mcv_error *error) {
    const mcv_param_table table = mcv_pose_table();
    for (size_t i = 0; i < table.count; ++i) {
        const mcv_param *param = table.params + i;
        if (param->kind != MCV_PARAM_angle || !json_is_number(json_object_get(pose, param->key)))
            continue;
        const double angle = *(const double *)mcv_params_find(table, param->key, params);
        if (fabs(angle) > 2 * M_PI)
            MCV_TRY(mcv_scene_warn(
                scene, error,
                "node \"%s\": %s %g has no unit, so it is in radians, %.3g turns: write \"%gdeg\" "
                "for degrees",
                mcv_json_name(node), param->key, angle, angle / (2 * M_PI), angle));
    }
    return MCV_OK;
}

mcv_result mcv_load_pose(mcv_loader *loader, const json_t *node, int depth, bool *posed,
                         mcv_transform *transform, const mcv_json_path *place, mcv_error *error) {
    static const char *const others[] = {"target", "extras", "extensions", NULL};
    const json_t *pose = mcv_json_extension(node, "MCVISI_pose");
    const mcv_param_table table = mcv_pose_table();
    pose_params params;
    double target[3] = {0};
    *posed = pose != NULL;
    if (!pose) return MCV_OK;
    if (!json_is_object(pose)) return mcv_fail_at(place, error, "MCVISI_pose must be an object");
    if (json_object_get(node, "matrix") || json_object_get(node, "translation") ||
        json_object_get(node, "rotation") || json_object_get(node, "scale"))
        return mcv_fail_at(
            place, error,
            "has MCVISI_pose and a translation, rotation, scale or matrix: give one or the other");
    mcv_params_set_defaults(table, &params);
    MCV_TRY(mcv_params_parse(table, pose, others, &params, place, error));
    if (depth == 0) MCV_TRY(warn_of_degrees(loader->scene, node, pose, &params, error));
    MCV_TRY(mcv_params_check(table, &params, place, error));
    MCV_TRY(find_target(loader, pose, depth, target, place, error));
    *transform = stand(target, &params);
    return MCV_OK;
}
