/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces of microfacets (bsdf/microfacet.h), in the frame of the surface; and smooth metals. */
#ifndef MCVISI_KERNELS_GLOSSY_H
#define MCVISI_KERNELS_GLOSSY_H

#include "bsdf/dielectric.h"
#include "bsdf/scattering.h"
#include "path/sampler.h"

#if MCV_WITH_GLOSSY
#include "bsdf/microfacet.h"

/* A glossy surface as a ray meets it. */
typedef struct mcv_glossy_interaction {
    mcv_microfacets microfacets;
    mcv_vec3 x, y, z; /* the frame of the surface */
    mcv_vec3 o;       /* in that frame */
    mcv_lobes lobes;
    uint near_media, far_media; /* of light on the ray's side and on the other */
} mcv_glossy_interaction;

MCV_FUNCTION mcv_vec3 mcv_microfacet_local(const mcv_glossy_interaction *m, mcv_vec3 v) {
    return mcv_vec(mcv_dot(v, m->x), mcv_dot(v, m->y), mcv_dot(v, m->z));
}

/* Whether the surface is one of microfacets: a smooth metal is not. */
static int mcv_is_microfacet(mcv_world world, const mcv_interaction *interaction, uint media) {
    const mcv_device_instance instance = world.instances[interaction->surface.instance];
    const uint type = world.materials[instance.material].type;
    if (!world.materials[instance.material].scattering_sides) return 0;
    if (MCV_WITH_DIELECTRIC && type == MCV_MATERIAL_DIELECTRIC)
        return MCV_WITH_ROUGH_GLASS &&
               mcv_cross_surface(world, interaction, media).albedos != MCV_NONE;
    return type == MCV_MATERIAL_METALLIC_ROUGHNESS || type == MCV_MATERIAL_CONDUCTOR;
}

/* What an image gives of a glossy surface: factors of its roughness and of its metallic share. */
typedef struct mcv_polish {
    float scale, metallic;
} mcv_polish;

#if MCV_WITH_TEXTURE
MCV_LOOP_FUNCTION mcv_polish mcv_polish_at(mcv_world world, mcv_surface surface, uint texture) {
    const float s = mcv_image_place(world, surface, texture, 0);
    const float t = mcv_image_place(world, surface, texture, 1);
    const mcv_polish polish = {mcv_texture_value(world, texture, s, t, 1),
                               mcv_texture_value(world, texture, s, t, 2)};
    return polish;
}
#endif

/* The surface's values are those of its table, `from`, but the roughness, the metallic share and
 * the colour where textures give them. */
MCV_LOOP_FUNCTION mcv_glossy_interaction mcv_make_glossy_interaction_of(
    mcv_world world, const mcv_interaction *interaction, const mcv_device_glossy *from, uint type,
    mcv_color base, mcv_polish polish, uint media) {
    mcv_glossy_interaction m;
    const float roughness = from->roughness * polish.scale;
    const float alpha =
        roughness * roughness > MCV_LEAST_ALPHA ? roughness * roughness : MCV_LEAST_ALPHA;
    m.near_media = m.far_media = media;
    m.microfacets.type = type;
    m.microfacets.base = base;
    m.microfacets.metallic = from->metallic * polish.metallic;
    m.microfacets.layer =
        from->roughnesses > 1u ? polish.scale * (float)(from->roughnesses - 1) : 0.0f;
    m.microfacets.table = from->table;
    m.microfacets.inside = interaction->back_face;
    m.microfacets.between.eta = 1.0f;
    m.microfacets.between.delta = 0.0f;
    m.microfacets.alpha.x = mcv_fma(1.0f - alpha, from->anisotropy, alpha);
    m.microfacets.alpha.y = alpha;
    if (MCV_WITH_ROUGH_GLASS && m.microfacets.type == MCV_MATERIAL_DIELECTRIC) {
        const mcv_crossing crossing = mcv_cross_surface(world, interaction, media);
        m.near_media = crossing.before;
        m.far_media = crossing.after;
        m.microfacets.between = crossing.between;
        /* A body has none of its own, MCV_NONE. With a choice between two places in memory the loop
         * over paths would not be vectorised. */
        m.microfacets.table &= crossing.albedos;
    } else if (MCV_WITH_DIELECTRIC) {
        m.microfacets.between.eta =
            mcv_sqrt(world.medium_table[mcv_filling_medium(media)].inverse_index_squared);
    }

    m.z = interaction->ns;
    mcv_basis(m.z, &m.x, &m.y);
    if (MCV_WITH_ANISOTROPY) {
        const int turns = from->anisotropy > 0.0f;
        const mcv_vec3 tangent = mcv_tangent(world, interaction->surface, from->direction);
        const mcv_vec3 x = mcv_along(tangent, -mcv_dot(tangent, m.z), m.z);
        m.x = mcv_either(turns & (mcv_dot(x, x) > 0.0f), mcv_normalize(x), m.x);
        m.y = mcv_either(turns, mcv_cross(m.z, m.x), m.y);
    }
    m.o = mcv_microfacet_local(&m, mcv_scale(interaction->direction, -1.0f));
    m.lobes = mcv_microfacet_lobes(from, &m.microfacets, world.albedos, m.o);
    return m;
}

static mcv_glossy_interaction mcv_make_glossy_interaction(mcv_world world,
                                                          const mcv_interaction *interaction,
                                                          uint material, uint media) {
    const mcv_device_glossy from = world.glossy[material];
    mcv_polish polish = {1.0f, 1.0f};
#if MCV_WITH_TEXTURE
    if (from.texture != MCV_NONE) polish = mcv_polish_at(world, interaction->surface, from.texture);
#endif
    return mcv_make_glossy_interaction_of(world, interaction, &from, world.materials[material].type,
                                          mcv_material_color(world, interaction->surface, material),
                                          polish, media);
}

/* The same, worked out once for a path's surface, or in the given room. */
MCV_FUNCTION const mcv_glossy_interaction *mcv_known_glossy(mcv_world world,
                                                            const mcv_interaction *interaction,
                                                            uint material, uint media,
                                                            mcv_glossy_interaction *room) {
#if MCV_TILE
    if (interaction->glossy) {
        if (*interaction->glossy_known) return interaction->glossy;
        *interaction->glossy_known = 1u;
        room = interaction->glossy;
    }
#endif
    *room = mcv_make_glossy_interaction(world, interaction, material, media);
    return room;
}

/* The direction is unit. Where ns and ng disagree on its side nothing comes. */
MCV_LOOP_FUNCTION mcv_response mcv_respond_glossy_of(mcv_world world,
                                                     const mcv_interaction *interaction,
                                                     const mcv_device_glossy *from,
                                                     const mcv_glossy_interaction *m,
                                                     mcv_vec3 direction) {
    const mcv_vec3 i = mcv_microfacet_local(m, direction);
    const int far = i.z < 0.0f;
    const float side = mcv_dot(direction, interaction->ng);
    const int comes = far ? side < 0.0f : side > 0.0f;
    mcv_response response =
        mcv_microfacet_respond(from, &m->microfacets, world.albedos, &m->lobes, m->o, i);
    MCV_EACH_CHANNEL(c) response.f_cos.c[c] = comes ? response.f_cos.c[c] : 0.0f;
    response.density = comes ? response.density : 0.0f;
    response.media = far ? m->far_media : m->near_media;
    return response;
}

static __attribute__((noinline)) mcv_response
mcv_respond_glossy(mcv_world world, const mcv_interaction *interaction, uint material,
                   const mcv_glossy_interaction *m, mcv_vec3 direction) {
    const mcv_device_glossy from = world.glossy[material];
    return mcv_respond_glossy_of(world, interaction, &from, m, direction);
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_choose_glossy_of(const mcv_device_glossy *from,
                                                const mcv_glossy_interaction *m, mcv_pair pair,
                                                float choice) {
    const mcv_vec3 i =
        mcv_microfacet_sample(from, &m->microfacets, &m->lobes, m->o, pair.x, pair.y, choice);
    return mcv_normalize(mcv_along(mcv_along(mcv_scale(m->z, i.z), i.y, m->y), i.x, m->x));
}

/* A way on in a direction that has been chosen. */
MCV_LOOP_FUNCTION mcv_scattering mcv_turn_by_glossy(mcv_world world,
                                                    const mcv_interaction *interaction,
                                                    const mcv_device_glossy *from,
                                                    const mcv_glossy_interaction *m,
                                                    mcv_vec3 direction) {
    return mcv_scatter_by(direction, mcv_respond_glossy_of(world, interaction, from, m, direction));
}

/* The microfacet of rough glass that has turned light one way turns it the other way, too: *other,
 * whose chance is 0 where it does not. */
MCV_LOOP_FUNCTION mcv_scattering mcv_split_by_glossy(mcv_world world,
                                                     const mcv_interaction *interaction,
                                                     const mcv_device_glossy *from,
                                                     const mcv_glossy_interaction *m, mcv_pair pair,
                                                     float choice, mcv_scattering *other) {
    mcv_scattering on = mcv_turn_by_glossy(world, interaction, from, m,
                                           mcv_choose_glossy_of(from, m, pair, choice));
    const mcv_vec3 h = mcv_ggx_sample(m->microfacets.alpha, m->o, pair.x, pair.y);
    const float microfacet = m->lobes.microfacet,
                share = mcv_microfacet_fresnel(from, &m->microfacets, mcv_dot(m->o, h)).c[0];
    const int turns = choice < microfacet, reflects = choice < microfacet * share;
    on.chance = turns ? (reflects ? share : 1.0f - share) : 1.0f;
    on.remainder = choice / microfacet;
    *other = mcv_turn_by_glossy(
        world, interaction, from, m,
        mcv_choose_glossy_of(from, m, pair,
                             reflects ? microfacet * (1.0f - MCV_UNIT_ROUNDOFF) : 0.0f));
    other->chance = 1.0f - on.chance;
    return on;
}

static mcv_scattering mcv_scatter_glossy(mcv_world world, mcv_interaction interaction,
                                         uint material, uint media, mcv_pair pair, float choice,
                                         int may_split, mcv_scattering *other) {
    mcv_glossy_interaction room;
    const mcv_device_glossy from = world.glossy[material];
    const mcv_glossy_interaction *m = mcv_known_glossy(world, &interaction, material, media, &room);
    if (MCV_WITH_ROUGH_GLASS && may_split && m->microfacets.type == MCV_MATERIAL_DIELECTRIC)
        return mcv_split_by_glossy(world, &interaction, &from, m, pair, choice, other);
    return mcv_turn_by_glossy(world, &interaction, &from, m,
                              mcv_choose_glossy_of(&from, m, pair, choice));
}

#if MCV_WITH_METAL
/* A smooth metal. */
static mcv_scattering mcv_scatter_conductor(mcv_world world, mcv_interaction interaction,
                                            uint material, uint media) {
    mcv_scattering scattering = mcv_scatter_mirrored(interaction, media);
    __global const mcv_device_glossy *from = world.glossy + material;
    const float scale =
        MCV_WITH_DIELECTRIC
            ? mcv_sqrt(world.medium_table[mcv_filling_medium(media)].inverse_index_squared)
            : 1.0f;
    const float cosine = -mcv_dot(interaction.direction, interaction.ns);
    MCV_EACH_CHANNEL(i)
    scattering.factor.c[i] = mcv_conductor_fresnel(from->n[i] * scale, from->k[i] * scale,
                                                   cosine < 1.0f ? cosine : 1.0f);
    return scattering;
}
#endif
#endif

#endif
