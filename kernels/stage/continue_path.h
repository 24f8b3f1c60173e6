/* SPDX-License-Identifier: Apache-2.0 */
/* The new ray of a path that continues from a surface. */
#ifndef MCVISI_KERNELS_CONTINUE_PATH_H
#define MCVISI_KERNELS_CONTINUE_PATH_H

#include "geometry/path_interaction.h"
#include "geometry/precise.h"
#include "stage/path_class.h"

#if MCV_WITH_MIXED
/* Where the path goes on, and with it how: *on gets the direction. */
static void mcv_leave_precisely(mcv_world world, mcv_slot slot, const mcv_interaction *interaction,
                                uint media, mcv_scattering *on) {
    const mcv_vec3 low = MCV_LOAD_3(slot, origin_low);
    const mcv_precise_ray ray =
        mcv_precise_ray_of(MCV_LOAD_3(slot, origin), low, MCV_LOAD_3(slot, direction),
                           MCV_LOAD_3(slot, direction_low));
    mcv_precise_interaction met;
    met.found = 0;
    if (on->event != MCV_EVENT_NON_SPECULAR)
        met = mcv_intersect_precisely(world, interaction, ray, low, MCV_LOAD(slot, hit, 0));
    const mcv_onward onward =
        mcv_go_on_precisely(world, interaction, &met, ray.direction, media, on);
    const mcv_vec3 origin = mcv_onward_origin(*interaction, on->direction);
    MCV_STORE_3(slot, origin, origin);
    MCV_STORE_3(slot, origin_low, mcv_onward_low(&onward, onward.ray.origin, origin));
    MCV_STORE_3(slot, direction_low, mcv_onward_low(&onward, onward.ray.direction, on->direction));
}
#endif

/* The ray of a path, of the camera's or of light, that continues from the surface: all but its
 * origin. skipped: 1 leaves it as it is; known to the compiler where that cannot be. */
MCV_LOOP_FUNCTION void mcv_continue_ray(mcv_world world, mcv_slot slot,
                                        const mcv_interaction *interaction, mcv_shading shading,
                                        mcv_scattering on, mcv_color throughput, int skipped) {
    const mcv_vec3 direction = mcv_either(skipped, interaction->direction, on.direction);
    MCV_STORE_3(slot, direction, direction);
    if (MCV_WITH_SURFACES)
        MCV_REPLACE_WORD(slot, origin_surface, 0, skipped,
                         shading.exact ? mcv_origin_surface_of(world, *interaction, on.direction)
                                       : MCV_NONE);
    MCV_EACH_CHANNEL(i) MCV_REPLACE(slot, throughput, i, skipped, throughput.c[i]);
    if (MCV_WITH_DIELECTRIC) MCV_REPLACE_WORD(slot, media, 0, skipped, on.media);
}

/* A camera path continues from the surface. Where origins are worked out for many paths at once,
 * after all else, the old one stays. */
MCV_LOOP_FUNCTION void mcv_continue_path(mcv_world world, mcv_slot slot,
                                         const mcv_interaction *interaction, mcv_shading shading,
                                         mcv_scattering on, mcv_color throughput, int skipped) {
#if MCV_WITH_MIXED
    mcv_leave_precisely(world, slot, interaction, mcv_path_media(slot), &on);
#elif !MCV_OFFSETS_TOGETHER
    MCV_STORE_3(slot, origin, mcv_onward_origin(*interaction, on.direction));
#endif
    mcv_continue_ray(world, slot, interaction, shading, on, throughput, skipped);
    if (MCV_WITH_NEXT_EVENT) MCV_REPLACE(slot, density, 0, skipped, on.density);
#if MCV_WITH_LIGHT_TRACING
    const uint path_class = MCV_WORD(slot, path_class, 0);
    mcv_update_path_class(world, slot, interaction, shading, on);
    MCV_WORD(slot, path_class, 0) = skipped ? path_class : MCV_WORD(slot, path_class, 0);
#endif
}

/* After what this surface emits, which the chances of the surface before are for, and before a
 * branch takes them over. */
MCV_LOOP_FUNCTION void mcv_keep_selection(mcv_slot slot) {
    if (!(MCV_WITH_NEXT_EVENT & (MCV_WITH_REACH | MCV_WITH_LIGHT_TREE))) return;
    MCV_WORD(slot, selection, 0) = MCV_WORD(slot, selection_here, 0);
    MCV_WORD(slot, selection, 1) = MCV_WORD(slot, selection_here, 1);
    if (MCV_WITH_LIGHT_TREE) MCV_WORD(slot, selection, 2) = MCV_WORD(slot, selection_here, 2);
}

#endif
