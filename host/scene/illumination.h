/* SPDX-License-Identifier: Apache-2.0 */
/* The fall-off of a real telecentric lens, by the table of its datasheet. */
#ifndef MCVISI_HOST_SCENE_ILLUMINATION_H
#define MCVISI_HOST_SCENE_ILLUMINATION_H

#include "scene/sensors.h"

/* Refuses a table that does not reach the film's farthest corner, or without irradiance. */
mcv_result mcv_illumination_check(const mcv_telecentric_params *params, const mcv_readout *readout,
                                  const mcv_json_path *place, mcv_error *error);

/* For the device, h: the film's distance from the stop. */
void mcv_illumination_prepare(const mcv_curve *curve, double h, mcv_distortion *device);

#endif
