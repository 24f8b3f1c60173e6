/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: next-event estimation. A scattering surface chooses an emitter by power, reach and
 * its own lobe, then a direction to it:
 * - uniform in the cone of a parallel emitter, if that is smaller than the emitter as seen from
 *   there; the emitter must then be the closest hit;
 * - towards a point uniform in solid angle on a rectangle that subtends a large angle;
 * - towards a point uniform by area on other emitters;
 * - into a pixel of an environment's image, chosen by its contribution.
 * The power heuristic weights this against the surface's own choice of directions. Beams and lights
 * without extent have full weight: no direction of the surface's own meets them.
 */
#ifndef MCVISI_KERNELS_SAMPLE_EMITTERS_H
#define MCVISI_KERNELS_SAMPLE_EMITTERS_H

#include "bsdf/shading.h"
#include "geometry/path_interaction.h"
#include "light/direction.h"
#include "light/emitter_element.h"
#include "light/emission.h"
#include "light/emitter_point.h"
#include "light/mis.h"
#include "path/identity.h"
#include "stage/select_emitter.h"

#if MCV_WITH_NEXT_EVENT
MCV_LOOP_FUNCTION mcv_receiver mcv_receiver_of(mcv_interaction interaction) {
    const mcv_receiver at = {interaction.surface.point, interaction.surface.error, interaction.ng};
    return at;
}

/* What comes from an emitter to one receiver. */
MCV_FUNCTION mcv_light_sample mcv_sample_towards(mcv_world world, mcv_receiver at, uint emitter,
                                                 mcv_pair pair) {
    __global const mcv_device_emitter *e = world.emitters + emitter;
#if MCV_HAS_EMISSION
    if (!mcv_samples_direction(e, at.point)) {
        mcv_surface there;
        mcv_emitter_point point;
#if MCV_WITH_RECTANGLE
        if (mcv_is_rectangle(e)) {
            const mcv_facets two = mcv_facets_of(world, e);
            point = mcv_point_on_rectangle(e, &two, at.point, pair);
        } else
#endif
            point = mcv_point_on_mesh(world, e, mcv_choose_triangle(world, e, pair), pair);
        mcv_light_sample sample = mcv_sample_point(at, e, point, &there);
#if MCV_WITH_TEXTURE
        if (mcv_has_image(e))
            sample = mcv_light_sample_by_image(world, at.point, there, emitter, sample,
                                               MCV_SENDS_BY_PIXEL(e));
#endif
        return sample;
    }
#endif
    return mcv_sample_direction(world, at, e, e->type, pair);
}

/*
 * A sample of an emitter that was chosen by power, made one of an emitter chosen by the path's
 * surface. The light is divided by the pmf of that choice, the pdf for MIS is multiplied by the
 * surrogate, both over e->probability (mcv_light_selection). By the light tree both are the same.
 */
MCV_LOOP_FUNCTION mcv_light_sample mcv_apply_selection(mcv_world world, mcv_slot slot,
                                                       mcv_vec3 point, uint emitter,
                                                       mcv_light_sample sample) {
    if (!(MCV_WITH_REACH | MCV_WITH_LIGHT_TREE)) return sample;
    __global const mcv_device_emitter *e = world.emitters + emitter;
    const float surrogate_ratio =
        MCV_WITH_LIGHT_TREE ? MCV_LOAD(slot, selection_here, 3)
                            : mcv_selection_ratio(e, point, MCV_LOAD(slot, selection_here, 0),
                                                  MCV_LOAD(slot, selection_here, 1));
    const float pmf_ratio = MCV_WITH_REACH && MCV_WITH_GLOSSY
                                ? MCV_LOAD(slot, selection_here, 2) / e->probability
                                : surrogate_ratio;
    sample.pdf *= surrogate_ratio;
    sample.radiance_over_pdf = mcv_dim(sample.radiance_over_pdf, 1.0f / pmf_ratio);
    return sample;
}

/* Makes a sample of the chosen emitter the shadow ray of a path. The tile schedule keeps the light
 * and the pdf, too, until a loop makes shadow rays of them (mcv_load_light_sample). */
MCV_LOOP_FUNCTION void mcv_store_light_sample(mcv_world world, mcv_slot slot, uint emitter,
                                              mcv_light_sample sample) {
    MCV_STORE_3(slot, shadow_origin, sample.origin);
    MCV_STORE_3(slot, shadow_direction, sample.direction);
    MCV_WORD(slot, shadow_target, 0) = sample.target;
    if (MCV_WITH_RECORDS)
        MCV_WORD(slot, shadow_emitter_element, 0) = sample.emitter_element == MCV_NONE
                                                        ? mcv_first_emitter_element(world, emitter)
                                                        : sample.emitter_element;
    if (MCV_TILE) {
        MCV_STORE_COLOR(slot, shadow_light, sample.radiance_over_pdf);
        MCV_STORE(slot, shadow_density, 0, sample.pdf);
    }
}

/* mcv_respond for a surface of a kind that is known. */
MCV_LOOP_FUNCTION mcv_response mcv_respond_as(mcv_world world, mcv_slot slot,
                                              const mcv_interaction *interaction,
                                              mcv_shading shading, mcv_vec3 direction) {
    const uint media = mcv_path_media(slot);
#if MCV_HAS_PLAIN && MCV_WITH_DIFFUSE
    if (shading.kind == MCV_SHADING_DIFFUSE) {
        mcv_color reflectance;
        MCV_LOAD_COLOR(slot, reflectance, reflectance);
        return mcv_respond_diffuse(interaction, reflectance, media, direction);
    }
#endif
#if MCV_HAS_PLAIN && MCV_WITH_GLOSSY
    if (shading.kind == MCV_SHADING_GLOSSY) {
        const mcv_glossy_interaction m =
            mcv_make_plain_glossy_interaction(world, slot, interaction, shading, media);
        mcv_response response =
            mcv_respond_glossy_of(world, interaction, shading.glossy, &m, direction);
        /* Where it has not chosen an emitter any number will do. */
        const uint emitter = MCV_WORD(slot, emitter, 0), some = emitter == MCV_NONE ? 0u : emitter;
        const int near_specular = (int)world.materials[shading.material].near_specular;
        const int dropped = (m.microfacets.table == MCV_NONE) |
                            mcv_leaves_to_light_paths(world, slot, some, near_specular);
        MCV_EACH_CHANNEL(c) response.f_cos.c[c] = dropped ? 0.0f : response.f_cos.c[c];
        return response;
    }
#endif
    (void)shading;
    return mcv_respond(world, *interaction, media, direction);
}

/*
 * Makes a shadow ray of what comes from an emitter: what the surface makes of the light, and the
 * power heuristic against the surface's own choice of directions. 1 if there is a ray to follow.
 * Its origin, direction and target are the sample's.
 */
MCV_LOOP_FUNCTION int mcv_make_shadow_ray(mcv_world world, mcv_slot slot,
                                          const mcv_interaction *interaction, mcv_shading shading,
                                          mcv_light_sample sample) {
    world = mcv_disperse(world, slot);
    if (shading.kind == MCV_SHADING_ANY && !(mcv_brightest(sample.radiance_over_pdf) > 0.0f))
        return 0;
    const mcv_response response =
        mcv_respond_as(world, slot, interaction, shading, mcv_normalize(sample.direction));
    mcv_color light =
        mcv_tint(mcv_tint(mcv_path_throughput(slot), response.f_cos), sample.radiance_over_pdf);
    light = mcv_dim(light,
                    sample.pdf > 0.0f ? mcv_power_heuristic(sample.pdf, response.density) : 1.0f);
    light = mcv_basic_radiance(world, light, response.media);
    if (MCV_CROSSES) MCV_WORD(slot, shadow_media, 0) = response.media;
    if (MCV_WITH_SURFACES)
        MCV_WORD(slot, shadow_origin_surface, 0) =
            shading.exact ? mcv_origin_surface_of(world, *interaction, sample.direction) : MCV_NONE;
    MCV_STORE_COLOR(slot, shadow_light, light);
    const int comes = mcv_brightest(sample.radiance_over_pdf) > 0.0f,
              reflects = mcv_brightest(response.f_cos) > 0.0f;
    return comes & reflects;
}

/* 1 if there is a shadow ray to follow. */
MCV_FUNCTION int mcv_sample_emitter(mcv_world world, mcv_slot slot, uint depth) {
    const uint emitter = mcv_choose_emitter(world, slot, depth);
    if (emitter == MCV_NONE) return 0;
    const mcv_interaction interaction = mcv_make_interaction(world, slot);
    const mcv_receiver at = mcv_receiver_of(interaction);
    const mcv_light_sample sample = mcv_apply_selection(
        world, slot, at.point, emitter,
        mcv_sample_towards(world, at, emitter, mcv_draw(slot, depth, MCV_PAIR_EMITTER)));
    mcv_store_light_sample(world, slot, emitter, sample);
    return mcv_make_shadow_ray(world, slot, &interaction, mcv_any_shading(), sample);
}
#endif

#endif
