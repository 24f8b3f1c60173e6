/* SPDX-License-Identifier: Apache-2.0 */
/* MCVISI_misalignment: how a node stands otherwise than it should. */
#include "loader/loader.h"

#include "mcvisi/misalignment.h"
#include "scene/params.h"
#include "scene/transform.h"

#include <math.h>

typedef struct misalignment_params {
    MCV_MISALIGNMENT_PARAMS(MCV_DEFINE_FIELD)
} misalignment_params;

mcv_param_table mcv_misalignment_table(void) {
    typedef misalignment_params element_params;
    static const mcv_param rows[] = {MCV_MISALIGNMENT_PARAMS(MCV_PARAM_ROW)};
    return (mcv_param_table){rows, sizeof rows / sizeof rows[0], sizeof(element_params)};
}

/* A rotation vector as a transform: the quaternion (v̂ sin(|v|/2), cos(|v|/2)). */
static mcv_transform turn(const double v[3]) {
    static const double origin[3] = {0, 0, 0}, ones[3] = {1, 1, 1};
    const double angle = hypot(hypot(v[0], v[1]), v[2]),
                 share = angle > 0 ? sin(angle / 2) / angle : 0;
    const double quaternion[4] = {share * v[0], share * v[1], share * v[2], cos(angle / 2)};
    return mcv_transform_from_trs(origin, quaternion, ones);
}

mcv_result mcv_load_misalignment(const json_t *node, mcv_transform *local,
                                 const mcv_json_path *place, mcv_error *error) {
    static const char *const others[] = {"extras", "extensions", NULL};
    const json_t *object = mcv_json_extension(node, "MCVISI_misalignment");
    const mcv_param_table table = mcv_misalignment_table();
    misalignment_params p;
    if (!object) return MCV_OK;
    if (!json_is_object(object))
        return mcv_fail_at(place, error, "MCVISI_misalignment must be an object");
    mcv_params_set_defaults(table, &p);
    MCV_TRY(mcv_params_parse(table, object, others, &p, place, error));
    MCV_TRY(mcv_params_check(table, &p, place, error));
    const mcv_transform rotation = turn((const double[3]){p.turnX, p.turnY, p.turnZ});
    const double shift[3] = {p.shiftX, p.shiftY, p.shiftZ};
    mcv_transform placed = mcv_transform_compose(&rotation, local);
    for (int i = 0; i < 3; ++i) placed.m[9 + i] = local->m[9 + i] + shift[i];
    *local = placed;
    return MCV_OK;
}
