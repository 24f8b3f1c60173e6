/* SPDX-License-Identifier: Apache-2.0 */
/* MCVISI_motion of a node. */
#include "loader/loader.h"

#include <math.h>
#include <string.h>

#include "scene/motion.h"

static mcv_result check_keys(const json_t *motion, const mcv_json_path *here, mcv_error *error) {
    static const char *const known[] = {"velocity", "axis", "centre", "rate", "extras"};
    enum { KNOWN = sizeof known / sizeof known[0] };
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)motion, key, value) {
        bool is_known = false;
        for (int i = 0; i < KNOWN; ++i) is_known = is_known || strcmp(known[i], key) == 0;
        const char *nearest = is_known ? NULL : mcv_nearest_word(key, known, KNOWN);
        if (!is_known)
            return mcv_fail_at(here, error,
                               "unknown key \"%s\"%s%s: known are velocity, axis, centre, rate",
                               key, nearest ? "; did you mean " : "", nearest ? nearest : "");
    }
    return MCV_OK;
}

mcv_result mcv_load_motion(const json_t *node, mcv_node_motion *motion, const mcv_json_path *place,
                           mcv_error *error) {
    json_t *object = mcv_json_extension(node, "MCVISI_motion");
    const mcv_json_path here = mcv_json_path_key(place, "MCVISI_motion"),
                        axis = mcv_json_path_key(&here, "axis");
    *motion = (mcv_node_motion){0};
    if (!object) return MCV_OK;
    if (!json_is_object(object)) return mcv_fail_at(&here, error, "must be an object");
    MCV_TRY(check_keys(object, &here, error));
    MCV_TRY(mcv_json_numbers(object, "velocity", 3, -1e6, 1e6, motion->velocity, &here, error));
    MCV_TRY(mcv_json_numbers(object, "axis", 3, -1e6, 1e6, motion->axis, &here, error));
    MCV_TRY(mcv_json_numbers(object, "centre", 3, -1e6, 1e6, motion->centre, &here, error));
    MCV_TRY(mcv_json_number(object, "rate", -1e9, 1e9, &motion->rate, &here, error));
    const double length =
        sqrt(motion->axis[0] * motion->axis[0] + motion->axis[1] * motion->axis[1] +
             motion->axis[2] * motion->axis[2]);
    if (motion->rate != 0 && !(length > 0))
        return mcv_fail_at(&axis, error, "is missing: a rate needs an axis [x, y, z]");
    for (int i = 0; i < 3 && length > 0; ++i) motion->axis[i] /= length;
    return MCV_OK;
}

mcv_result mcv_load_part_motion(mcv_loader *loader, const json_t *node, const mcv_json_path *place,
                                mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, "MCVISI_motion");
    mcv_node_motion *all = &loader->scene->part_motion, motion;
    if (json_object_get(node, "camera") || mcv_json_extension(node, "MCVISI_sensors"))
        return MCV_OK;
    MCV_TRY(mcv_load_motion(node, &motion, place, error));
    if (!mcv_moves(&motion)) return MCV_OK;
    if (loader->moves)
        return mcv_fail_at(&here, error, "is below a node that moves: give one of them a motion");
    if (mcv_moves(all) && memcmp(all, &motion, sizeof motion) != 0)
        return mcv_fail_at(&here, error,
                           "is another motion than that of a node before: all parts that move do "
                           "so in one way");
    *all = motion;
    loader->moves = true;
    return MCV_OK;
}
