/* SPDX-License-Identifier: Apache-2.0 */
/* Where a motion has brought points at a time (mcvisi/motion.h), and back. */
#ifndef MCVISI_HOST_REFERENCE_MOTION_H
#define MCVISI_HOST_REFERENCE_MOTION_H

#include "reference/vector.h"
#include "scene/scene.h"

ref_vec ref_moved_direction(const mcv_node_motion *motion, double time, ref_vec direction);
ref_vec ref_moved_point(const mcv_node_motion *motion, double time, ref_vec point);
ref_vec ref_direction_at_rest(const mcv_node_motion *motion, double time, ref_vec direction);
ref_vec ref_point_at_rest(const mcv_node_motion *motion, double time, ref_vec point);

#endif
