/* SPDX-License-Identifier: Apache-2.0 */
/* Ground glass on the device (mcvisi/materials/ground_glass.h): becomes
 * kernels/bsdf/ground_glass.h. */
#ifndef MCVISI_KERNELS_GROUND_GLASS_H
#define MCVISI_KERNELS_GROUND_GLASS_H

#include "bsdf/dielectric.h"

#if MCV_WITH_REFLECTOR
/*
 * What comes from a unit direction, as a share of L/n²: f cosθ by channel, and the density with
 * which mcv_scatter_… of this material chooses that direction. The normals ns and ng lie on the
 * side of the path. mcv_cross_surface knows the media of both sides and their indices; a direction
 * beyond the surface is in those behind it. A path carries L/n², so that light from beyond is
 * scattered with the transmittance of the path's own side.
 */
MCV_FUNCTION mcv_response mcv_respond_ground_glass(mcv_world world, mcv_interaction interaction,
                                                   uint material, uint media, mcv_vec3 direction) {
    const mcv_crossing crossing = mcv_cross_surface(world, &interaction, media);
    const float cosine = mcv_dot(direction, interaction.ns);
    const int beyond = cosine<0.0f, agrees = cosine * mcv_dot(direction, interaction.ng)> 0.0f;
    const float passed = mcv_ground_glass_transmittance(
        world.materials[material].as.ground_glass.passed, crossing.between.eta);
    mcv_response response;
    response.density = agrees && crossing.between.delta != 0.0f
                           ? (beyond ? passed : 1.0f - passed) * mcv_abs(cosine) * (1.0f / MCV_PI)
                           : 0.0f;
    response.f_cos = mcv_grey(response.density);
    response.media = beyond ? crossing.after : crossing.before;
    return response;
}

/* Where the path goes on. `choice` is one more random number: it chooses the side. */
MCV_FUNCTION mcv_scattering mcv_scatter_ground_glass(mcv_world world, mcv_interaction interaction,
                                                     uint material, uint media, mcv_pair pair,
                                                     float choice) {
    const mcv_crossing crossing = mcv_cross_surface(world, &interaction, media);
    const float passed = mcv_ground_glass_transmittance(
        world.materials[material].as.ground_glass.passed, crossing.between.eta);
    const mcv_vec3 reflected =
        mcv_normalize(mcv_from_frame(mcv_sample_cosine(pair.x, pair.y), interaction.ns));
    const mcv_vec3 direction = mcv_scale(reflected, choice < passed ? -1.0f : 1.0f);
    if (crossing.between.delta == 0.0f)
        return mcv_scatter_into(interaction.direction, crossing.after, MCV_EVENT_PASS);
    return mcv_scatter_by(direction,
                          mcv_respond_ground_glass(world, interaction, material, media, direction));
}
#endif

#endif
