/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/path.h"

#include "reference/interface.h"
#include "reference/lights.h"
#include "reference/retroreflector.h"
#include "reference/texture.h"

/* Russian roulette from this surface on, for throughputs below the threshold. */
enum { ROULETTE_DEPTH = 8 };
#define ROULETTE_THRESHOLD 0.25

typedef struct path {
    ref_vec origin, direction;
    ref_skip skip; /* the surfaces it starts on */
    ref_media media;
    double throughput[3];
    double density; /* with which the direction was chosen [1/sr] if emitters were sampled too; else
                       0: emission counts in full */
} path;

ref_hits ref_hits_at(const ref_geometry *geometry, ref_vec origin, ref_vec direction,
                     const ref_skip *skip, const ref_hit *hit) {
    ref_hit together[REF_SKIPS];
    ref_hits hits = {.count = ref_hits_together(geometry, origin, direction, skip, hit, together)};
    hits.numbers.count = hits.count;
    for (uint32_t i = 0; i < hits.count; ++i) {
        const ref_surface surface = ref_surface_at(geometry, together + i);
        hits.instances[i] = surface.instance;
        hits.fronts[i] = ref_dot(direction, surface.geometric) < 0;
        hits.numbers.numbers[i] = surface.number;
    }
    return hits;
}

static void multiply(double a[3], const double b[3]) {
    for (int channel = 0; channel < 3; ++channel) a[channel] *= b[channel];
}

static double largest(const double a[3]) { return fmax(a[0], fmax(a[1], a[2])); }

static const ref_emitter *sampled_emitter(const ref_world *world, uint32_t instance) {
    for (uint32_t i = 0; i < world->emitters.count; ++i)
        if (world->scene->emitters[world->emitters.items[i].index].instance == instance)
            return &world->emitters.items[i];
    return NULL;
}

/* The channel of a path that carries only one. */
static int kept_channel(const path *p) {
    return p->throughput[1] > 0 ? 1 : p->throughput[2] > 0 ? 2 : 0;
}

/* Where a medium on either side refracts channels differently only one of them goes on. */
static void keep_channel(path *p, const mcv_dielectric_params *near,
                         const mcv_dielectric_params *far, ref_random *random) {
    const bool parts = (near && !mcv_is_grey(near->ior)) || (far && !mcv_is_grey(far->ior));
    const double all = p->throughput[0] + p->throughput[1] + p->throughput[2];
    if (!parts || largest(p->throughput) == all) return;
    double at = ref_random_unit(random) * all;
    int kept = 0;
    while (kept < 2 && at >= p->throughput[kept]) at -= p->throughput[kept++];
    for (int channel = 0; channel < 3; ++channel)
        p->throughput[channel] = channel == kept ? all : 0;
}

/* Of what was chosen with one density and could have been with another: the power heuristic of
 * exponent 2. */
static double weight_against(double own, double other) {
    const double ratio = other / own;
    return 1 / (1 + ratio * ratio);
}

/* Adds the emission of a surface that the path has met. */
static void add_emission(const ref_world *world, const path *p, const ref_surface *surface,
                         const mcv_dielectric_params *filling, double radiance[3]) {
    double emitted[3], weight = 1;
    ref_emitted(world->scene, surface, ref_scale(-1, p->direction), emitted);
    if (largest(emitted) == 0) return;
    if (p->density > 0)
        weight = weight_against(p->density,
                                ref_emitter_density(sampled_emitter(world, surface->instance),
                                                    p->origin, p->direction, surface));
    for (int channel = 0; channel < 3; ++channel)
        radiance[channel] += weight * p->throughput[channel] * emitted[channel] /
                             pow(ref_media_ior(filling, channel), 2);
}

/* A surface that spreads light, as the path meets it. */
typedef struct spreader {
    const mcv_material *material;
    ref_interaction interaction;
    double share[3];       /* diffuse: its reflectance there … */
    double passed[3];      /* … and its transmittance */
    const ref_media *near; /* media around light on the path's side … */
    ref_media far;         /* … and on the other */
    const mcv_retroreflector_params
        *returns;    /* a retroreflector that spreads what returns, or NULL */
    ref_gloss gloss; /* of microfacets, in this frame, seen from o: */
    ref_vec x, y, o;
} spreader;

static ref_vec to_frame(const spreader *s, ref_vec v) {
    return (ref_vec){ref_dot(v, s->x), ref_dot(v, s->y), ref_dot(v, s->interaction.normal)};
}

static ref_vec from_frame(const spreader *s, ref_vec v) {
    return ref_add(ref_scale(v.z, s->interaction.normal),
                   ref_add(ref_scale(v.x, s->x), ref_scale(v.y, s->y)));
}

/* The chance with which a path stays on its side of a diffuse surface. */
static double reflects(const spreader *s) {
    const double passed = largest(s->passed);
    return passed > 0 ? largest(s->share) / (largest(s->share) + passed) : 1;
}

/* f cosθ for light from the direction, and the density with which the path would choose it. */
static double respond(const spreader *s, ref_vec direction, double value[3]) {
    const double cosine = ref_dot(direction, s->interaction.normal);
    value[0] = value[1] = value[2] = 0;
    if (cosine * ref_dot(direction, s->interaction.face) <= 0)
        return 0; /* normal and face disagree on its side */
    if (s->gloss.material)
        return ref_gloss_evaluate(&s->gloss, s->o, to_frame(s, direction), value);
    if (s->returns)
        return ref_retroreflector_evaluate(s->returns, s->o, to_frame(s, direction), value);
    for (int channel = 0; channel < 3; ++channel)
        value[channel] = (cosine > 0 ? s->share : s->passed)[channel] * fabs(cosine) / M_PI;
    return (cosine > 0 ? reflects(s) : 1 - reflects(s)) * fabs(cosine) / M_PI;
}

/* A direction with the density that `respond` gives; the zero vector: the path ends. */
static ref_vec choose(const spreader *s, ref_random *random) {
    if (s->gloss.material) return from_frame(s, ref_gloss_sample(&s->gloss, s->o, random));
    if (s->returns) return from_frame(s, ref_retroreflector_sample(s->returns, s->o, random));
    /* Density cosθ/π: sin²θ is uniform. */
    const double u = ref_random_unit(random), phi = 2 * M_PI * ref_random_unit(random),
                 sine = sqrt(u);
    const bool stays = largest(s->passed) == 0 || ref_random_unit(random) < reflects(s);
    return from_frame(
        s, (ref_vec){sine * cos(phi), sine * sin(phi), stays ? sqrt(1 - u) : -sqrt(1 - u)});
}

/* Adds the light of one emitter at a surface that spreads it. */
static void add_direct(const ref_world *world, const path *p, const ref_emitter *emitter,
                       const ref_surface *surface, const spreader *s, ref_random *random,
                       ref_tally *tally, double radiance[3]) {
    uint32_t number;
    double value[3];
    const ref_vec direction =
        ref_emitter_sample(emitter, world->scene, surface->position, random, &number);
    const double own = respond(s, direction, value);
    if (!(largest(value) > 0)) return;
    ref_hit hit;
    ++tally->shadow_rays;
    if (!ref_closest_hit(&world->geometry, surface->position, direction, surface->number, &hit))
        return;
    const bool met = number == MCV_NONE
                         ? world->scene->instances[hit.triangle->instance].emitter == emitter->index
                         : hit.triangle->number == number;
    if (!met) return;
    const ref_surface source = ref_surface_at(&world->geometry, &hit);
    double emitted[3];
    ref_emitted(world->scene, &source, ref_scale(-1, direction), emitted);
    const double density = ref_emitter_density(emitter, surface->position, direction, &source);
    if (largest(emitted) == 0 || density == 0) return;
    const bool beyond = ref_dot(direction, s->interaction.face) < 0;
    const mcv_dielectric_params *filling =
        ref_media_filling(beyond ? &s->far : s->near, world->scene);
    const double ior = ref_media_ior(filling, kept_channel(p));
    const double scale = weight_against(density, own) / density / (ior * ior);
    for (int channel = 0; channel < 3; ++channel) {
        const double absorption = filling ? exp(-filling->absorption[channel] * hit.distance) : 1;
        radiance[channel] +=
            p->throughput[channel] * value[channel] * emitted[channel] * absorption * scale;
    }
}

/* Adds the light of one beam or light without extent at a surface that spreads it. */
static void add_light(const ref_world *world, const path *p, const mcv_emitter *emitter,
                      const ref_surface *surface, const spreader *s, ref_tally *tally,
                      double radiance[3]) {
    ref_light light;
    double value[3];
    if (!ref_light_at(world->scene, emitter, surface->position, &light)) return;
    respond(s, light.direction, value);
    if (!(largest(value) > 0)) return;
    ref_hit hit;
    ++tally->shadow_rays;
    const bool blocked = ref_closest_hit(&world->geometry, surface->position, light.direction,
                                         surface->number, &hit) &&
                         hit.distance < light.distance && hit.triangle->instance != light.instance;
    if (blocked) return;
    const bool beyond = ref_dot(light.direction, s->interaction.face) < 0;
    const mcv_dielectric_params *filling =
        ref_media_filling(beyond ? &s->far : s->near, world->scene);
    const double ior = ref_media_ior(filling, kept_channel(p));
    for (int channel = 0; channel < 3; ++channel) {
        const double absorption = filling && filling->absorption[channel] > 0
                                      ? exp(-filling->absorption[channel] * light.distance)
                                      : 1;
        radiance[channel] += p->throughput[channel] * value[channel] * light.irradiance[channel] *
                             absorption / (ior * ior);
    }
}

/* Each of these continues the path or ends it (false). */

static bool meet_spreader(const ref_world *world, path *p, const ref_surface *surface,
                          const spreader *s, bool last, ref_random *random, ref_tally *tally,
                          double radiance[3]) {
    if (world->sample_emitters && !last)
        for (uint32_t i = 0; i < world->emitters.count; ++i)
            add_direct(world, p, &world->emitters.items[i], surface, s, random, tally, radiance);
    for (uint32_t i = 0; i < world->scene->emitter_count && !last; ++i)
        add_light(world, p, &world->scene->emitters[i], surface, s, tally, radiance);
    double value[3];
    const ref_vec direction = choose(s, random);
    const double density = respond(s, direction, value);
    if (!(density > 0)) return false; /* into the surface: absorbed */
    p->direction = ref_unit(direction);
    p->density = world->sample_emitters ? density : 0;
    if (ref_dot(direction, s->interaction.face) < 0) p->media = s->far;
    for (int channel = 0; channel < 3; ++channel)
        p->throughput[channel] *= value[channel] / density;
    return true;
}

/* The frame of a surface of microfacets: its first axis is the rougher direction. */
static void find_frame(const ref_surface *surface, spreader *s) {
    const double rotation = mcv_material_roughness(s->material).rotation;
    ref_frame(s->interaction.normal, &s->x, &s->y);
    if (ref_dot(surface->tangent, surface->tangent) > 0) {
        const ref_vec across =
            ref_scale(surface->hand, ref_cross(surface->normal, surface->tangent));
        const ref_vec turned =
            ref_add(ref_scale(cos(rotation), surface->tangent), ref_scale(sin(rotation), across));
        const ref_vec flat = ref_sub(
            turned, ref_scale(ref_dot(turned, s->interaction.normal), s->interaction.normal));
        if (ref_dot(flat, flat) > 0) s->x = ref_unit(flat);
        s->y = ref_cross(s->interaction.normal, s->x);
    }
    s->o = to_frame(s, ref_scale(-1, s->interaction.direction));
}

static bool meet_dielectric(const ref_world *world, path *p, const ref_surface *surface,
                            const ref_hits *hits, bool last, ref_random *random, ref_tally *tally,
                            double radiance[3]) {
    const ref_interaction interaction = ref_make_interaction(surface, p->direction);
    ref_media beyond;
    if (!ref_media_cross_all(&p->media, &beyond, hits->count, hits->instances, hits->fronts))
        ++tally->unmatched;
    const mcv_dielectric_params *near = ref_media_filling(&p->media, world->scene),
                                *far = ref_media_filling(&beyond, world->scene);
    keep_channel(p, near, far, random);
    const double from = ref_media_ior(near, kept_channel(p)),
                 to = ref_media_ior(far, kept_channel(p));
    const uint32_t number = world->scene->instances[surface->instance].material;
    const double outside = ref_media_ior(interaction.front ? near : far, MCV_ALBEDO_CHANNEL);
    const ref_gloss_table *table = ref_gloss_find(&world->gloss, world->scene, number, outside);
    if (table && from != to) {
        spreader s = {.material = &world->scene->materials[number],
                      .interaction = interaction,
                      .near = &p->media,
                      .far = beyond};
        s.gloss = (ref_gloss){.material = s.material,
                              .table = table,
                              .roughness = 1,
                              .from = from,
                              .to = to,
                              .inside = !interaction.front};
        find_frame(surface, &s);
        return meet_spreader(world, p, surface, &s, last, random, tally, radiance);
    }
    const double coating = from == to ? 0
                                      : mcv_material_coating(&world->scene->materials[number],
                                                             interaction.front ? from : to);
    if (ref_random_unit(random) <
        ref_coated(ref_reflectance(&interaction, from, to), coating, from, to)) {
        p->direction = ref_reflect(&interaction);
    } else {
        p->direction = ref_refract(&interaction, from, to);
        p->media = beyond;
    }
    return true;
}

static void meet_mirror(path *p, const ref_surface *surface, const double reflectance[3]) {
    const ref_interaction interaction = ref_make_interaction(surface, p->direction);
    p->direction = ref_reflect(&interaction);
    multiply(p->throughput, reflectance);
}

static void meet_sheet(const ref_world *world, path *p, const ref_surface *surface, double ior,
                       const double transmittance[3], ref_random *random) {
    const ref_interaction interaction = ref_make_interaction(surface, p->direction);
    const double outside =
        ref_media_ior(ref_media_filling(&p->media, world->scene), kept_channel(p));
    if (ref_random_unit(random) <
        ref_sheet_reflectance(ref_reflectance(&interaction, outside, ior)))
        p->direction = ref_reflect(&interaction);
    else
        multiply(p->throughput, transmittance);
}

/* One of its two ways by their largest shares. */
static void meet_beam_splitter(path *p, const ref_surface *surface,
                               const mcv_beam_splitter_params *splitter, ref_random *random) {
    const ref_interaction interaction = ref_make_interaction(surface, p->direction);
    const double reflected = largest(splitter->reflectance),
                 all = reflected + largest(splitter->transmittance);
    const bool reflects = ref_random_unit(random) * all < reflected;
    const double chance = (reflects ? reflected : all - reflected) / all;
    multiply(p->throughput, reflects ? splitter->reflectance : splitter->transmittance);
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
    multiply(product, parameter);
}

static void meet_conductor(const ref_world *world, path *p, const ref_surface *surface,
                           const mcv_conductor_params *metal) {
    const ref_interaction interaction = ref_make_interaction(surface, p->direction);
    const mcv_dielectric_params *filling = ref_media_filling(&p->media, world->scene);
    const double cosine = fmin(-ref_dot(interaction.direction, interaction.normal), 1);
    for (int channel = 0; channel < 3; ++channel) {
        const double outside = ref_media_ior(filling, channel);
        p->throughput[channel] *= ref_conductor_reflectance(metal->n[channel] / outside,
                                                            metal->k[channel] / outside, cosine);
    }
    p->direction = ref_reflect(&interaction);
}

/* An opaque or thin surface of microfacets. */
static bool meet_gloss(const ref_world *world, path *p, const ref_surface *surface, bool last,
                       ref_random *random, ref_tally *tally, double radiance[3]) {
    const uint32_t number = world->scene->instances[surface->instance].material;
    const mcv_material *material = &world->scene->materials[number];
    const uint32_t texture = mcv_material_surface_texture(material);
    spreader s = {.material = material,
                  .interaction = ref_make_interaction(surface, p->direction),
                  .near = &p->media,
                  .far = p->media};
    s.gloss = (ref_gloss){
        .material = material,
        .table = ref_gloss_find(&world->gloss, world->scene, number, 0),
        .roughness = 1,
        .from = ref_media_ior(ref_media_filling(&p->media, world->scene), kept_channel(p))};
    if (material->type == MCV_MATERIAL_METALLIC_ROUGHNESS) {
        double scales[3];
        ref_texture_lookup(world->scene, texture, surface->texcoord, scales);
        modulate(world, surface, material->as.metallic_roughness.baseColor, s.gloss.base);
        s.gloss.roughness = scales[1];
        s.gloss.metallic = material->as.metallic_roughness.metallic * scales[2];
    }
    find_frame(surface, &s);
    return meet_spreader(world, p, surface, &s, last, random, tally, radiance);
}

/* Where light returns exactly, what is scattered diffusely is a surface of its own. */
static bool meet_retroreflector(const ref_world *world, path *p, const ref_surface *surface,
                                bool last, ref_random *random, ref_tally *tally,
                                double radiance[3]) {
    const mcv_material *material =
        &world->scene->materials[world->scene->instances[surface->instance].material];
    const mcv_retroreflector_params *r = &material->as.retroreflector;
    spreader s = {.material = material,
                  .interaction = ref_make_interaction(surface, p->direction),
                  .near = &p->media,
                  .far = p->media};
    find_frame(surface, &s);
    if (r->divergence > 0) {
        s.returns = r;
        return meet_spreader(world, p, surface, &s, last, random, tally, radiance);
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
    return largest(s.share) > 0 &&
           meet_spreader(world, p, surface, &s, last, random, tally, radiance);
}

static bool meet_surface(const ref_world *world, path *p, const ref_surface *surface,
                         const ref_hits *hits, bool last, ref_random *random, ref_tally *tally,
                         double radiance[3]) {
    const mcv_material *material =
        &world->scene->materials[world->scene->instances[surface->instance].material];
    double share[3];
    p->density = 0; /* emitters behind smooth surfaces, passed straight or not, are not sampled */
    switch (material->type) {
    case MCV_MATERIAL_DIFFUSE: {
        spreader s = {.material = material,
                      .interaction = ref_make_interaction(surface, p->direction),
                      .near = &p->media,
                      .far = p->media};
        find_frame(surface, &s);
        modulate(world, surface, material->as.diffuse.reflectance, s.share);
        modulate(world, surface, material->as.diffuse.transmittance, s.passed);
        return meet_spreader(world, p, surface, &s, last, random, tally, radiance);
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
    case MCV_MATERIAL_SHEET:
        modulate(world, surface, material->as.sheet.transmittance, share);
        meet_sheet(world, p, surface, material->as.sheet.ior, share, random);
        return true;
    case MCV_MATERIAL_MIRROR:
        modulate(world, surface, material->as.mirror.reflectance, share);
        meet_mirror(p, surface, share);
        return true;
    case MCV_MATERIAL_BEAM_SPLITTER:
        meet_beam_splitter(p, surface, &material->as.beam_splitter, random);
        return true;
    default:
        return false;
    }
}

/* Russian roulette on the throughput. */
static bool survives(path *p, ref_random *random) {
    const double chance = largest(p->throughput) / ROULETTE_THRESHOLD;
    if (chance >= 1) return true;
    if (ref_random_unit(random) >= chance) return false;
    for (int channel = 0; channel < 3; ++channel) p->throughput[channel] /= chance;
    return true;
}

void ref_path_value(const ref_world *world, const ref_sensor_ray *sensor_ray, ref_random *random,
                    ref_tally *tally, double value[3]) {
    path p = {.origin = sensor_ray->origin,
              .direction = sensor_ray->direction,
              .media = world->media,
              .throughput = {1, 1, 1}};
    const mcv_dielectric_params *around = ref_media_filling(&p.media, world->scene);
    value[0] = value[1] = value[2] = 0;
    if (sensor_ray->weight == 0) return; /* the lens stops it */
    ++tally->paths;
    tally->begun += sensor_ray->weight;
    for (uint32_t met = 0;; ++met) {
        if (met == world->depth) {
            ++tally->depth_cut;
            tally->cut += sensor_ray->weight * largest(p.throughput);
            break;
        }
        const mcv_dielectric_params *filling = ref_media_filling(&p.media, world->scene);
        ref_hit hit;
        ++tally->rays;
        if (!ref_next_hit(&world->geometry, p.origin, p.direction, &p.skip, &hit)) {
            double sky[3];
            ref_environment(world->scene, &world->emitters, p.direction, sky);
            for (int channel = 0; channel < 3; ++channel)
                if (!filling || filling->absorption[channel] == 0) /* it is infinitely far away */
                    value[channel] += p.throughput[channel] * sky[channel] /
                                      pow(ref_media_ior(filling, channel), 2);
            break;
        }
        const ref_surface surface = ref_surface_at(&world->geometry, &hit);
        if (filling)
            for (int channel = 0; channel < 3; ++channel)
                p.throughput[channel] *= exp(-filling->absorption[channel] * hit.distance);
        add_emission(world, &p, &surface, filling, value);
        const ref_hits hits = ref_hits_at(&world->geometry, p.origin, p.direction, &p.skip, &hit);
        if (!meet_surface(world, &p, &surface, &hits, met + 1 == world->depth, random, tally,
                          value))
            break;
        if (largest(p.throughput) == 0 || (met + 1 >= ROULETTE_DEPTH && !survives(&p, random)))
            break;
        p.origin = surface.position;
        p.skip = hits.numbers;
    }
    for (int channel = 0; channel < 3; ++channel)
        value[channel] *= sensor_ray->weight * pow(ref_media_ior(around, channel), 2);
}
