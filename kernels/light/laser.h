/* SPDX-License-Identifier: Apache-2.0 */
/* Lasers (mcvisi/emitters/laser.h): a shadow ray back to one, and how light paths leave it. */
#ifndef MCVISI_KERNELS_LASER_H
#define MCVISI_KERNELS_LASER_H

#include "light/light_sample.h"

#if MCV_WITH_LASER
/* Back to the exit window, by one of the slopes of the light that goes through the receiver. */
MCV_LOOP_FUNCTION mcv_light_sample mcv_sample_laser(mcv_world world, mcv_receiver at,
                                                    __global const mcv_device_emitter *e,
                                                    mcv_pair pair) {
    const mcv_vec3 from_node = mcv_sub(at.point, mcv_vec_at(e->laser.position));
    const mcv_laser_sight sight =
        mcv_laser_look(&e->laser, world.emitter_cdf + e->cdf, from_node, pair.x, pair.y);
    const mcv_vec3 exit = mcv_add(mcv_vec_at(e->laser.position), sight.exit);
    mcv_light_sample sample =
        mcv_light_sample_along(at, mcv_normalize(mcv_sub(sight.exit, from_node)), MCV_NONE, 0.0f);
    sample.direction = mcv_sub(exit, sample.origin);
    sample.radiance_over_pdf =
        mcv_radiance_over_pdf(e, sight.irradiance > 0.0f, sight.irradiance, e->probability);
    return sample;
}

#if MCV_WITH_LIGHT_TRACING
/* Where a light path leaves, and in which direction; returns its power,
 * relative to the laser's, over its density. */
MCV_FUNCTION float mcv_leave_laser(mcv_world world, uint emitter, mcv_pair place, mcv_pair turn,
                                   mcv_vec3 *origin, mcv_vec3 *direction) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const float xi[4] = {place.x, place.y, turn.x, turn.y};
    mcv_vec3 from_node;
    const float power_over_pdf =
        mcv_laser_leave(&e->laser, world.emitter_cdf + e->cdf, xi, &from_node, direction);
    *origin = mcv_add(mcv_vec_at(e->laser.position), from_node);
    return power_over_pdf;
}
#endif
#endif

#endif
