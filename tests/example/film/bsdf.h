/* SPDX-License-Identifier: Apache-2.0 */
/* The diffusing film on the device (mcvisi/materials/diffusing_film.h): becomes
 * kernels/bsdf/diffusing_film.h. */
#ifndef MCVISI_KERNELS_DIFFUSING_FILM_H
#define MCVISI_KERNELS_DIFFUSING_FILM_H

#include "bsdf/scattering.h"

#if MCV_WITH_REFLECTOR
/*
 * What comes from a unit direction: f cosθ by channel, and the density with which mcv_scatter_… of
 * this material chooses that direction. The normals ns and ng lie on the side of the path: light
 * comes from behind both. The film is thin: the media are the same there.
 */
MCV_FUNCTION mcv_response mcv_respond_diffusing_film(mcv_world world, mcv_interaction interaction,
                                                     uint material, uint media,
                                                     mcv_vec3 direction) {
    const float c_o = -mcv_dot(interaction.direction, interaction.ns),
                c_i = -mcv_dot(direction, interaction.ns);
    const int comes = (c_o > 0.0f) & (c_i > 0.0f) & (mcv_dot(direction, interaction.ng) < 0.0f);
    mcv_response response;
    response.f_cos = mcv_grey(0.0f);
    response.density = 0.0f;
    response.media = media;
    if (!comes) return response;
    response.density = mcv_retroreflector_density(
        world.materials[material].as.diffusing_film.spread, interaction.direction, direction);
    response.f_cos = mcv_dim(mcv_material_color(world, interaction.surface, material),
                             response.density * (c_i < c_o ? c_i / c_o : 1.0f));
    return response;
}

/* Where the path goes on. What would not leave behind the film is absorbed. */
MCV_FUNCTION mcv_scattering mcv_scatter_diffusing_film(mcv_world world, mcv_interaction interaction,
                                                       uint material, uint media, mcv_pair pair,
                                                       float choice) {
    const mcv_vec3 direction = mcv_retroreflector_sample(
        world.materials[material].as.diffusing_film.spread, interaction.direction, pair.x, pair.y);
    (void)choice;
    return mcv_scatter_by(
        direction, mcv_respond_diffusing_film(world, interaction, material, media, direction));
}
#endif

#endif
