/* SPDX-License-Identifier: Apache-2.0 */
/* Adds the light that a path meets by itself: of an emitter's surface, or of the environment. */
#ifndef MCVISI_KERNELS_SHADE_EMISSION_H
#define MCVISI_KERNELS_SHADE_EMISSION_H

#include "geometry/path_interaction.h"
#include "light/emitter_element.h"
#include "light/emission.h"
#include "light/environment.h"
#include "light/light_path.h"
#include "light/mis.h"
#include "stage/record_light.h"

/* Adds light, L/n², that arrives along the path. */
MCV_LOOP_FUNCTION void mcv_add_unrecorded_radiance(mcv_slot slot, mcv_color light) {
    const mcv_color throughput = mcv_path_throughput(slot);
    MCV_EACH_CHANNEL(i)
    MCV_STORE(slot, radiance, i, mcv_fma(throughput.c[i], light.c[i], MCV_LOAD(slot, radiance, i)));
}

/* The same, with a record. */
MCV_LOOP_FUNCTION void mcv_add_radiance(mcv_world world, mcv_slot slot, mcv_color light,
                                        uint emitter_element) {
    mcv_add_unrecorded_radiance(slot, light);
    if (MCV_WITH_RECORDS)
        mcv_record_radiance(world, slot, emitter_element,
                            mcv_tint(mcv_path_throughput(slot), light));
}

#if MCV_HAS_EMISSION
/* What a path has met of an emitter's surface. */
typedef struct mcv_emitter_hit {
    mcv_color radiance; /* that the surface sends along the path */
    uint emitter, emitter_element;
    float other; /* the density with which next-event estimation would have chosen this direction
                    [1/sr] */
    float mis_weight; /* of camera paths against light paths */
} mcv_emitter_hit;

/* A hit, as if next-event estimation and light paths could not bring its light. */
MCV_LOOP_FUNCTION mcv_emitter_hit mcv_make_emitter_hit(uint emitter, uint emitter_element,
                                                       mcv_color radiance) {
    const mcv_emitter_hit met = {radiance, emitter, emitter_element, 0.0f, 1.0f};
    return met;
}

#if MCV_WITH_NEXT_EVENT
/* mcv_emitter_hit.other, at the end of a ray of this length; rectangle, pmf: as of
 * mcv_density_towards. */
MCV_LOOP_FUNCTION float mcv_other_density(__global const mcv_device_emitter *e, int rectangle,
                                          float pmf, mcv_surface there, mcv_vec3 direction,
                                          float distance) {
    const mcv_vec3 receiver = mcv_along(there.point, -distance, direction);
    return mcv_density_towards(e, rectangle, pmf, receiver, there, direction, distance);
}
#endif

/* Adds what the path has met, weighed against next-event estimation by the power heuristic. */
MCV_LOOP_FUNCTION void mcv_add_emission(mcv_world world, mcv_slot slot,
                                        const mcv_emitter_hit *met) {
    mcv_color emitted = mcv_basic_radiance(world, met->radiance, mcv_path_media(slot));
    if (MCV_WITH_NEXT_EVENT) {
        const int carried = mcv_light_paths_find(world, slot, met->emitter);
        const float density =
                        mcv_bsdf_pdf_over_ratio(world, slot, met->emitter, mcv_path_density(slot)),
                    own = carried ? 0.0f : density, weight = mcv_power_heuristic(own, met->other);
        const int chosen = own > 0.0f, emits = mcv_brightest(emitted) > 0.0f;
        emitted = mcv_dim(emitted, (chosen & emits) ? weight : 1.0f);
    }
    mcv_add_radiance(world, slot, mcv_dim(emitted, met->mis_weight), met->emitter_element);
}

/* Adds what a surface emits that the path has met. mcv_shade_lamp_hits does the same for a row of
 * paths that have met one lamp, whose data it reads once. */
static void mcv_shade_emitter_hit(mcv_world world, mcv_slot slot, mcv_interaction interaction) {
    const uint emitter = world.instances[interaction.surface.instance].emitter;
    if (emitter == MCV_NONE) return;
    const mcv_surface there = interaction.surface;
    const mcv_vec3 direction = interaction.direction, back = mcv_scale(direction, -1.0f);
    mcv_emitter_hit met =
        mcv_make_emitter_hit(emitter, mcv_emitter_element_of(world, emitter, there, back),
                             mcv_emitted(world, there, emitter, back));
#if MCV_WITH_NEXT_EVENT
    __global const mcv_device_emitter *e = world.emitters + emitter;
    met.other =
        mcv_other_density(e, mcv_is_rectangle(e), mcv_triangle_pmf(world, e, there.primitive),
                          there, direction, MCV_LOAD(slot, hit, 0));
#endif
#if MCV_WITH_LIGHT_TRACING
    met.mis_weight = mcv_camera_path_mis_weight(world, slot, interaction.surface,
                                                interaction.direction, emitter);
#endif
    mcv_add_emission(world, slot, &met);
}
#endif

/* What a ray that leaves the scene sees of the environment. */
MCV_LOOP_FUNCTION mcv_color mcv_miss_radiance(mcv_world world, mcv_slot slot) {
    float density = mcv_path_density(slot);
    world = mcv_disperse(world, slot);
    if (MCV_WITH_ENVIRONMENT_IMAGE)
        density = mcv_bsdf_pdf_over_ratio(world, slot, world.frame->environment_emitter, density);
    return mcv_environment_seen(world, MCV_LOAD_3(slot, direction), mcv_path_media(slot), density);
}

/* A ray that leaves the scene. */
MCV_LOOP_FUNCTION void mcv_shade_miss(mcv_world world, mcv_slot slot) {
    if (!(MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE)) return;
    mcv_add_radiance(world, slot, mcv_miss_radiance(world, slot), mcv_environment_element(world));
}

#endif
