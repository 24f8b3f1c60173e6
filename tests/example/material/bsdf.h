/* SPDX-License-Identifier: Apache-2.0 */
/* The Lunar-Lambert reflector on the device (mcvisi/materials/lunar_lambert.h): becomes
 * kernels/bsdf/lunar_lambert.h. */
#ifndef MCVISI_KERNELS_LUNAR_LAMBERT_H
#define MCVISI_KERNELS_LUNAR_LAMBERT_H

#include "bsdf/scattering.h"
#include "path/sampler.h"

#if MCV_WITH_REFLECTOR
/*
 * What comes from a unit direction: f cosθ by channel, and the density with which mcv_scatter_… of
 * this material chooses that direction. Emitters are sampled with it. The shading normal ns lies on
 * the side of the path. Where it and ng disagree on the direction's side nothing comes.
 */
MCV_FUNCTION mcv_response mcv_respond_lunar_lambert(mcv_world world, mcv_interaction interaction,
                                                    uint material, uint media, mcv_vec3 direction) {
    const float c_o = -mcv_dot(interaction.direction, interaction.ns),
                c_i = mcv_dot(direction, interaction.ns);
    const int comes = (c_o > 0.0f) & (c_i > 0.0f) & (mcv_dot(direction, interaction.ng) > 0.0f);
    mcv_response response;
    response.f_cos = mcv_grey(0.0f);
    response.density = 0.0f;
    response.media = media;
    if (!comes) return response;
    response.density = c_i * (1.0f / MCV_PI);
    response.f_cos =
        mcv_dim(mcv_material_color(world, interaction.surface, material),
                response.density * mcv_lunar_lambert_factor(
                                       world.materials[material].as.lunar_lambert.lunar, c_o, c_i));
    return response;
}

/* Where the path goes on. Any density does that is above 0 wherever f is; the closer it follows
 * f cosθ, the less noise. `choice` is one more random number, for a material of two lobes. */
MCV_FUNCTION mcv_scattering mcv_scatter_lunar_lambert(mcv_world world, mcv_interaction interaction,
                                                      uint material, uint media, mcv_pair pair,
                                                      float choice) {
    const mcv_vec3 direction =
        mcv_normalize(mcv_from_frame(mcv_sample_cosine(pair.x, pair.y), interaction.ns));
    (void)choice;
    return mcv_scatter_by(
        direction, mcv_respond_lunar_lambert(world, interaction, material, media, direction));
}
#endif

#endif
