/* SPDX-License-Identifier: Apache-2.0 */
/* The surface of a body of glass or a fluid: where rays are refracted, and how smooth ones scatter.
 */
#ifndef MCVISI_KERNELS_DIELECTRIC_H
#define MCVISI_KERNELS_DIELECTRIC_H

#include "bsdf/scattering.h"
#include "path/media.h"

/* The sets of media on the ray's side of a body's surface, where the path's is mended, and beyond
 * it. */
typedef struct mcv_crossing {
    uint before, after;
    mcv_device_interface between;
    uint albedos; /* of the interface, MCV_NONE: it is smooth */
} mcv_crossing;

MCV_LOOP_FUNCTION mcv_crossing mcv_cross_surface(mcv_world world,
                                                 const mcv_interaction *interaction, uint media) {
    mcv_crossing crossing;
    const uint bit = 1u << (world.instances[interaction->surface.instance].medium - 1u);
    uint exited = interaction->back_face ? bit : 0u,
         entered =
             interaction->back_face ? 0u : bit; /* media of the bodies that the surface bounds */
#if MCV_WITH_CONTACT
    exited |= interaction->exited;
    entered |= interaction->entered;
#endif
    /* The body in contact, on the other side. */
    const uint touching = mcv_touching_solid(&interaction->surface);
    if (touching > 0u) {
        const uint other =
            1u << (world.instances[world.solids[touching - 1u].instance[0]].medium - 1u);
        exited |= interaction->back_face ? 0u : other;
        entered |= interaction->back_face ? other : 0u;
    }
    crossing.before = (media | exited) & ~entered;
    crossing.after = crossing.before ^ (exited | entered);
    const uint at = mcv_filling_medium(crossing.before) * (MCV_MAX_MEDIA + 1u) +
                    mcv_filling_medium(crossing.after);
    __global const mcv_device_interface *between =
        world.interfaces + at; /* word by word: a loop is not vectorised over structures */
    crossing.between.eta = between->eta;
    crossing.between.delta = between->delta;
    crossing.between.scale = between->scale;
    crossing.between.offset = between->offset;
    crossing.albedos = MCV_WITH_GLOSSY ? world.interface_albedos[at] : MCV_NONE;
    return crossing;
}

#if MCV_WITH_DIELECTRIC
/* Where light goes that passes a surface behind which it has the cosine c2 > 0 to its normal. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_refracted(mcv_device_interface between, mcv_interaction interaction,
                                         float cosine, float c2) {
    const mcv_vec3 d = mcv_refract(between, interaction.direction, interaction.ns, cosine, c2);
    const float f1 = -mcv_dot(interaction.direction, interaction.ng);
    const float f2 = mcv_refracted_cosine(between, f1);
    const mcv_vec3 flat = mcv_refract(between, interaction.direction, interaction.ng, f1, f2);
    return mcv_either(mcv_dot(d, interaction.ng) < 0.0f, d,
                      mcv_either(f2 > 0.0f, flat, interaction.direction));
}

/*
 * xi in [0, 1) chooses reflection with probability R; 1 always refracts where that is possible.
 * Equal indices pass all, total reflection nothing: the other way has no chance then.
 */
MCV_LOOP_FUNCTION mcv_scattering mcv_scatter_dielectric(mcv_world world,
                                                        mcv_interaction interaction, uint media,
                                                        float xi, uint *unmatched,
                                                        mcv_scattering *other) {
    const mcv_crossing crossing = mcv_cross_surface(world, &interaction, media);
    const mcv_device_interface between = crossing.between;
    const float c1 = -mcv_dot(interaction.direction, interaction.ns);
    const float cosine = c1 < 1.0f ? c1 : 1.0f;
    const float c2 = mcv_refracted_cosine(between, cosine);
    const int bends = between.delta != 0.0f, total = bends & !(c2 > 0.0f);
    const float reflectance = bends ? mcv_interface_reflectance(between, cosine, c2) : 0.0f;
    mcv_scattering reflected = mcv_scatter_mirrored(interaction, crossing.before);
    mcv_scattering refracted = mcv_scatter_into(
        mcv_either(bends, mcv_refracted(between, interaction, cosine, c2), interaction.direction),
        crossing.after, bends ? MCV_EVENT_REFRACT : MCV_EVENT_PASS);
    *unmatched += crossing.before != media;
    reflected.chance = reflectance;
    refracted.chance = 1.0f - reflectance;
    return mcv_either_way(reflected, refracted, total | (xi < reflectance), other);
}
#endif

#endif
