/* SPDX-License-Identifier: Apache-2.0 */
/* What a camera path has hit, as far as light paths bring its light, too: MCV_PATH_CLASS_… */
#ifndef MCVISI_KERNELS_PATH_CLASS_H
#define MCVISI_KERNELS_PATH_CLASS_H

#include "bsdf/shading.h"
#include "path/sensor_ray.h"

#if MCV_WITH_LIGHT_TRACING
/*
 * The path continues from a surface. Idempotent, except at plates. That is needed because in rows a
 * branch is copied after its parent was updated (mcv_split_paths); there no plate splits a path.
 */
MCV_LOOP_FUNCTION void mcv_update_path_class(mcv_world world, mcv_slot slot,
                                             const mcv_interaction *interaction,
                                             mcv_shading shading, mcv_scattering on) {
    const uint before = MCV_WORD(slot, path_class, 0);
    const int scatters = on.density > 0.0f,
              near_specular = mcv_is_near_specular(world, *interaction),
              passes = shading.kind == MCV_SHADING_ANY && on.event == MCV_EVENT_PASS &&
                       mcv_is_plate(world, *interaction);
    const int straight = before == MCV_PATH_CLASS_STRAIGHT,
              carries = (before == MCV_PATH_CLASS_BROAD) | (before == MCV_PATH_CLASS_CARRIED);
    const float footprint = mcv_sensor_footprint(
        world.sensor, mcv_point_to_optical(world.frame, interaction->surface.point).z);
    const uint scattered = mcv_has_broad_lobe(world, *interaction) ? MCV_PATH_CLASS_BROAD
                           : straight                              ? MCV_PATH_CLASS_OTHER
                                                                   : MCV_PATH_CLASS_GLOSSY;
    const uint smooth = carries                ? MCV_PATH_CLASS_CARRIED
                        : (straight & !passes) ? MCV_PATH_CLASS_OTHER
                                               : before;
    MCV_STORE(slot, footprint, 0, straight ? footprint : MCV_LOAD(slot, footprint, 0));
    MCV_WORD(slot, path_class, 0) = before == MCV_PATH_CLASS_OTHER            ? before
                                    : (scatters & !(carries & near_specular)) ? scattered
                                                                              : smooth;
}
#endif

#endif
