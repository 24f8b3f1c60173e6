/* SPDX-License-Identifier: Apache-2.0 */
/* The BSDF of any surface: which material's function answers. */
#ifndef MCVISI_KERNELS_BSDF_H
#define MCVISI_KERNELS_BSDF_H

#include "bsdf/dielectric.h"
#include "bsdf/diffuse.h"
#include "bsdf/glossy.h"
#include "bsdf/retroreflector.h"
#include "bsdf/plates.h"
#include "geometry/contact.h"

#if MCV_WITH_NEXT_EVENT
/* The direction is unit and leads away from the surface; light that cannot come from there has the
 * response 0. */
MCV_FUNCTION mcv_response mcv_respond(mcv_world world, mcv_interaction interaction, uint media,
                                      mcv_vec3 direction) {
    const uint material = world.instances[interaction.surface.instance].material,
               type = world.materials[material].type;
    mcv_response response;
    response.f_cos = mcv_grey(0.0f);
    response.density = 0.0f;
    response.media = media;
    (void)direction, (void)type;
#if MCV_WITH_TRANSLUCENT
    if (type == MCV_MATERIAL_DIFFUSE)
        return mcv_respond_translucent(world, interaction, material, media, direction);
#elif MCV_WITH_DIFFUSE
    if (type == MCV_MATERIAL_DIFFUSE)
        return mcv_respond_diffuse(&interaction,
                                   mcv_material_color(world, interaction.surface, material), media,
                                   direction);
#endif
#if MCV_WITH_GLOSSY
    if (mcv_is_microfacet(world, &interaction, media)) {
        mcv_glossy_interaction room;
        const mcv_glossy_interaction *m =
            mcv_known_glossy(world, &interaction, material, media, &room);
        return mcv_respond_glossy(world, &interaction, material, m, direction);
    }
#endif
#if MCV_WITH_REFLECTOR
#define MCV_X(name, key, NAME) \
    if (type == MCV_MATERIAL_##NAME) \
        return mcv_respond_##name(world, interaction, material, media, direction);
    MCV_OWN_BSDFS(MCV_X)
#undef MCV_X
#endif
    return response;
}
#endif

#if MCV_WITH_LIGHT_TRACING
MCV_LOOP_FUNCTION int mcv_has_broad_lobe(mcv_world world, mcv_interaction interaction) {
    return world.materials[world.instances[interaction.surface.instance].material].broad_lobe;
}

MCV_LOOP_FUNCTION int mcv_is_near_specular(mcv_world world, mcv_interaction interaction) {
    return world.materials[world.instances[interaction.surface.instance].material].near_specular;
}

/* Does the surface pass light straight on, but for what it reflects? */
MCV_LOOP_FUNCTION int mcv_is_plate(mcv_world world, mcv_interaction interaction) {
    const uint type = world.materials[world.instances[interaction.surface.instance].material].type;
    return MCV_IS_MATERIAL_OF(MCV_PLATES, type);
}
#endif

/* 1 if the surface of a body says that the path is in other media than it is. */
MCV_FUNCTION uint mcv_is_unmatched(mcv_world world, const mcv_interaction *interaction, uint medium,
                                   uint media) {
    return MCV_WITH_DIELECTRIC && medium != 0 &&
           mcv_cross_surface(world, interaction, media).before != media;
}

/*
 * Chooses how the path continues. *other: the other way of a smooth surface that has two and, if
 * the path may split there, of rough glass; elsewhere its chance is 0.
 */
MCV_FUNCTION mcv_scattering mcv_scatter(mcv_world world, mcv_interaction interaction, uint media,
                                        mcv_pair pair, float choice, int may_split, uint *unmatched,
                                        mcv_scattering *other) {
    const mcv_device_instance instance = world.instances[interaction.surface.instance];
    mcv_scattering scattering =
        mcv_scatter_into(interaction.direction, media, MCV_EVENT_NON_SPECULAR);
    scattering.factor = mcv_grey(0.0f);
    *other = scattering;
    other->chance = 0.0f;
    (void)pair, (void)choice, (void)may_split, (void)unmatched;
#if MCV_WITH_GLOSSY
    if (mcv_is_microfacet(world, &interaction, media)) {
        *unmatched += mcv_is_unmatched(world, &interaction, instance.medium, media);
        return mcv_scatter_glossy(world, interaction, instance.material, media, pair, choice,
                                  may_split, other);
    }
#endif
    switch (world.materials[instance.material].type) {
#if MCV_WITH_GLOSSY && MCV_WITH_METAL
    case MCV_MATERIAL_CONDUCTOR:
        return mcv_scatter_conductor(world, interaction, instance.material, media);
#endif
#if MCV_WITH_DIELECTRIC
    case MCV_MATERIAL_DIELECTRIC:
        return mcv_scatter_dielectric(world, interaction, media, pair.x, unmatched, other);
#endif
#if MCV_WITH_REFLECTOR
#define MCV_X(name, key, NAME) \
    case MCV_MATERIAL_##NAME: \
        *unmatched += mcv_is_unmatched(world, &interaction, instance.medium, media); \
        return mcv_scatter_##name(world, interaction, instance.material, media, pair, choice);
        MCV_OWN_BSDFS(MCV_X)
#undef MCV_X
#endif
#if MCV_WITH_TRANSLUCENT
    case MCV_MATERIAL_DIFFUSE:
        return mcv_scatter_translucent(world, interaction, instance.material, media, pair, choice);
#elif MCV_WITH_DIFFUSE
    case MCV_MATERIAL_DIFFUSE:
        return mcv_scatter_diffuse(
            interaction, mcv_material_color(world, interaction.surface, instance.material), media,
            pair);
#endif
#if MCV_WITH_SHEET
#define MCV_X(name, key, NAME) \
    case MCV_MATERIAL_##NAME: \
        return mcv_scatter_##name(world, interaction, instance.material, media, pair.x, other);
        MCV_PLATES(MCV_X)
#undef MCV_X
#endif
#if MCV_WITH_MIRROR
    case MCV_MATERIAL_MIRROR:
        scattering = mcv_scatter_mirrored(interaction, media);
        scattering.factor = mcv_material_color(world, interaction.surface, instance.material);
        return scattering;
#endif
    default:
        return scattering; /* absorbed */
    }
}

/* mcv_scatter without chance: what can refract or pass does. */
MCV_FUNCTION mcv_scattering mcv_scatter_through(mcv_world world, mcv_interaction interaction,
                                                uint media, uint *unmatched) {
    const mcv_pair passes = {1.0f, 0.0f};
    mcv_scattering other;
    return mcv_scatter(world, interaction, media, passes, 1.0f, 0, unmatched, &other);
}

#endif
