/* SPDX-License-Identifier: Apache-2.0 */
/* Surfaces that scatter light: their response, a direction from them, and light from emitters. */
#include "reference/path_steps.h"

#include "reference/lights.h"
#include "reference/trail.h"
#include "scene/materials.h"

static ref_vec to_frame(const ref_scatterer *s, ref_vec v) {
    return (ref_vec){ref_dot(v, s->x), ref_dot(v, s->y), ref_dot(v, s->interaction.normal)};
}

static ref_vec from_frame(const ref_scatterer *s, ref_vec v) {
    return ref_add(ref_scale(v.z, s->interaction.normal),
                   ref_add(ref_scale(v.x, s->x), ref_scale(v.y, s->y)));
}

/* The probability with which a path stays on its side of a diffuse surface. */
static double reflects(const ref_scatterer *s) {
    const double passed = ref_largest(s->passed);
    return passed > 0 ? ref_largest(s->share) / (ref_largest(s->share) + passed) : 1;
}

/* f cosθ for light from the direction, and the density with which the path would choose it. */
static double respond(const ref_scatterer *s, ref_vec direction, double value[3]) {
    const double cosine = ref_dot(direction, s->interaction.normal);
    value[0] = value[1] = value[2] = 0;
    if (cosine * ref_dot(direction, s->interaction.face) <= 0)
        return 0; /* normal and face disagree on its side */
    if (s->gloss.material)
        return ref_gloss_evaluate(&s->gloss, s->o, to_frame(s, direction), value);
    if (s->evaluate) return s->evaluate(s, to_frame(s, direction), value);
    for (int channel = 0; channel < 3; ++channel)
        value[channel] = (cosine > 0 ? s->share : s->passed)[channel] * fabs(cosine) / M_PI;
    return (cosine > 0 ? reflects(s) : 1 - reflects(s)) * fabs(cosine) / M_PI;
}

/* A direction with the density that `respond` gives; the zero vector: the path ends. */
static ref_vec choose(const ref_scatterer *s, ref_random *random) {
    if (s->gloss.material) return from_frame(s, ref_gloss_sample(&s->gloss, s->o, random));
    if (s->sample) return from_frame(s, s->sample(s, random));
    /* Density cosθ/π: sin²θ is uniform. */
    const double u = ref_random_unit(random), phi = 2 * M_PI * ref_random_unit(random),
                 sine = sqrt(u);
    const bool stays = ref_largest(s->passed) == 0 || ref_random_unit(random) < reflects(s);
    return from_frame(
        s, (ref_vec){sine * cos(phi), sine * sin(phi), stays ? sqrt(1 - u) : -sqrt(1 - u)});
}

/* Adds the light of one emitter at a surface that scatters it. */
static void add_direct(const ref_world *world, const ref_path *p, const ref_emitter *emitter,
                       const ref_surface *surface, const ref_scatterer *s, ref_random *random,
                       ref_tally *tally, double radiance[3]) {
    uint32_t number;
    double value[3];
    const ref_vec direction =
        ref_emitter_sample(emitter, world->scene, surface->position, random, &number);
    const double own = respond(s, direction, value);
    if (!(ref_largest(value) > 0)) return;
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
    if (ref_largest(emitted) == 0 || density == 0) return;
    const bool beyond = ref_dot(direction, s->interaction.face) < 0;
    const mcv_medium_params *filling = ref_media_filling(beyond ? &s->far : s->near, world->scene);
    const double ior = ref_media_ior(filling, ref_kept_channel(p));
    const double scale = ref_weight_against(density, own) / density / (ior * ior);
    for (int channel = 0; channel < 3; ++channel) {
        const double absorption = filling ? exp(-filling->absorption[channel] * hit.distance) : 1;
        emitted[channel] =
            p->throughput[channel] * value[channel] * emitted[channel] * absorption * scale;
        radiance[channel] += emitted[channel];
    }
    ref_trail_emission(p->trail, world->scene, &source, ref_scale(-1, direction), emitted);
}

/* Adds the light of one beam or light without extent at a surface that spreads it. */
static void add_light(const ref_world *world, const ref_path *p, const mcv_emitter *emitter,
                      const ref_surface *surface, const ref_scatterer *s, ref_random *random,
                      ref_tally *tally, double radiance[3]) {
    ref_light light;
    double value[3];
    if (!ref_light_at(world->scene, emitter, surface->position, random, &light)) return;
    respond(s, light.direction, value);
    if (!(ref_largest(value) > 0)) return;
    ref_hit hit;
    ++tally->shadow_rays;
    const bool blocked = ref_closest_hit(&world->geometry, surface->position, light.direction,
                                         surface->number, &hit) &&
                         hit.distance < light.distance && hit.triangle->instance != light.instance;
    if (blocked) return;
    const bool beyond = ref_dot(light.direction, s->interaction.face) < 0;
    const mcv_medium_params *filling = ref_media_filling(beyond ? &s->far : s->near, world->scene);
    const double ior = ref_media_ior(filling, ref_kept_channel(p));
    for (int channel = 0; channel < 3; ++channel) {
        const double absorption = filling && filling->absorption[channel] > 0
                                      ? exp(-filling->absorption[channel] * light.distance)
                                      : 1;
        value[channel] = p->throughput[channel] * value[channel] * light.irradiance[channel] *
                         absorption / (ior * ior);
        radiance[channel] += value[channel];
    }
    const bool is_far = !(light.distance < INFINITY);
    ref_trail_light(p->trail, (uint32_t)(emitter - world->scene->emitters),
                    is_far ? light.direction
                           : ref_add(surface->position, ref_scale(light.distance, light.direction)),
                    is_far, value);
}

void ref_find_frame(const ref_surface *surface, ref_scatterer *s) {
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

bool ref_scatter(const ref_world *world, ref_path *p, const ref_surface *surface,
                 const ref_scatterer *s, bool last, ref_random *random, ref_tally *tally,
                 double radiance[3]) {
    if (world->sample_emitters && !last)
        for (uint32_t i = 0; i < world->emitters.count; ++i)
            add_direct(world, p, &world->emitters.items[i], surface, s, random, tally, radiance);
    for (uint32_t i = 0; i < world->scene->emitter_count && !last; ++i)
        add_light(world, p, &world->scene->emitters[i], surface, s, random, tally, radiance);
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
