/* SPDX-License-Identifier: Apache-2.0 */
/* Which emitters have light paths, and with what density these start in étendue. */
#ifndef MCVISI_KERNELS_LIGHT_PATH_H
#define MCVISI_KERNELS_LIGHT_PATH_H

#include "mcvisi/light_cone.h"
#include "light/emission.h"

/* Are there light paths of the emitter? Where the frame's light_density is 0 the host launches none
 * at all. */
MCV_LOOP_FUNCTION int mcv_has_light_paths(mcv_world world, uint emitter) {
    return (world.emitters[emitter].light_inverse_pdf > 0.0f) & (world.frame->light_density > 0.0f);
}

#if MCV_HAS_EMISSION
/* The cone into which an emitter's surface emits, or a larger one. */
MCV_LOOP_FUNCTION mcv_cone mcv_emission_cone(__global const mcv_device_emitter *e,
                                             mcv_vec3 normal) {
    mcv_cone cone;
    cone.axis = normal;
    cone.squared = 0.5f;
    cone.is_emission_cone = 1;
    (void)e;
#if MCV_WITH_PARALLEL
    if (e->type == MCV_EMITTER_PARALLEL) cone.squared = e->parallel.sin_half * e->parallel.sin_half;
#endif
    return cone;
}

/* One over the density, in étendue, with which light paths start in a direction [m² sr]; 0: none
 * do. `ng`: of the emitter. */
MCV_LOOP_FUNCTION float mcv_etendue_of(__global const mcv_device_emitter *e, mcv_aiming aimed,
                                       mcv_vec3 ng, mcv_vec3 direction) {
    if (e->type == MCV_EMITTER_PROJECTOR) return e->light_inverse_pdf;
    return aimed.within > 0u
               ? e->light_inverse_pdf * aimed.angle / (float)aimed.within * mcv_dot(direction, ng)
               : 0.0f;
}

/* The same at a place on an emitter. */
MCV_FUNCTION float mcv_light_etendue(mcv_world world, mcv_surface surface, uint emitter,
                                     mcv_vec3 direction) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const mcv_aiming aimed = mcv_aim_at(world.frame->balls, world.frame->ball_count, surface.point,
                                        mcv_emission_cone(e, surface.ns), direction);
    return mcv_etendue_of(e, aimed, surface.ng, direction);
}
#endif

#endif
