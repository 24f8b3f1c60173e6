/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is known of a surface while the program is compiled. A loop over paths on surfaces of one
 * kind passes it on as constants, so that the functions below hold no conditional jumps there; a
 * path by itself is on any surface.
 */
#ifndef MCVISI_KERNELS_SHADING_H
#define MCVISI_KERNELS_SHADING_H

#include "path/identity.h"
#include "bsdf/bsdf.h"

/* Whether the tile schedule sets paths on surfaces of these kinds side by side: diffuse or glossy
 * ones, smooth bodies. */
#define MCV_HAS_PLAIN \
    ((MCV_WITH_DIFFUSE || MCV_WITH_GLOSSY) && MCV_OFFSETS_TOGETHER && !MCV_WITH_DISPERSION)
#define MCV_HAS_SMOOTH (MCV_WITH_DIELECTRIC && MCV_OFFSETS_TOGETHER && !MCV_WITH_DISPERSION)

/* What becomes of a path at a surface. MCV_UNSHADED: nothing yet, it is left to mcv_shade_surface.
 */
enum { MCV_CONTINUES = 1, MCV_SPLITS = 2, MCV_UNSHADED = 4 };

typedef struct mcv_shading {
    uint kind;                       /* MCV_SHADING_… (mcvisi/tables.h), not MCV_SHADING_BLACK */
    int exact;                       /* 0: the surface is a triangle */
    int may_split;                   /* it reflects and passes light: a path may split there */
    uint type;                       /* of a glossy surface: MCV_MATERIAL_… */
    uint material;                   /* of a glossy surface: one for all paths */
    const mcv_device_glossy *glossy; /* of a glossy surface: what is known of it beforehand */
} mcv_shading;

MCV_LOOP_FUNCTION mcv_shading mcv_shading_of(uint kind, int exact, int may_split) {
    mcv_shading shading;
    shading.kind = kind;
    shading.exact = exact;
    shading.may_split = may_split;
    shading.type = MCV_NONE;
    shading.material = MCV_NONE;
    shading.glossy = 0;
    return shading;
}

MCV_LOOP_FUNCTION mcv_shading mcv_any_shading(void) {
    return mcv_shading_of(MCV_SHADING_ANY, 1, 1);
}

#if MCV_HAS_PLAIN && MCV_WITH_GLOSSY
/* Of a plain glossy material; `from` is what mcv_plain_glossy says of it. */
MCV_LOOP_FUNCTION mcv_shading mcv_glossy_shading(mcv_world world, uint material,
                                                 const mcv_device_glossy *from) {
    mcv_shading shading = mcv_shading_of(MCV_SHADING_GLOSSY, MCV_WITH_SURFACES, 0);
    shading.type = world.materials[material].type;
    shading.material = material;
    shading.glossy = from;
    return shading;
}

/* The same, its type known to the compiler. */
MCV_LOOP_FUNCTION mcv_shading mcv_shading_as(mcv_shading shading, uint type) {
    shading.type = type;
    shading.may_split = type == MCV_MATERIAL_DIELECTRIC && MCV_WITH_SPLIT && MCV_HAS_SMOOTH;
    return shading;
}

/* What is known of a glossy material beforehand. turns: whether it has a direction, known to the
 * compiler. */
MCV_LOOP_FUNCTION mcv_device_glossy mcv_plain_glossy(mcv_world world, uint material, int turns) {
    mcv_device_glossy from = world.glossy[material];
    from.azimuths = turns ? MCV_ALBEDO_AZIMUTHS : 1u;
    from.anisotropy = turns ? from.anisotropy : 0.0f;
    from.roughnesses = MCV_WITH_TEXTURE ? from.roughnesses : 1u;
    return from;
}

MCV_LOOP_FUNCTION mcv_glossy_interaction mcv_make_plain_glossy_interaction(
    mcv_world world, mcv_slot slot, const mcv_interaction *interaction, mcv_shading shading,
    uint media) {
    mcv_color base;
    mcv_polish polish = {1.0f, 1.0f};
    MCV_EACH_CHANNEL(c) base.c[c] = world.materials[shading.material].color[c];
    if (MCV_WITH_TEXTURE) {
        MCV_LOAD_COLOR(slot, reflectance, base);
        polish.scale = MCV_LOAD(slot, polish, 0);
        polish.metallic = MCV_LOAD(slot, polish, 1);
    }
    return mcv_make_glossy_interaction_of(world, interaction, shading.glossy, shading.type, base,
                                          polish, media);
}
#endif

/*
 * mcv_scatter for a surface of a known kind. *unshaded is 1 where a glossy surface turns out to be
 * smooth, as glass is in a fluid of its own index: the result does not count then.
 */
MCV_LOOP_FUNCTION mcv_scattering mcv_scatter_as(mcv_world world, mcv_slot slot,
                                                const mcv_interaction *interaction,
                                                mcv_shading shading, mcv_pair pair, float choice,
                                                int may_split, uint *unmatched,
                                                mcv_scattering *other, int *unshaded) {
    const uint media = mcv_path_media(slot);
    (void)unshaded, (void)shading;
#if MCV_HAS_PLAIN && MCV_WITH_DIFFUSE
    if (shading.kind == MCV_SHADING_DIFFUSE) {
        mcv_color reflectance;
        MCV_LOAD_COLOR(slot, reflectance, reflectance);
        other->chance = 0.0f;
        return mcv_scatter_diffuse(*interaction, reflectance, media, pair);
    }
#endif
#if MCV_HAS_SMOOTH
    if (shading.kind == MCV_SHADING_SMOOTH)
        return mcv_scatter_dielectric(world, *interaction, media, pair.x, unmatched, other);
#endif
#if MCV_HAS_PLAIN && MCV_WITH_GLOSSY
    if (shading.kind == MCV_SHADING_GLOSSY) {
        mcv_scattering on;
        const mcv_glossy_interaction m =
            mcv_make_plain_glossy_interaction(world, slot, interaction, shading, media);
        *unshaded = m.microfacets.table == MCV_NONE;
        *unmatched += (uint)(!*unshaded & (m.near_media != media));
        other->chance = 0.0f;
        if (shading.may_split) {
            on = mcv_split_by_glossy(world, interaction, shading.glossy, &m, pair, choice, other);
            other->chance = *unshaded ? 0.0f : other->chance;
        } else {
            on = mcv_turn_by_glossy(world, interaction, shading.glossy, &m,
                                    mcv_choose_glossy_of(shading.glossy, &m, pair, choice));
        }
        return on;
    }
#endif
    return mcv_scatter(world, *interaction, media, pair, choice, may_split, unmatched, other);
}

#endif
