/* SPDX-License-Identifier: Apache-2.0 */
/* The laser: what its Gaussian beams and fans send through a point. */
#ifndef MCVISI_HOST_REFERENCE_LASER_H
#define MCVISI_HOST_REFERENCE_LASER_H

#include "reference/lights.h"

/* One of the rays through the point, chosen by what they bring; false where the laser sends
 * nothing. */
bool ref_laser_at(const mcv_scene *scene, const mcv_emitter *emitter, ref_vec point,
                  ref_random *random, ref_light *light);

#endif
