/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/path_steps.h"

#include "reference/lights.h"
#include "reference/trail.h"

/* Russian roulette from this surface on, for throughputs below the threshold. */
enum { ROULETTE_DEPTH = 8 };
#define ROULETTE_THRESHOLD 0.25

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

const ref_emitter *ref_sampled_emitter(const ref_world *world, uint32_t instance) {
    for (uint32_t i = 0; i < world->emitters.count; ++i)
        if (world->scene->emitters[world->emitters.items[i].index].instance == instance)
            return &world->emitters.items[i];
    return NULL;
}

/* Adds the emission of a surface that the path has hit. */
static void add_emission(const ref_world *world, const ref_path *p, const ref_surface *surface,
                         const mcv_medium_params *filling, double radiance[3]) {
    double emitted[3], weight = 1;
    ref_emitted(world->scene, surface, ref_scale(-1, p->direction), emitted);
    if (ref_largest(emitted) == 0) return;
    if (p->density > 0)
        weight = ref_weight_against(
            p->density, ref_emitter_density(ref_sampled_emitter(world, surface->instance),
                                            p->origin, p->direction, surface));
    for (int channel = 0; channel < 3; ++channel) {
        emitted[channel] = weight * p->throughput[channel] * emitted[channel] /
                           pow(ref_media_ior(filling, channel), 2);
        radiance[channel] += emitted[channel];
    }
    ref_trail_emission(p->trail, world->scene, surface, ref_scale(-1, p->direction), emitted);
}

/* Adds the sky that the path sees. */
static void add_sky(const ref_world *world, const ref_path *p, const mcv_medium_params *filling,
                    double radiance[3]) {
    double sky[3];
    uint32_t emitter = 0;
    ref_environment(world->scene, &world->emitters, p->direction, sky);
    for (int channel = 0; channel < 3; ++channel) {
        /* The emission is infinitely far away. */
        const bool arrives = !filling || filling->absorption[channel] == 0;
        sky[channel] = arrives ? p->throughput[channel] * sky[channel] /
                                     pow(ref_media_ior(filling, channel), 2)
                               : 0;
        radiance[channel] += sky[channel];
    }
    while (emitter + 1 < world->scene->emitter_count &&
           world->scene->emitters[emitter].type != MCV_EMITTER_ENVIRONMENT)
        ++emitter;
    ref_trail_light(p->trail, emitter, p->direction, true, sky);
}

/* Russian roulette on the throughput. */
static bool survives(ref_path *p, ref_random *random) {
    const double chance = ref_largest(p->throughput) / ROULETTE_THRESHOLD;
    if (chance >= 1) return true;
    if (ref_random_unit(random) >= chance) return false;
    for (int channel = 0; channel < 3; ++channel) p->throughput[channel] /= chance;
    return true;
}

void ref_path_value(const ref_world *world, const ref_sensor_ray *sensor_ray, ref_random *random,
                    ref_tally *tally, ref_trail *trail, double value[3]) {
    ref_path p = {.origin = sensor_ray->origin,
                  .direction = sensor_ray->direction,
                  .media = world->media,
                  .throughput = {1, 1, 1},
                  .trail = trail};
    const mcv_medium_params *around = ref_media_filling(&p.media, world->scene);
    double scale[3];
    ref_world then;
    if (world->geometry.moving > 0) {
        then = *world;
        then.geometry.time = sensor_ray->time;
        world = &then;
    }
    value[0] = value[1] = value[2] = 0;
    for (int channel = 0; channel < 3; ++channel)
        scale[channel] = sensor_ray->weight * pow(ref_media_ior(around, channel), 2);
    ref_trail_begin(trail, sensor_ray, scale);
    if (sensor_ray->weight == 0) return; /* the lens stops it */
    ++tally->paths;
    tally->begun += sensor_ray->weight;
    for (uint32_t met = 0;; ++met) {
        if (met == world->depth) {
            ++tally->depth_cut;
            tally->cut += sensor_ray->weight * ref_largest(p.throughput);
            break;
        }
        const mcv_medium_params *filling = ref_media_filling(&p.media, world->scene);
        ref_hit hit;
        ++tally->rays;
        if (!ref_next_hit(&world->geometry, p.origin, p.direction, &p.skip, &hit)) {
            add_sky(world, &p, filling, value);
            break;
        }
        const ref_surface surface = ref_surface_at(&world->geometry, &hit);
        if (filling)
            for (int channel = 0; channel < 3; ++channel)
                p.throughput[channel] *= exp(-filling->absorption[channel] * hit.distance);
        add_emission(world, &p, &surface, filling, value);
        const ref_vec before = p.direction;
        ref_trail_meet(trail, &surface);
        const ref_hits hits = ref_hits_at(&world->geometry, p.origin, p.direction, &p.skip, &hit);
        if (!ref_meet_surface(world, &p, &surface, &hits, met + 1 == world->depth, random, tally,
                              value))
            break;
        ref_trail_leave(trail, &surface, before, p.direction, p.density > 0);
        if (ref_largest(p.throughput) == 0 || (met + 1 >= ROULETTE_DEPTH && !survives(&p, random)))
            break;
        p.origin = surface.position;
        p.skip = hits.numbers;
    }
    for (int channel = 0; channel < 3; ++channel) value[channel] *= scale[channel];
}
