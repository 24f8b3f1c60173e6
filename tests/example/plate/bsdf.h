/* SPDX-License-Identifier: Apache-2.0 */
/* Filter glass on the device (mcvisi/materials/filter_glass.h): becomes
 * kernels/bsdf/filter_glass.h. */
#ifndef MCVISI_KERNELS_FILTER_GLASS_H
#define MCVISI_KERNELS_FILTER_GLASS_H

#include "bsdf/plates.h"

#if MCV_WITH_SHEET
/*
 * One of the two ways on by xi in [0, 1), and *other the other one: a path may follow both. Each
 * has the chance with which it is chosen, and a factor: its share by channel over that chance. The
 * chances add up to 1. mcv_plate_interface knows what the plate lies in.
 */
MCV_FUNCTION mcv_scattering mcv_scatter_filter_glass(mcv_world world, mcv_interaction interaction,
                                                     uint material, uint media, float xi,
                                                     mcv_scattering *other) {
    const mcv_filter_glass glass = world.materials[material].as.filter_glass;
    const mcv_device_interface into = mcv_plate_interface(world, glass.eta, glass.delta, media);
    mcv_scattering reflected = mcv_scatter_mirrored(interaction, media);
    mcv_scattering passed = mcv_scatter_into(interaction.direction, media, MCV_EVENT_PASS);
    const float c1 = -mcv_dot(interaction.direction, interaction.ns);
    const float cosine = c1 < 1.0f ? c1 : 1.0f;
    const float c2 = mcv_refracted_cosine(into, cosine), once = mcv_fresnel(into, cosine, c2);
    MCV_EACH_CHANNEL(i) {
        reflected.factor.c[i] =
            mcv_filter_glass_shares(glass.absorbance[i], once, c2, &passed.factor.c[i]);
    }
    const float most_reflected = mcv_brightest(reflected.factor),
                most_passed = mcv_brightest(passed.factor), both = most_reflected + most_passed;
    reflected.chance = both > 0.0f ? most_reflected / both : 0.0f;
    passed.chance = 1.0f - reflected.chance;
    if (most_reflected > 0.0f)
        reflected.factor = mcv_dim(reflected.factor, 1.0f / reflected.chance);
    if (most_passed > 0.0f) passed.factor = mcv_dim(passed.factor, 1.0f / passed.chance);
    return mcv_either_way(reflected, passed, xi < reflected.chance, other);
}
#endif

#endif
