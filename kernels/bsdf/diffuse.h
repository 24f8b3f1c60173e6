/* SPDX-License-Identifier: Apache-2.0 */
/* Diffuse surfaces, which may be translucent. */
#ifndef MCVISI_KERNELS_DIFFUSE_H
#define MCVISI_KERNELS_DIFFUSE_H

#include "bsdf/scattering.h"
#include "path/sampler.h"

#if MCV_WITH_DIFFUSE
MCV_LOOP_FUNCTION mcv_scattering mcv_scatter_diffuse(mcv_interaction interaction,
                                                     mcv_color reflectance, uint media,
                                                     mcv_pair pair) {
    mcv_scattering scattering =
        mcv_scatter_into(interaction.direction, media, MCV_EVENT_NON_SPECULAR);
#if MCV_TILE
    if (interaction.bounces) {
        scattering.direction = interaction.bounce;
        scattering.density = interaction.bounce_density;
    } else
#endif
        scattering.direction =
            mcv_diffuse_sample(interaction.ns, pair.x, pair.y, &scattering.density);
    const int reflects = mcv_dot(scattering.direction, interaction.ng) > 0.0f;
    MCV_EACH_CHANNEL(i) scattering.factor.c[i] = reflects ? reflectance.c[i] : 0.0f;
    return scattering;
}

/* The direction is unit. */
MCV_LOOP_FUNCTION mcv_response mcv_respond_diffuse(const mcv_interaction *interaction,
                                                   mcv_color reflectance, uint media,
                                                   mcv_vec3 direction) {
    mcv_response response;
    const float cosine = mcv_dot(direction, interaction->ns);
    const int comes = (cosine > 0.0f) & (mcv_dot(direction, interaction->ng) > 0.0f);
    response.density = comes ? mcv_diffuse_density(cosine) : 0.0f;
    response.f_cos = mcv_dim(reflectance, response.density);
    response.media = media;
    return response;
}

#if MCV_WITH_TRANSLUCENT
/* The side is chosen by the two shares; what lies beyond is seen from behind. */
static mcv_scattering mcv_scatter_translucent(mcv_world world, mcv_interaction interaction,
                                              uint material, uint media, mcv_pair pair,
                                              float choice) {
    const float chance = world.materials[material].chance;
    const int through = choice >= chance;
    if (through) {
        interaction.ns = mcv_scale(interaction.ns, -1.0f);
        interaction.ng = mcv_scale(interaction.ng, -1.0f);
#if MCV_TILE
        interaction.bounces = 0; /* that has been worked out for the other side */
#endif
    }
    const mcv_color share = through ? mcv_material_passed(world, interaction.surface, material)
                                    : mcv_material_color(world, interaction.surface, material);
    const float own = through ? 1.0f - chance : chance;
    mcv_scattering scattering =
        mcv_scatter_diffuse(interaction, mcv_dim(share, 1.0f / own), media, pair);
    scattering.density *= own;
    return scattering;
}

MCV_FUNCTION mcv_response mcv_respond_translucent(mcv_world world, mcv_interaction interaction,
                                                  uint material, uint media, mcv_vec3 direction) {
    const float chance = world.materials[material].chance;
    const float cosine = mcv_dot(direction, interaction.ns);
    mcv_response response;
    if (cosine < 0.0f && mcv_dot(direction, interaction.ng) < 0.0f) {
        response.density = mcv_diffuse_density(-cosine);
        response.f_cos =
            mcv_dim(mcv_material_passed(world, interaction.surface, material), response.density);
        response.density *= 1.0f - chance;
        response.media = media;
        return response;
    }
    response = mcv_respond_diffuse(
        &interaction, mcv_material_color(world, interaction.surface, material), media, direction);
    response.density *= chance;
    return response;
}
#endif
#endif

#endif
