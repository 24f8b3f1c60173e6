/* SPDX-License-Identifier: Apache-2.0 */
/* Thin sheets and beam splitters: light passes them straight on. */
#ifndef MCVISI_KERNELS_SHEET_H
#define MCVISI_KERNELS_SHEET_H

#include "bsdf/scattering.h"
#include "mcvisi/materials/sheet.h"
#include "path/media.h"

MCV_FUNCTION mcv_scattering mcv_scatter_sheet(mcv_world world, mcv_interaction interaction,
                                              mcv_device_material material, mcv_color transmittance,
                                              uint media, float xi, mcv_scattering *other) {
    mcv_scattering reflected = mcv_scatter_mirrored(interaction, media);
    mcv_scattering passed = mcv_scatter_into(interaction.direction, media, MCV_EVENT_PASS);
    mcv_device_interface into;
    into.eta = material.eta;
    into.delta = material.delta;
    /* The table holds it in vacuum. */
    if (MCV_WITH_DIELECTRIC && media != 0) {
        const float squared = material.eta * material.eta /
                              world.media[mcv_filling_medium(media)].inverse_index_squared;
        into.eta = mcv_sqrt(squared);
        into.delta = 1.0f - squared;
    }
    const float c1 = -mcv_dot(interaction.direction, interaction.normal);
    const float cosine = c1 < 1.0f ? c1 : 1.0f;
    reflected.chance = mcv_sheet_reflectance(into, cosine);
    passed.chance = 1.0f - reflected.chance;
    passed.factor = transmittance;
    return mcv_choose_way(reflected, passed, xi < reflected.chance, other);
}

MCV_FUNCTION mcv_scattering mcv_scatter_beam_splitter(mcv_interaction interaction,
                                                      mcv_device_material material, uint media,
                                                      float xi, mcv_scattering *other) {
    mcv_scattering reflected = mcv_scatter_mirrored(interaction, media);
    mcv_scattering passed = mcv_scatter_into(interaction.direction, media, MCV_EVENT_PASS);
    reflected.chance = material.chance;
    passed.chance = 1.0f - material.chance;
    MCV_EACH_CHANNEL(i) {
        reflected.factor.c[i] = material.value[i] / reflected.chance;
        passed.factor.c[i] = material.passed[i] / passed.chance;
    }
    return mcv_choose_way(reflected, passed, xi < reflected.chance, other);
}

#endif
