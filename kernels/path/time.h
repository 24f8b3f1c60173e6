/* SPDX-License-Identifier: Apache-2.0 */
/* The world at the time of a path: parts move. */
#ifndef MCVISI_KERNELS_TIME_H
#define MCVISI_KERNELS_TIME_H

#include "path/camera_path.h"
#include "world.h"

/* A stage calls it before it looks for triangles or works out where one is. */
MCV_LOOP_FUNCTION mcv_world mcv_at_time(mcv_world world, mcv_slot slot) {
#if MCV_WITH_MOVING
    world.pose = mcv_pose_at(&world.frame->part_motion, MCV_LOAD(slot, time, 0));
#else
    (void)slot;
#endif
    return world;
}

#endif
