/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/trail.h"

#include "reference/emission.h"

static void put(double to[3], ref_vec v) {
    to[0] = v.x;
    to[1] = v.y;
    to[2] = v.z;
}

void ref_trail_begin(ref_trail *trail, const ref_sensor_ray *ray, const double scale[3]) {
    if (!trail) return;
    trail->contribution.surface_count = 0;
    put(trail->contribution.sensor, ray->origin);
    for (int channel = 0; channel < 3; ++channel) trail->scale[channel] = scale[channel];
}

void ref_trail_meet(ref_trail *trail, const ref_surface *surface) {
    if (!trail) return;
    mcv_contribution *c = &trail->contribution;
    const uint32_t at = c->surface_count++;
    if (at >= MCV_PATH_SURFACES) return;
    put(c->surfaces[at].position, surface->position);
    c->surfaces[at].instance = surface->instance;
    c->surfaces[at].way = MCV_WAY_SCATTERS; /* while it looks for emitters */
}

void ref_trail_leave(ref_trail *trail, const ref_surface *surface, ref_vec before, ref_vec after,
                     bool scatters) {
    if (!trail || scatters || trail->contribution.surface_count > MCV_PATH_SURFACES) return;
    const bool crosses =
        ref_dot(before, surface->geometric) * ref_dot(after, surface->geometric) > 0;
    const bool straight = before.x == after.x && before.y == after.y && before.z == after.z;
    trail->contribution.surfaces[trail->contribution.surface_count - 1].way =
        straight  ? MCV_WAY_PASSES
        : crosses ? MCV_WAY_REFRACTS
                  : MCV_WAY_REFLECTS;
}

void ref_trail_emission(ref_trail *trail, const mcv_scene *scene, const ref_surface *surface,
                        ref_vec direction, const double light[3]) {
    if (!trail) return;
    trail->contribution.has_pixel =
        ref_emitting_pixel(scene, surface, direction, trail->contribution.pixel);
    ref_trail_light(trail, scene->instances[surface->instance].emitter, surface->position, false,
                    light);
    trail->contribution.has_pixel = false;
}

void ref_trail_light(ref_trail *trail, uint32_t emitter, ref_vec from, bool is_far,
                     const double light[3]) {
    if (!trail || !(ref_largest(light) > 0)) return;
    mcv_contribution *c = &trail->contribution;
    c->emitter = emitter;
    c->is_far = is_far;
    put(c->from, from);
    for (int channel = 0; channel < 3; ++channel)
        c->value[channel] = light[channel] * trail->scale[channel];
    trail->told(trail->user, c);
}
