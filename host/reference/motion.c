/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/motion.h"

/* By the angle about the unit axis a. */
static ref_vec turned(ref_vec a, double angle, ref_vec p) {
    const ref_vec along = ref_scale(ref_dot(a, p), a), aside = ref_sub(p, along);
    return ref_add(
        along, ref_add(ref_scale(cos(angle), aside), ref_scale(sin(angle), ref_cross(a, aside))));
}

ref_vec ref_moved_direction(const mcv_node_motion *motion, double time, ref_vec direction) {
    return turned(ref_from(motion->axis), motion->rate * time, direction);
}

ref_vec ref_moved_point(const mcv_node_motion *motion, double time, ref_vec point) {
    const ref_vec centre = ref_from(motion->centre);
    return ref_add(ref_add(centre, ref_moved_direction(motion, time, ref_sub(point, centre))),
                   ref_scale(time, ref_from(motion->velocity)));
}

ref_vec ref_direction_at_rest(const mcv_node_motion *motion, double time, ref_vec direction) {
    return turned(ref_from(motion->axis), -motion->rate * time, direction);
}

ref_vec ref_point_at_rest(const mcv_node_motion *motion, double time, ref_vec point) {
    const ref_vec centre = ref_from(motion->centre),
                  way = ref_scale(time, ref_from(motion->velocity));
    return ref_add(centre,
                   ref_direction_at_rest(motion, time, ref_sub(ref_sub(point, way), centre)));
}
