/* SPDX-License-Identifier: Apache-2.0 */
/* What each material does with a path. Each function continues the path or ends it (false). */
#include "reference/path_steps.h"

#include "reference/plate.h"
#include "reference/retroreflector.h"
#include "reference/texture.h"
#include "scene/materials.h"
#include "scene/spectra.h"

/* Where a medium on either side refracts channels differently only one of them goes on. */
static void keep_channel(ref_path *p, const mcv_medium_params *near, const mcv_medium_params *far,
                         ref_random *random) {
    const bool parts = (near && !mcv_is_grey(near->ior)) || (far && !mcv_is_grey(far->ior));
    const double all = p->throughput[0] + p->throughput[1] + p->throughput[2];
    if (!parts || ref_largest(p->throughput) == all) return;
    double at = ref_random_unit(random) * all;
    int kept = 0;
    while (kept < 2 && at >= p->throughput[kept]) at -= p->throughput[kept++];
    for (int channel = 0; channel < 3; ++channel)
        p->throughput[channel] = channel == kept ? all : 0;
}

static void meet_mirror(ref_path *p, const ref_surface *surface, const double reflectance[3]) {
    const ref_interaction interaction = ref_make_interaction(surface, p->direction);
    p->direction = ref_reflect(&interaction);
    ref_multiply(p->throughput, reflectance);
}

/* One of the two ways of a plate by their largest shares. */
static void meet_plate(const ref_world *world, ref_path *p, const ref_surface *surface,
                       const mcv_material *material, ref_random *random) {
    const ref_interaction interaction = ref_make_interaction(surface, p->direction);
    const double outside =
        ref_media_ior(ref_media_filling(&p->media, world->scene), ref_kept_channel(p));
    double texture[3];
    ref_texture_lookup(world->scene, material->texture, surface->texcoord, texture);
    const ref_plate plate = ref_plate_at(material, &interaction, outside, texture);
    const double reflected = ref_largest(plate.reflected),
                 all = reflected + ref_largest(plate.passed);
    const bool reflects = ref_random_unit(random) * all < reflected;
    const double chance = (reflects ? reflected : all - reflected) / all;
    ref_multiply(p->throughput, reflects ? plate.reflected : plate.passed);
    for (int channel = 0; channel < 3; ++channel)
        p->throughput[channel] = all > 0 ? p->throughput[channel] / chance : 0;
    if (reflects) p->direction = ref_reflect(&interaction);
}

/* `parameter` times the material's texture. */
static void modulate(const ref_world *world, const ref_surface *surface, const double parameter[3],
                     double product[3]) {
    const mcv_material *material =
        &world->scene->materials[world->scene->instances[surface->instance].material];
    ref_texture_lookup(world->scene, material->texture, surface->texcoord, product);
    ref_multiply(product, parameter);
}

static void meet_conductor(const ref_world *world, ref_path *p, const ref_surface *surface,
                           const mcv_conductor_params *metal) {
    const ref_interaction interaction = ref_make_interaction(surface, p->direction);
    const mcv_medium_params *filling = ref_media_filling(&p->media, world->scene);
    const double cosine = fmin(-ref_dot(interaction.direction, interaction.normal), 1);
    for (int channel = 0; channel < 3; ++channel) {
        const double outside = ref_media_ior(filling, channel);
        p->throughput[channel] *= ref_conductor_reflectance(metal->n[channel] / outside,
                                                            metal->k[channel] / outside, cosine);
    }
    p->direction = ref_reflect(&interaction);
}

/* A surface between a path and its own media. */
static ref_scatterer scatterer_at(const ref_world *world, const ref_path *p,
                                  const ref_surface *surface) {
    ref_scatterer s = {
        .material = &world->scene->materials[world->scene->instances[surface->instance].material],
        .interaction = ref_make_interaction(surface, p->direction),
        .near = &p->media,
        .far = p->media};
    ref_find_frame(surface, &s);
    return s;
}

/* A surface between the path's media and those of bodies that the path would enter or leave. */
static ref_scatterer interface_at(const ref_world *world, ref_path *p, const ref_surface *surface,
                                  const ref_hits *hits, ref_random *random, ref_tally *tally) {
    ref_scatterer s = scatterer_at(world, p, surface);
    if (!ref_media_cross_all(&p->media, &s.far, hits->count, hits->instances, hits->fronts))
        ++tally->unmatched;
    const mcv_medium_params *near = ref_media_filling(&p->media, world->scene),
                            *far = ref_media_filling(&s.far, world->scene);
    keep_channel(p, near, far, random);
    s.from = ref_media_ior(near, ref_kept_channel(p));
    s.to = ref_media_ior(far, ref_kept_channel(p));
    return s;
}

/* A rough interface scatters, a smooth one reflects or refracts. */
static bool meet_dielectric(const ref_world *world, ref_path *p, const ref_surface *surface,
                            const ref_hits *hits, bool last, ref_random *random, ref_tally *tally,
                            double radiance[3]) {
    ref_scatterer s = interface_at(world, p, surface, hits, random, tally);
    const uint32_t number = world->scene->instances[surface->instance].material;
    const ref_media *outer = s.interaction.front ? s.near : &s.far;
    const double outside =
        ref_media_ior(ref_media_filling(outer, world->scene), MCV_ALBEDO_CHANNEL);
    const ref_gloss_table *table = ref_gloss_find(&world->gloss, world->scene, number, outside);
    if (table && s.from != s.to) {
        s.gloss = (ref_gloss){.material = s.material,
                              .table = table,
                              .roughness = 1,
                              .from = s.from,
                              .to = s.to,
                              .inside = !s.interaction.front};
        return ref_scatter(world, p, surface, &s, last, random, tally, radiance);
    }
    const double coating =
        s.from == s.to ? 0 : mcv_material_coating(s.material, s.interaction.front ? s.from : s.to);
    if (ref_random_unit(random) <
        ref_coated(ref_reflectance(&s.interaction, s.from, s.to), coating, s.from, s.to)) {
        p->direction = ref_reflect(&s.interaction);
    } else {
        p->direction = ref_refract(&s.interaction, s.from, s.to);
        p->media = s.far;
    }
    return true;
}

/* An opaque or thin surface of microfacets. */
static bool meet_gloss(const ref_world *world, ref_path *p, const ref_surface *surface, bool last,
                       ref_random *random, ref_tally *tally, double radiance[3]) {
    const uint32_t number = world->scene->instances[surface->instance].material;
    const mcv_material *material = &world->scene->materials[number];
    const uint32_t texture = mcv_material_surface_texture(material);
    ref_scatterer s = scatterer_at(world, p, surface);
    s.gloss = (ref_gloss){
        .material = material,
        .table = ref_gloss_find(&world->gloss, world->scene, number, 0),
        .roughness = 1,
        .from = ref_media_ior(ref_media_filling(&p->media, world->scene), ref_kept_channel(p))};
    if (material->type == MCV_MATERIAL_METALLIC_ROUGHNESS) {
        double scales[3];
        ref_texture_lookup(world->scene, texture, surface->texcoord, scales);
        modulate(world, surface, material->as.metallic_roughness.baseColor, s.gloss.base);
        s.gloss.roughness = scales[1];
        s.gloss.metallic = material->as.metallic_roughness.metallic * scales[2];
    }
    return ref_scatter(world, p, surface, &s, last, random, tally, radiance);
}

static double evaluate_retroreflector(const ref_scatterer *s, ref_vec i, double value[3]) {
    return ref_retroreflector_evaluate(&s->material->as.retroreflector, s->o, i, value);
}

static ref_vec sample_retroreflector(const ref_scatterer *s, ref_random *random) {
    return ref_retroreflector_sample(&s->material->as.retroreflector, s->o, random);
}

/* Where light returns exactly, what is scattered diffusely is a surface of its own. */
static bool meet_retroreflector(const ref_world *world, ref_path *p, const ref_surface *surface,
                                bool last, ref_random *random, ref_tally *tally,
                                double radiance[3]) {
    const mcv_material *material =
        &world->scene->materials[world->scene->instances[surface->instance].material];
    const mcv_retroreflector_params *r = &material->as.retroreflector;
    ref_scatterer s = scatterer_at(world, p, surface);
    if (r->divergence > 0) {
        s.evaluate = evaluate_retroreflector;
        s.sample = sample_retroreflector;
        return ref_scatter(world, p, surface, &s, last, random, tally, radiance);
    }
    const double chance = ref_retroreflector_chance(r, s.o);
    if (ref_random_unit(random) < chance) {
        for (int channel = 0; channel < 3; ++channel)
            p->throughput[channel] *=
                r->reflectance[channel] * ref_retroreflector_efficiency(r, s.o) / chance;
        p->direction = ref_scale(-1, p->direction);
        return true;
    }
    for (int channel = 0; channel < 3; ++channel) p->throughput[channel] /= 1 - chance;
    memcpy(s.share, r->diffuseReflectance, sizeof s.share);
    return ref_largest(s.share) > 0 &&
           ref_scatter(world, p, surface, &s, last, random, tally, radiance);
}

bool ref_meet_surface(const ref_world *world, ref_path *p, const ref_surface *surface,
                      const ref_hits *hits, bool last, ref_random *random, ref_tally *tally,
                      double radiance[3]) {
    const mcv_material *material =
        &world->scene->materials[world->scene->instances[surface->instance].material];
    double share[3];
    p->density = 0; /* emitters behind smooth surfaces, passed straight or not, are not sampled */
    switch (material->type) {
    case MCV_MATERIAL_DIFFUSE: {
        ref_scatterer s = scatterer_at(world, p, surface);
        modulate(world, surface, material->as.diffuse.reflectance, s.share);
        modulate(world, surface, material->as.diffuse.transmittance, s.passed);
        return ref_scatter(world, p, surface, &s, last, random, tally, radiance);
    }
    case MCV_MATERIAL_DIELECTRIC:
        return meet_dielectric(world, p, surface, hits, last, random, tally, radiance);
    case MCV_MATERIAL_CONDUCTOR:
        if (mcv_material_is_rough(material))
            return meet_gloss(world, p, surface, last, random, tally, radiance);
        meet_conductor(world, p, surface, &material->as.conductor);
        return true;
    case MCV_MATERIAL_METALLIC_ROUGHNESS:
        return meet_gloss(world, p, surface, last, random, tally, radiance);
    case MCV_MATERIAL_RETROREFLECTOR:
        return meet_retroreflector(world, p, surface, last, random, tally, radiance);
#define MCV_X(name, key, NAME) case MCV_MATERIAL_##NAME:
        MCV_PLATES(MCV_X)
#undef MCV_X
        meet_plate(world, p, surface, material, random);
        return true;
    case MCV_MATERIAL_MIRROR:
        modulate(world, surface, material->as.mirror.reflectance, share);
        meet_mirror(p, surface, share);
        return true;
    default:
        return false;
    }
}
