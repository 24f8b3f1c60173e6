/* SPDX-License-Identifier: Apache-2.0 */
/* Plates without thickness, thin sheets and beam splitters: light passes them straight on. */
#ifndef MCVISI_KERNELS_PLATES_H
#define MCVISI_KERNELS_PLATES_H

#include "bsdf/scattering.h"
#include "path/media.h"

#if MCV_WITH_SHEET
/* From the medium that a path is in into a plate, by its η and δ in vacuum. */
MCV_FUNCTION mcv_device_interface mcv_plate_interface(mcv_world world, float eta, float delta,
                                                      uint media) {
    mcv_device_interface into;
    into.eta = eta;
    into.delta = delta;
    if (MCV_WITH_DIELECTRIC && media != 0) {
        const float squared =
            eta * eta / world.medium_table[mcv_filling_medium(media)].inverse_index_squared;
        into.eta = mcv_sqrt(squared);
        into.delta = 1.0f - squared;
    }
    return into;
}

/* xi in [0, 1) chooses reflection with its chance; 1 always passes where that is possible. */
MCV_FUNCTION int mcv_plate_reflects(float chance, float xi) {
    return (xi < chance) | !(chance < 1.0f);
}

static mcv_scattering mcv_scatter_sheet(mcv_world world, mcv_interaction interaction, uint material,
                                        uint media, float xi, mcv_scattering *other) {
    const mcv_sheet sheet = world.materials[material].as.sheet;
    mcv_scattering reflected = mcv_scatter_mirrored(interaction, media);
    mcv_scattering passed = mcv_scatter_into(interaction.direction, media, MCV_EVENT_PASS);
    const mcv_device_interface into = mcv_plate_interface(world, sheet.eta, sheet.delta, media);
    const float c1 = -mcv_dot(interaction.direction, interaction.ns);
    const float cosine = c1 < 1.0f ? c1 : 1.0f;
    reflected.chance = mcv_sheet_reflectance(into, cosine);
    passed.chance = 1.0f - reflected.chance;
    passed.factor = mcv_material_color(world, interaction.surface, material);
    return mcv_either_way(reflected, passed, mcv_plate_reflects(reflected.chance, xi), other);
}

static mcv_scattering mcv_scatter_beam_splitter(mcv_world world, mcv_interaction interaction,
                                                uint material, uint media, float xi,
                                                mcv_scattering *other) {
    __global const mcv_device_material *m = world.materials + material;
    mcv_scattering reflected = mcv_scatter_mirrored(interaction, media);
    mcv_scattering passed = mcv_scatter_into(interaction.direction, media, MCV_EVENT_PASS);
    reflected.chance = m->chance;
    passed.chance = 1.0f - m->chance;
    MCV_EACH_CHANNEL(i) {
        /* A way without a chance carries no light. */
        reflected.factor.c[i] = reflected.chance > 0.0f ? m->color[i] / reflected.chance : 0.0f;
        passed.factor.c[i] = passed.chance > 0.0f ? m->passed[i] / passed.chance : 0.0f;
    }
    return mcv_either_way(reflected, passed, mcv_plate_reflects(m->chance, xi), other);
}
#endif

#endif
