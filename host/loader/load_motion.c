/* SPDX-License-Identifier: Apache-2.0 */
/* MCVISI_motion of a sensor's node. */
#include "loader/loader.h"

#include <math.h>
#include <string.h>

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

mcv_result mcv_load_motion(const json_t *node, bool has_sensor, mcv_sensor_motion *motion,
                           const mcv_json_path *place, mcv_error *error) {
    json_t *object = mcv_json_extension(node, "MCVISI_motion");
    const mcv_json_path here = mcv_json_path_key(place, "MCVISI_motion"),
                        axis = mcv_json_path_key(&here, "axis");
    *motion = (mcv_sensor_motion){0};
    if (!object) return MCV_OK;
    if (!json_is_object(object)) return mcv_fail_at(&here, error, "must be an object");
    if (!has_sensor)
        return mcv_fail_at(&here, error,
                           "is on a node without a sensor: parts and lights stand still; let the "
                           "sensor move the other way, which is the same where the light does not "
                           "change along the way");
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
