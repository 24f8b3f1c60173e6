/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How a path goes on from a surface: the materials.
 *
 * Interpolated normals bend light, the triangle's face decides on which side it goes on: where both
 * disagree (at a silhouette) the face's normal is used.
 */
#ifndef MCVISI_KERNELS_SCATTER_H
#define MCVISI_KERNELS_SCATTER_H

#include "light/discrete.h"
#include "path/sampler.h"
#include "geometry/surface.h"
#if MCV_WITH_GLOSS
#include "bsdf/microfacet.h"
#endif
#if MCV_WITH_RETROREFLECTOR
#include "bsdf/retroreflector.h"
#endif
#if MCV_WITH_SURFACES
#include "geometry/solids.h"
#endif

/* A surface seen from where the ray comes from. */
typedef struct mcv_interaction {
    mcv_surface surface;
    mcv_vec3 direction;    /* of the ray, unit */
    mcv_vec3 face, normal; /* unit, on the ray's side: direction·face < 0, direction·normal < 0 */
    uint inside;           /* 1: the ray comes from behind the front side */
#if MCV_WITH_CONTACT
    uint exited, entered; /* media of other bodies whose surfaces are in the same place */
    mcv_vec3 beyond_point, beyond_error; /* of the last of these surfaces */
    uint touched; /* if this is a triangle: an exact one of them, or MCV_NONE */
    mcv_vec3 touched_face;
#endif
#if MCV_TILE && MCV_WITH_DIFFUSE
    int bounces; /* 1: worked out beforehand for many paths is where it goes on if the surface is
                    diffuse */
    mcv_vec3 bounce;
    float bounce_density;
#endif
#if MCV_TILE && MCV_WITH_GLOSS
    struct mcv_gloss_interaction
        *gloss;        /* where to keep what is worked out of a glossy surface, or NULL */
    uint *gloss_known; /* 1: it is there */
#endif
} mcv_interaction;

MCV_LOOP_FUNCTION mcv_interaction mcv_meet_at(mcv_surface surface, mcv_vec3 direction) {
    mcv_interaction interaction;
    interaction.surface = surface;
    interaction.direction = direction;
    interaction.inside = mcv_dot(direction, interaction.surface.face) > 0.0f;
    interaction.face = mcv_scale(interaction.surface.face, interaction.inside ? -1.0f : 1.0f);
    interaction.normal = mcv_scale(interaction.surface.normal, interaction.inside ? -1.0f : 1.0f);
    interaction.normal = mcv_choose(mcv_dot(direction, interaction.normal) < 0.0f,
                                    interaction.normal, interaction.face);
#if MCV_TILE && MCV_WITH_DIFFUSE
    interaction.bounces = 0;
#endif
#if MCV_TILE && MCV_WITH_GLOSS
    interaction.gloss = 0;
#endif
    return interaction;
}

/* The surface that a ray from the origin has met. */
MCV_LOOP_FUNCTION mcv_surface mcv_hit_surface(mcv_world world, mcv_vec3 origin, mcv_vec3 direction,
                                              mcv_hit hit) {
#if MCV_WITH_SURFACES
    if (hit.triangle >= MCV_EXACT)
        return mcv_exact_surface_at(world, hit.triangle, hit.u, origin, direction, hit.t);
#else
    (void)origin, (void)direction;
#endif
    return mcv_surface_at(world, hit.triangle, hit.u, hit.v);
}

#if MCV_WITH_CONTACT
MCV_FUNCTION mcv_vec3 mcv_larger(mcv_vec3 a, mcv_vec3 b) {
    return mcv_vec(fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z));
}

#if MCV_WITH_SURFACES
/* Where a ray meets an exact surface, and where it would meet a mesh's in the same place: both
 * round, and the corners have been rounded. */
MCV_FUNCTION float mcv_exact_rounding(mcv_vec3 at, float size) {
    return MCV_GAMMA(16) * (mcv_abs(at.x) + mcv_abs(at.y) + mcv_abs(at.z) + size);
}

/*
 * Exact surfaces of dielectrics in the same place as the one met, but those of its own lens: what
 * is no farther away than places are rounded. The next ray starts twice as far off, or knows that
 * it starts on that surface.
 */
static void mcv_find_exact_contacts(mcv_world world, uint own, mcv_interaction *interaction) {
    const uint met = interaction->surface.triangle;
    const uint group = met >= MCV_EXACT ? world.solids[mcv_solid_of(met)].group : MCV_NONE;
    const mcv_vec3 at = interaction->surface.point;
    const mcv_vec3 e = interaction->surface.error;
    for (uint i = 0; i < world.frame->solid_count; ++i) {
        __global const mcv_device_solid *solid = world.solids + i;
        const float reach = mcv_exact_rounding(at, solid->bound) + e.x + e.y + e.z;
        const mcv_vec3 p = mcv_into_frame(solid, mcv_from_middle(solid, at));
        uint piece = MCV_PIECE_COUNT;
        mcv_vec3 face = p;
        if (solid->group == group || solid->side == MCV_SIDE_OPEN) continue;
        for (uint k = solid->side == MCV_SIDE_SPHERE ? MCV_PIECE_SIDE : 0u; k < MCV_PIECE_COUNT;
             ++k) {
            float outside;
            const mcv_vec3 normal = mcv_piece_gradient(solid, k, p, &outside);
            if (!(outside <= reach)) {
                piece = MCV_PIECE_COUNT;
                break;
            }
            if (outside < -reach) continue;
            piece = k;
            face = mcv_out_of_frame(solid, normal);
        }
        if (piece == MCV_PIECE_COUNT) continue;
        const uint medium = world.instances[solid->instance[piece]].medium;
        if (medium == 0u || medium == own) continue;
        if (mcv_dot(interaction->direction, face) > 0.0f)
            interaction->exited |= 1u << (medium - 1u);
        else
            interaction->entered |= 1u << (medium - 1u);
        const float off = 2.0f * reach;
        interaction->surface.error = mcv_larger(interaction->surface.error, mcv_vec(off, off, off));
        if (met < MCV_EXACT) {
            interaction->touched = mcv_exact_hit(i, piece);
            interaction->touched_face = face;
        }
    }
}
#endif

/*
 * Surfaces of dielectric bodies in the same place as the one that the ray has met: so close behind
 * that the next ray's origin, which is moved off the surface by its error, might lie beyond them,
 * too. From each found the next is looked for.
 */
static void mcv_find_contacts(mcv_world world, mcv_vec3 origin, mcv_hit hit,
                              mcv_interaction *interaction) {
    interaction->exited = interaction->entered = 0u;
    interaction->touched = MCV_NONE;
    const uint own = world.instances[interaction->surface.instance].medium;
#if MCV_WITH_SURFACES
    if (own != 0u) mcv_find_exact_contacts(world, own, interaction);
#endif
    interaction->beyond_point = interaction->surface.point;
    interaction->beyond_error = interaction->surface.error;
    if (own == 0u) return;
    uint crossed = 1u << (own - 1u) | interaction->exited | interaction->entered;
    mcv_vec3 e = interaction->surface.error;
#if MCV_WITH_SURFACES
    const float rounding =
        hit.triangle >= MCV_EXACT ? mcv_exact_rounding(interaction->surface.point, 0.0f) : 0.0f;
    e = mcv_larger(e, mcv_vec(rounding, rounding, rounding));
#endif
    for (int i = 0; i < (int)MCV_MAX_MEDIA; ++i) {
        const mcv_vec3 f = interaction->face;
        const float reach = mcv_abs(f.x) * e.x + mcv_abs(f.y) * e.y + mcv_abs(f.z) * e.z;
        const float band =
            2.0f * reach / -mcv_dot(interaction->direction, f) + 2.0f * MCV_GAMMA(16) * hit.t;
        hit = mcv_next_hit_ray(world.nodes, world.leaves, origin, interaction->direction, hit,
                               hit.t + band);
        if (hit.triangle == MCV_NONE) return;
        const mcv_surface next = mcv_surface_at(world, hit.triangle, hit.u, hit.v);
        const uint medium = world.instances[next.instance].medium;
        if (medium == 0u) return;
        const uint bit = 1u << (medium - 1u);
        /* A body that is crossed once more is on the ray's side again. */
        if (crossed & bit) {
            if (medium == own) return;
            interaction->exited &= ~bit;
            interaction->entered &= ~bit;
        } else if (mcv_dot(interaction->direction, next.face) > 0.0f) {
            interaction->exited |= bit;
        } else {
            interaction->entered |= bit;
        }
        crossed ^= bit;
        e = mcv_larger(e, next.error);
#if MCV_WITH_SURFACES
        interaction->surface.error =
            mcv_larger(interaction->surface.error, mcv_scale(e, rounding > 0.0f ? 2.0f : 0.0f));
#else
        e = next.error;
#endif
        interaction->beyond_point = next.point;
        interaction->beyond_error = e;
    }
}
#endif

MCV_FUNCTION mcv_interaction mcv_meet(mcv_world world, mcv_vec3 origin, mcv_vec3 direction,
                                      mcv_hit hit) {
    mcv_interaction interaction =
        mcv_meet_at(mcv_hit_surface(world, origin, direction, hit), direction);
#if MCV_WITH_CONTACT
    mcv_find_contacts(world, origin, hit, &interaction);
#endif
    return interaction;
}

/* The origin of a ray that goes on from there. */
MCV_FUNCTION mcv_vec3 mcv_onward_origin(mcv_interaction interaction, mcv_vec3 direction) {
#if MCV_WITH_CONTACT
    if (mcv_dot(direction, interaction.face) < 0.0f)
        return mcv_offset_origin(interaction.beyond_point, interaction.beyond_error,
                                 interaction.face, direction);
#endif
    return mcv_offset_origin(interaction.surface.point, interaction.surface.error, interaction.face,
                             direction);
}

#if MCV_WITH_SURFACES
/* What a ray remembers of the exact surface that it starts on (mcv_mark_origin_surface), or
 * MCV_NONE. */
MCV_LOOP_FUNCTION uint mcv_origin_surface_of(mcv_world world, mcv_interaction interaction,
                                             mcv_vec3 direction) {
    mcv_surface surface = interaction.surface;
#if MCV_WITH_CONTACT
    if (interaction.touched != MCV_NONE) {
        surface.triangle = interaction.touched;
        surface.face = interaction.touched_face;
    }
#endif
    return mcv_mark_origin_surface(world, surface, direction);
}
#endif

/* How a path goes on. */
typedef struct mcv_scattering {
    mcv_vec3 direction;
    mcv_color factor; /* of the throughput; all 0: the path ends */
    float density;    /* [1/sr], 0 for smooth surfaces */
    float chance; /* with which a surface of glass, a sheet or a beam splitter chose this way on of
                     its two */
    float remainder; /* rough glass: what is left of the number that chose it */
    uint media;
    uint event; /* MCV_EVENT_… */
} mcv_scattering;

#if MCV_WITH_DIELECTRIC || MCV_WITH_SHEET
/* a or b, word by word as in mcv_choose. */
MCV_LOOP_FUNCTION mcv_scattering mcv_choose_scattering(int condition, mcv_scattering a,
                                                       mcv_scattering b) {
    mcv_scattering chosen;
    chosen.direction = mcv_choose(condition, a.direction, b.direction);
    MCV_EACH_CHANNEL(i) chosen.factor.c[i] = condition ? a.factor.c[i] : b.factor.c[i];
    chosen.density = condition ? a.density : b.density;
    chosen.chance = condition ? a.chance : b.chance;
    chosen.media = condition ? a.media : b.media;
    chosen.event = condition ? a.event : b.event;
    return chosen;
}

/* One of a smooth surface's two ways on; *other is the other one. */
MCV_LOOP_FUNCTION mcv_scattering mcv_choose_way(mcv_scattering reflected, mcv_scattering passed,
                                                int reflects, mcv_scattering *other) {
    *other = mcv_choose_scattering(reflects, passed, reflected);
    return mcv_choose_scattering(reflects, reflected, passed);
}
#endif

#if MCV_WITH_DIELECTRIC || MCV_WITH_SHEET || MCV_WITH_MIRROR || MCV_WITH_GLOSS
MCV_LOOP_FUNCTION mcv_vec3 mcv_reflected(mcv_interaction interaction) {
    const mcv_vec3 d = mcv_reflect(interaction.direction, interaction.normal);
    return mcv_choose(mcv_dot(d, interaction.face) > 0.0f, d,
                      mcv_reflect(interaction.direction, interaction.face));
}
#endif

#if MCV_WITH_DIELECTRIC
/* The sets of media on the ray's side of a body's surface, where the path's is mended, and beyond
 * it. */
typedef struct mcv_crossing {
    uint before, after;
    mcv_device_interface between;
#if MCV_WITH_GLOSS
    uint albedos; /* of the interface, MCV_NONE: it is smooth */
#endif
} mcv_crossing;

MCV_LOOP_FUNCTION mcv_crossing mcv_cross_surface(mcv_world world,
                                                 const mcv_interaction *interaction, uint media) {
    mcv_crossing crossing;
    const uint bit = 1u << (world.instances[interaction->surface.instance].medium - 1u);
    uint exited = interaction->inside ? bit : 0u,
         entered = interaction->inside ? 0u : bit; /* media of the bodies that the surface bounds */
#if MCV_WITH_CONTACT
    exited |= interaction->exited;
    entered |= interaction->entered;
#endif
#if MCV_WITH_SURFACES
    /* The body in contact, on the other side. */
    if (interaction->surface.triangle >= MCV_EXACT && interaction->surface.u > 0.0f) {
        const uint other =
            1u << (world.instances[world.solids[(uint)interaction->surface.u - 1u].instance[0]]
                       .medium -
                   1u);
        exited |= interaction->inside ? 0u : other;
        entered |= interaction->inside ? other : 0u;
    }
#endif
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
#if MCV_WITH_GLOSS
    crossing.albedos = world.interface_albedos[at];
#endif
    return crossing;
}

/* Where light goes that passes a surface behind which it has the cosine c2 > 0 to its normal. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_refracted(mcv_device_interface between, mcv_interaction interaction,
                                         float cosine, float c2) {
    const mcv_vec3 d = mcv_refract(between, interaction.direction, interaction.normal, cosine, c2);
    const float f1 = -mcv_dot(interaction.direction, interaction.face);
    const float f2 = mcv_refracted_cosine(between, f1);
    const mcv_vec3 flat = mcv_refract(between, interaction.direction, interaction.face, f1, f2);
    return mcv_choose(mcv_dot(d, interaction.face) < 0.0f, d,
                      mcv_choose(f2 > 0.0f, flat, interaction.direction));
}

/*
 * xi in [0, 1) chooses reflection with probability R; 1 always refracts where that is possible.
 * Equal indices pass all, total reflection nothing: the other way has no chance then.
 */
MCV_LOOP_FUNCTION mcv_scattering mcv_scatter_dielectric(mcv_world world,
                                                        mcv_interaction interaction, uint media,
                                                        float xi, uint *unmatched,
                                                        mcv_scattering *other) {
    mcv_scattering reflected, refracted;
    const mcv_crossing crossing = mcv_cross_surface(world, &interaction, media);
    const mcv_device_interface between = crossing.between;
    const float c1 = -mcv_dot(interaction.direction, interaction.normal);
    const float cosine = c1 < 1.0f ? c1 : 1.0f;
    const float c2 = mcv_refracted_cosine(between, cosine);
    const int bends = between.delta != 0.0f, total = bends & !(c2 > 0.0f);
    const float reflectance = bends ? mcv_interface_reflectance(between, cosine, c2) : 0.0f;
    *unmatched += crossing.before != media;
    reflected.factor = refracted.factor = mcv_grey(1.0f);
    reflected.density = refracted.density = 0.0f;
    reflected.chance = reflectance;
    reflected.media = crossing.before;
    reflected.direction = mcv_reflected(interaction);
    reflected.event = MCV_EVENT_REFLECT;
    refracted.chance = 1.0f - reflectance;
    refracted.media = crossing.after;
    refracted.direction =
        mcv_choose(bends, mcv_refracted(between, interaction, cosine, c2), interaction.direction);
    refracted.event = bends ? MCV_EVENT_REFRACT : MCV_EVENT_PASS;
    return mcv_choose_way(reflected, refracted, total | (xi < reflectance), other);
}
#endif

#if MCV_WITH_SHEET
static mcv_scattering mcv_scatter_sheet(mcv_world world, mcv_interaction interaction,
                                        mcv_device_material material, mcv_color transmittance,
                                        uint media, float xi, mcv_scattering *other) {
    mcv_scattering reflected, passed;
    mcv_device_interface into;
    into.eta = material.eta;
    into.delta = material.delta;
#if MCV_WITH_DIELECTRIC
    /* The table holds it in vacuum. */
    if (media != 0) {
        const float squared = material.eta * material.eta /
                              world.media[mcv_filling_medium(media)].inverse_index_squared;
        into.eta = mcv_sqrt(squared);
        into.delta = 1.0f - squared;
    }
#else
    (void)world;
#endif
    const float c1 = -mcv_dot(interaction.direction, interaction.normal);
    const float cosine = c1 < 1.0f ? c1 : 1.0f;
    reflected.chance = mcv_sheet_reflectance(into, cosine);
    reflected.direction = mcv_reflected(interaction);
    reflected.factor = mcv_grey(1.0f);
    reflected.density = 0.0f;
    reflected.media = media;
    reflected.event = MCV_EVENT_REFLECT;
    passed.chance = 1.0f - reflected.chance;
    passed.direction = interaction.direction;
    passed.factor = transmittance;
    passed.density = 0.0f;
    passed.media = media;
    passed.event = MCV_EVENT_PASS;
    return mcv_choose_way(reflected, passed, xi < reflected.chance, other);
}
#endif

#if MCV_WITH_SHEET
static mcv_scattering mcv_scatter_beam_splitter(mcv_interaction interaction,
                                                mcv_device_material material, uint media, float xi,
                                                mcv_scattering *other) {
    mcv_scattering reflected, passed;
    reflected.chance = material.chance;
    reflected.direction = mcv_reflected(interaction);
    MCV_EACH_CHANNEL(i) reflected.factor.c[i] = material.value[i] / reflected.chance;
    reflected.density = 0.0f;
    reflected.media = media;
    reflected.event = MCV_EVENT_REFLECT;
    passed.chance = 1.0f - material.chance;
    passed.direction = interaction.direction;
    MCV_EACH_CHANNEL(i) passed.factor.c[i] = material.passed[i] / passed.chance;
    passed.density = 0.0f;
    passed.media = media;
    passed.event = MCV_EVENT_PASS;
    return mcv_choose_way(reflected, passed, xi < reflected.chance, other);
}
#endif

#if MCV_WITH_DIFFUSE
MCV_LOOP_FUNCTION mcv_scattering mcv_scatter_diffuse(mcv_interaction interaction,
                                                     mcv_color reflectance, uint media,
                                                     mcv_pair pair) {
    mcv_scattering scattering;
#if MCV_TILE
    if (interaction.bounces) {
        scattering.direction = interaction.bounce;
        scattering.density = interaction.bounce_density;
    } else
#endif
        scattering.direction =
            mcv_diffuse_sample(interaction.normal, pair.x, pair.y, &scattering.density);
    scattering.chance = 1.0f;
    const int reflects = mcv_dot(scattering.direction, interaction.face) > 0.0f;
    MCV_EACH_CHANNEL(i) scattering.factor.c[i] = reflects ? reflectance.c[i] : 0.0f;
    scattering.media = media;
    scattering.event = MCV_EVENT_END;
    return scattering;
}

#if MCV_WITH_TRANSLUCENT
/* The side is chosen by the two shares; what lies beyond is seen from behind. */
static mcv_scattering mcv_scatter_translucent(mcv_world world, mcv_interaction interaction,
                                              uint material, uint media, mcv_pair pair,
                                              float choice) {
    const float chance = world.materials[material].chance;
    const int through = choice >= chance;
    if (through) {
        interaction.normal = mcv_scale(interaction.normal, -1.0f);
        interaction.face = mcv_scale(interaction.face, -1.0f);
#if MCV_TILE
        interaction.bounces = 0; /* that has been worked out for the other side */
#endif
    }
    const mcv_color share = through ? mcv_material_passed(world, interaction.surface, material)
                                    : mcv_material_value(world, interaction.surface, material);
    const float own = through ? 1.0f - chance : chance;
    mcv_scattering scattering =
        mcv_scatter_diffuse(interaction, mcv_dim(share, 1.0f / own), media, pair);
    scattering.density *= own;
    return scattering;
}
#endif
#endif

#if MCV_WITH_GLOSS
/* A glossy surface as a ray meets it. */
typedef struct mcv_gloss_interaction {
    mcv_gloss gloss;
    mcv_vec3 x, y, z; /* the frame of the surface */
    mcv_vec3 o;       /* in that frame */
    mcv_lobes lobes;
    uint near_media, far_media; /* of light on the ray's side and on the other */
} mcv_gloss_interaction;

MCV_FUNCTION mcv_vec3 mcv_gloss_local(const mcv_gloss_interaction *m, mcv_vec3 v) {
    return mcv_vec(mcv_dot(v, m->x), mcv_dot(v, m->y), mcv_dot(v, m->z));
}

/* Whether the material is one of microfacets: a smooth metal is not. */
static int mcv_is_rough(mcv_world world, const mcv_interaction *interaction, uint media) {
    const mcv_device_instance instance = world.instances[interaction->surface.instance];
    const uint type = world.materials[instance.material].type;
    if (!world.materials[instance.material].scattering_sides) return 0;
#if MCV_WITH_DIELECTRIC
    if (type == MCV_MATERIAL_DIELECTRIC)
        return mcv_cross_surface(world, interaction, media).albedos != MCV_NONE;
#else
    (void)media;
#endif
    return type == MCV_MATERIAL_METALLIC_ROUGHNESS || type == MCV_MATERIAL_CONDUCTOR;
}

/* The surface's values are those of its table, `from`, but the roughness, the metallic share and
 * the colour where textures give them. */
MCV_LOOP_FUNCTION mcv_gloss_interaction mcv_make_gloss_interaction_of(
    mcv_world world, const mcv_interaction *interaction, const mcv_device_gloss *from, uint type,
    mcv_color base, float scale, float metallic, uint media) {
    mcv_gloss_interaction m;
    const float roughness = from->roughness * scale;
    const float alpha =
        roughness * roughness > MCV_LEAST_ALPHA ? roughness * roughness : MCV_LEAST_ALPHA;
    m.near_media = m.far_media = media;
    m.gloss.type = type;
    m.gloss.base = base;
    m.gloss.metallic = from->metallic * metallic;
    m.gloss.layer = from->roughnesses > 1u ? scale * (float)(from->roughnesses - 1) : 0.0f;
    m.gloss.table = from->table;
    m.gloss.inside = interaction->inside;
    m.gloss.between.eta = 1.0f;
    m.gloss.between.delta = 0.0f;
    m.gloss.alpha.x = mcv_fma(1.0f - alpha, from->anisotropy, alpha);
    m.gloss.alpha.y = alpha;
#if MCV_WITH_DIELECTRIC
    if (m.gloss.type == MCV_MATERIAL_DIELECTRIC) {
        const mcv_crossing crossing = mcv_cross_surface(world, interaction, media);
        m.near_media = crossing.before;
        m.far_media = crossing.after;
        m.gloss.between = crossing.between;
        /* A body has none of its own, MCV_NONE. Of a choice between two places the loop over paths
         * would not be vectorised. */
        m.gloss.table &= crossing.albedos;
    } else {
        m.gloss.between.eta =
            mcv_sqrt(world.media[mcv_filling_medium(media)].inverse_index_squared);
    }
#endif

    m.z = interaction->normal;
    mcv_basis(m.z, &m.x, &m.y);
    if (from->anisotropy > 0.0f) {
        const mcv_vec3 tangent = mcv_tangent(world, interaction->surface, from->direction);
        const mcv_vec3 x = mcv_along(tangent, -mcv_dot(tangent, m.z), m.z);
        if (mcv_dot(x, x) > 0.0f) m.x = mcv_normalize(x);
        m.y = mcv_cross(m.z, m.x);
    }
    m.o = mcv_gloss_local(&m, mcv_scale(interaction->direction, -1.0f));
    m.lobes = mcv_gloss_lobes(from, &m.gloss, world.albedos, m.o);
    return m;
}

static mcv_gloss_interaction mcv_make_gloss_interaction(mcv_world world,
                                                        const mcv_interaction *interaction,
                                                        uint material, uint media) {
    const mcv_device_gloss from = world.gloss[material];
    float scale = 1.0f, metallic = 1.0f;
#if MCV_WITH_TEXTURE
    if (from.texture != MCV_NONE) {
        const float s = mcv_image_place(world, interaction->surface, from.texture, 0);
        const float t = mcv_image_place(world, interaction->surface, from.texture, 1);
        scale = mcv_texture_value(world, from.texture, s, t, 1);
        metallic = mcv_texture_value(world, from.texture, s, t, 2);
    }
#endif
    return mcv_make_gloss_interaction_of(world, interaction, &from, world.materials[material].type,
                                         mcv_material_value(world, interaction->surface, material),
                                         scale, metallic, media);
}

/* The same, worked out once for a path's surface, or in the given room. */
MCV_FUNCTION const mcv_gloss_interaction *mcv_known_gloss(mcv_world world,
                                                          const mcv_interaction *interaction,
                                                          uint material, uint media,
                                                          mcv_gloss_interaction *room) {
#if MCV_TILE
    if (interaction->gloss) {
        if (*interaction->gloss_known) return interaction->gloss;
        *interaction->gloss_known = 1u;
        room = interaction->gloss;
    }
#endif
    *room = mcv_make_gloss_interaction(world, interaction, material, media);
    return room;
}

/* The direction is unit. Where the interpolated normal and the face disagree on its side nothing
 * comes. */
MCV_LOOP_FUNCTION mcv_response mcv_respond_gloss_of(mcv_world world,
                                                    const mcv_interaction *interaction,
                                                    const mcv_device_gloss *from,
                                                    const mcv_gloss_interaction *m,
                                                    mcv_vec3 direction) {
    const mcv_vec3 i = mcv_gloss_local(m, direction);
    const int far = i.z < 0.0f;
    const float side = mcv_dot(direction, interaction->face);
    const int comes = far ? side < 0.0f : side > 0.0f;
    mcv_response response = mcv_gloss_respond(from, &m->gloss, world.albedos, &m->lobes, m->o, i);
    MCV_EACH_CHANNEL(c) response.value.c[c] = comes ? response.value.c[c] : 0.0f;
    response.density = comes ? response.density : 0.0f;
    response.media = far ? m->far_media : m->near_media;
    return response;
}

static __attribute__((noinline)) mcv_response
mcv_respond_gloss(mcv_world world, const mcv_interaction *interaction, uint material,
                  const mcv_gloss_interaction *m, mcv_vec3 direction) {
    const mcv_device_gloss from = world.gloss[material];
    return mcv_respond_gloss_of(world, interaction, &from, m, direction);
}

MCV_LOOP_FUNCTION mcv_vec3 mcv_choose_gloss_of(const mcv_device_gloss *from,
                                               const mcv_gloss_interaction *m, mcv_pair pair,
                                               float choice) {
    const mcv_vec3 i = mcv_gloss_sample(from, &m->gloss, &m->lobes, m->o, pair.x, pair.y, choice);
    return mcv_normalize(mcv_along(mcv_along(mcv_scale(m->z, i.z), i.y, m->y), i.x, m->x));
}

/* A way on in a direction that has been chosen. */
MCV_LOOP_FUNCTION mcv_scattering mcv_turn_by_gloss(mcv_world world,
                                                   const mcv_interaction *interaction,
                                                   const mcv_device_gloss *from,
                                                   const mcv_gloss_interaction *m,
                                                   mcv_vec3 direction) {
    mcv_scattering scattering;
    const mcv_response response = mcv_respond_gloss_of(world, interaction, from, m, direction);
    const float scale = 1.0f / response.density;
    MCV_EACH_CHANNEL(c)
    scattering.factor.c[c] = response.density > 0.0f ? response.value.c[c] * scale : 0.0f;
    scattering.direction = direction;
    scattering.density = response.density;
    scattering.chance = 1.0f;
    scattering.remainder = 0.0f;
    scattering.media = response.media;
    scattering.event = MCV_EVENT_END;
    return scattering;
}

/* The microfacet of rough glass that has turned light one way turns it the other way, too: *other,
 * whose chance is 0 where it does not. */
MCV_LOOP_FUNCTION mcv_scattering mcv_split_by_gloss(mcv_world world,
                                                    const mcv_interaction *interaction,
                                                    const mcv_device_gloss *from,
                                                    const mcv_gloss_interaction *m, mcv_pair pair,
                                                    float choice, mcv_scattering *other) {
    mcv_scattering on =
        mcv_turn_by_gloss(world, interaction, from, m, mcv_choose_gloss_of(from, m, pair, choice));
    const mcv_vec3 h = mcv_ggx_sample(m->gloss.alpha, m->o, pair.x, pair.y);
    const float specular = m->lobes.specular,
                share = mcv_gloss_fresnel(from, &m->gloss, mcv_dot(m->o, h)).c[0];
    const int turns = choice < specular, reflects = choice < specular * share;
    on.chance = turns ? (reflects ? share : 1.0f - share) : 1.0f;
    on.remainder = choice / specular;
    *other = mcv_turn_by_gloss(
        world, interaction, from, m,
        mcv_choose_gloss_of(from, m, pair,
                            reflects ? specular * (1.0f - MCV_UNIT_ROUNDOFF) : 0.0f));
    other->chance = 1.0f - on.chance;
    return on;
}

static mcv_scattering mcv_scatter_gloss(mcv_world world, mcv_interaction interaction, uint material,
                                        uint media, mcv_pair pair, float choice, int parts,
                                        mcv_scattering *other) {
    mcv_gloss_interaction room;
    const mcv_device_gloss from = world.gloss[material];
    const mcv_gloss_interaction *m = mcv_known_gloss(world, &interaction, material, media, &room);
    if (parts && m->gloss.type == MCV_MATERIAL_DIELECTRIC)
        return mcv_split_by_gloss(world, &interaction, &from, m, pair, choice, other);
    return mcv_turn_by_gloss(world, &interaction, &from, m,
                             mcv_choose_gloss_of(&from, m, pair, choice));
}

/* A smooth metal. */
static mcv_scattering mcv_scatter_conductor(mcv_world world, mcv_interaction interaction,
                                            uint material, uint media) {
    mcv_scattering scattering;
    __global const mcv_device_gloss *from = world.gloss + material;
    float scale = 1.0f;
#if MCV_WITH_DIELECTRIC
    scale = mcv_sqrt(world.media[mcv_filling_medium(media)].inverse_index_squared);
#endif
    const float cosine = -mcv_dot(interaction.direction, interaction.normal);
    MCV_EACH_CHANNEL(i)
    scattering.factor.c[i] = mcv_conductor_fresnel(from->n[i] * scale, from->k[i] * scale,
                                                   cosine < 1.0f ? cosine : 1.0f);
    scattering.direction = mcv_reflected(interaction);
    scattering.density = 0.0f;
    scattering.chance = 1.0f;
    scattering.media = media;
    scattering.event = MCV_EVENT_REFLECT;
    return scattering;
}
#endif

#if MCV_WITH_RETROREFLECTOR
/* The direction is unit. Where the interpolated normal and the face disagree on its side nothing
 * comes. */
static mcv_response mcv_respond_retroreflector(mcv_world world, mcv_interaction interaction,
                                               uint material, uint media, mcv_vec3 direction) {
    mcv_response response =
        mcv_retroreflector_respond(world.materials + material, interaction.normal,
                                   mcv_scale(interaction.direction, -1.0f), direction);
    if (!(mcv_dot(direction, interaction.face) > 0.0f)) {
        response.value = mcv_grey(0.0f);
        response.density = 0.0f;
    }
    response.media = media;
    return response;
}

static mcv_scattering mcv_scatter_retroreflector(mcv_world world, mcv_interaction interaction,
                                                 uint material, uint media, mcv_pair pair,
                                                 float choice) {
    mcv_scattering scattering;
    __global const mcv_device_material *from = world.materials + material;
    const mcv_vec3 o = mcv_scale(interaction.direction, -1.0f);
    const mcv_retroreflection back = mcv_retroreflection_at(from, interaction.normal, o);
    const int returns = back.chance > 0.0f && choice >= 1.0f - back.chance;
    scattering.media = media;
    scattering.chance = 1.0f;
    scattering.event = MCV_EVENT_END;
    if (returns && from->spread == 0.0f) {
        scattering.direction = o;
        MCV_EACH_CHANNEL(i) scattering.factor.c[i] = from->value[i] * back.efficiency / back.chance;
        scattering.density = 0.0f;
        scattering.chance = back.chance;
        scattering.event = MCV_EVENT_REFLECT;
        return scattering;
    }
    scattering.direction =
        mcv_retroreflector_choose(from, interaction.normal, o, pair.x, pair.y, returns);
    const mcv_response response =
        mcv_respond_retroreflector(world, interaction, material, media, scattering.direction);
    scattering.factor =
        response.density > 0.0f ? mcv_dim(response.value, 1.0f / response.density) : mcv_grey(0.0f);
    scattering.density = response.density;
    return scattering;
}
#endif

#if MCV_WITH_DIFFUSE
/* The direction is unit. */
MCV_LOOP_FUNCTION mcv_response mcv_respond_diffuse(const mcv_interaction *interaction,
                                                   mcv_color reflectance, uint media,
                                                   mcv_vec3 direction) {
    mcv_response response;
    const float cosine = mcv_dot(direction, interaction->normal);
    const int comes = (cosine > 0.0f) & (mcv_dot(direction, interaction->face) > 0.0f);
    response.density = comes ? mcv_diffuse_density(cosine) : 0.0f;
    response.value = mcv_dim(reflectance, response.density);
    response.media = media;
    return response;
}
#endif

#if MCV_WITH_NEXT_EVENT
/* The direction is unit and leads away from the surface; what cannot come from there is 0. */
MCV_FUNCTION mcv_response mcv_respond(mcv_world world, mcv_interaction interaction, uint media,
                                      mcv_vec3 direction) {
    mcv_response response;
    const mcv_device_instance instance = world.instances[interaction.surface.instance];
    response.value = mcv_grey(0.0f);
    response.density = 0.0f;
    response.media = media;
#if MCV_WITH_DIFFUSE
    if (world.materials[instance.material].type == MCV_MATERIAL_DIFFUSE) {
#if MCV_WITH_TRANSLUCENT
        const float cosine = mcv_dot(direction, interaction.normal);
        if (cosine < 0.0f && mcv_dot(direction, interaction.face) < 0.0f) {
            response.density = mcv_diffuse_density(-cosine);
            response.value =
                mcv_dim(mcv_material_passed(world, interaction.surface, instance.material),
                        response.density);
            response.density *= 1.0f - world.materials[instance.material].chance;
            return response;
        }
#endif
        response = mcv_respond_diffuse(
            &interaction, mcv_material_value(world, interaction.surface, instance.material), media,
            direction);
#if MCV_WITH_TRANSLUCENT
        response.density *= world.materials[instance.material].chance;
#endif
    }
#endif
#if MCV_WITH_GLOSS
    if (mcv_is_rough(world, &interaction, media)) {
        mcv_gloss_interaction room;
        const mcv_gloss_interaction *m =
            mcv_known_gloss(world, &interaction, instance.material, media, &room);
        return mcv_respond_gloss(world, &interaction, instance.material, m, direction);
    }
#endif
#if MCV_WITH_RETROREFLECTOR
    if (world.materials[instance.material].type == MCV_MATERIAL_RETROREFLECTOR)
        return mcv_respond_retroreflector(world, interaction, instance.material, media, direction);
#endif
    return response;
}
#endif

#if MCV_WITH_LIGHT_TRACING
MCV_LOOP_FUNCTION int mcv_is_connectable(mcv_world world, mcv_interaction interaction) {
    return world.materials[world.instances[interaction.surface.instance].material].connectable;
}

MCV_LOOP_FUNCTION int mcv_is_near_specular(mcv_world world, mcv_interaction interaction) {
    return world.materials[world.instances[interaction.surface.instance].material].near_specular;
}

/* Does the surface pass light straight on, but for what it reflects? */
MCV_LOOP_FUNCTION int mcv_is_sheet(mcv_world world, mcv_interaction interaction) {
    const uint type = world.materials[world.instances[interaction.surface.instance].material].type;
    return type == MCV_MATERIAL_SHEET || type == MCV_MATERIAL_BEAM_SPLITTER;
}
#endif

/* Chooses how the path goes on from the surface it met. *other: how it would have by the other way
 * on of a smooth surface that has two, and if the path may part there, of rough glass; elsewhere
 * its chance is 0. */
MCV_FUNCTION mcv_scattering mcv_scatter(mcv_world world, mcv_interaction interaction, uint media,
                                        mcv_pair pair, float choice, int parts, uint *unmatched,
                                        mcv_scattering *other) {
    mcv_scattering scattering;
    const mcv_device_instance instance = world.instances[interaction.surface.instance];
    const mcv_device_material material = world.materials[instance.material];
    scattering.direction = interaction.direction;
    scattering.factor = mcv_grey(0.0f);
    scattering.density = 0.0f;
    scattering.chance = 1.0f;
    scattering.media = media;
    scattering.event = MCV_EVENT_END;
    *other = scattering;
    other->chance = 0.0f;
#if MCV_WITH_GLOSS
    if (mcv_is_rough(world, &interaction, media)) {
#if MCV_WITH_DIELECTRIC
        if (instance.medium != 0 && mcv_cross_surface(world, &interaction, media).before != media)
            *unmatched += 1u;
#endif
        return mcv_scatter_gloss(world, interaction, instance.material, media, pair, choice, parts,
                                 other);
    }
    if (material.type == MCV_MATERIAL_CONDUCTOR)
        return mcv_scatter_conductor(world, interaction, instance.material, media);
#else
    (void)choice, (void)parts;
#endif
#if MCV_WITH_DIELECTRIC
    if (material.type == MCV_MATERIAL_DIELECTRIC)
        return mcv_scatter_dielectric(world, interaction, media, pair.x, unmatched, other);
#else
    (void)unmatched;
#endif
#if MCV_WITH_RETROREFLECTOR
    if (material.type == MCV_MATERIAL_RETROREFLECTOR)
        return mcv_scatter_retroreflector(world, interaction, instance.material, media, pair,
                                          choice);
#endif
#if MCV_WITH_DIFFUSE
    if (material.type == MCV_MATERIAL_DIFFUSE) {
#if MCV_WITH_TRANSLUCENT
        return mcv_scatter_translucent(world, interaction, instance.material, media, pair, choice);
#endif
        return mcv_scatter_diffuse(
            interaction, mcv_material_value(world, interaction.surface, instance.material), media,
            pair);
    }
#endif
#if MCV_WITH_SHEET
    if (material.type == MCV_MATERIAL_SHEET) {
        return mcv_scatter_sheet(world, interaction, material,
                                 mcv_material_value(world, interaction.surface, instance.material),
                                 media, pair.x, other);
    }
#endif
#if MCV_WITH_SHEET
    if (material.type == MCV_MATERIAL_BEAM_SPLITTER)
        return mcv_scatter_beam_splitter(interaction, material, media, pair.x, other);
#endif
#if MCV_WITH_MIRROR
    if (material.type == MCV_MATERIAL_MIRROR) {
        scattering.direction = mcv_reflected(interaction);
        scattering.factor = mcv_material_value(world, interaction.surface, instance.material);
        scattering.event = MCV_EVENT_REFLECT;
    }
#endif
    (void)material;
    (void)pair;
    return scattering;
}

#endif
