/* SPDX-License-Identifier: Apache-2.0 */
/* Time of sensors (mcvisi/motion.h), in double. */
#ifndef MCVISI_HOST_SCENE_MOTION_H
#define MCVISI_HOST_SCENE_MOTION_H

#include "core/json_path.h"
#include "mcvisi/motion.h"
#include "scene/scene.h"

/* The parameters of MCV_TIME_PARAMS: times in s, 0 where none is given. */
typedef struct mcv_exposure {
    int shutter; /* MCV_SHUTTER_… */
    double time, line_time, strobe_delay, strobe_time;
    uint32_t stages;
    double jitter, ripple;   /* of the encoder [s] */
    double ripples_per_line; /* 0 without a ripple */
    uint32_t seed;           /* of the jitter */
} mcv_exposure;

/* Of a sensor; all 0 where it has no such parameters. */
mcv_exposure mcv_sensor_exposure(const mcv_sensor *sensor);

bool mcv_moves(const mcv_node_motion *motion);

/* Does what a sensor sees depend on the time? */
bool mcv_needs_time(const mcv_scene *scene, const mcv_sensor *sensor);

/* Fills in defaults; refuses what the shutter does not have. */
mcv_result mcv_sensor_resolve_exposure(mcv_sensor *sensor, const mcv_json_path *place,
                                       mcv_error *error);

/* For the device. `origin`: the world's point that is the device's origin. */
void mcv_motion_prepare(const mcv_sensor *sensor, mcv_motion *device);
void mcv_part_motion_prepare(const mcv_scene *scene, const double origin[3],
                             mcv_rigid_motion *device);

#endif
