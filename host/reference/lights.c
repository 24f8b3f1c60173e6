/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/lights.h"

#include "reference/laser.h"
#include "reference/texture.h"
#include "scene/emitters.h"

static ref_vec axis_of(const mcv_transform *t, int axis) {
    return (ref_vec){t->m[axis], t->m[3 + axis], t->m[6 + axis]};
}

static ref_vec place_of(const mcv_transform *t) { return (ref_vec){t->m[9], t->m[10], t->m[11]}; }

static bool beam_at(const mcv_scene *scene, const mcv_emitter *emitter, ref_vec point,
                    ref_light *light) {
    const mcv_collimated_beam_params *p = &emitter->as.collimated_beam;
    const mcv_transform *place = &scene->instances[emitter->instance].to_world;
    const ref_vec way = ref_sub(point, place_of(place));
    const double x = ref_dot(way, axis_of(place, 0)), y = ref_dot(way, axis_of(place, 1)),
                 behind = ref_dot(way, axis_of(place, 2));
    if (behind >= 0 || fabs(x) > p->size[0] / 2 || fabs(y) > p->size[1] / 2) return false;
    if (p->aperture == MCV_APERTURE_CIRCLE && hypot(x, y) > fmin(p->size[0], p->size[1]) / 2)
        return false;
    light->direction = axis_of(place, 2);
    light->distance = -behind;
    light->instance = emitter->instance;
    if (emitter->texture == MCV_NONE) return true;
    const mcv_texture *image = &scene->textures[emitter->texture];
    const double column = (0.5 + (p->mirror ? -x : x) / p->size[0]) * image->width,
                 row = (0.5 - y / p->size[1]) * image->height;
    double rgb[3];
    ref_texel(image, (uint32_t)fmin(fmax(floor(column), 0), image->width - 1.0),
              (uint32_t)fmin(fmax(floor(row), 0), image->height - 1.0), rgb);
    for (int channel = 0; channel < 3; ++channel) light->irradiance[channel] *= rgb[channel];
    return true;
}

/* The share of its intensity that a light without extent sends at an angle from its axis. */
static double share_at(const mcv_emitter *emitter, double angle) {
    const mcv_spot_params *cone = &emitter->as.spot;
    switch (emitter->type) {
    case MCV_EMITTER_SPOT: {
        const double a = (cos(angle) - cos(cone->outerConeAngle)) /
                         (cos(cone->innerConeAngle) - cos(cone->outerConeAngle));
        return pow(fmin(fmax(a, 0), 1), 2);
    }
    default:
        return 1;
    }
}

static bool point_at(const mcv_emitter *emitter, ref_vec point, ref_light *light) {
    const ref_vec way = ref_sub(place_of(&emitter->to_world), point);
    const double range = *mcv_emitter_range(emitter);
    light->distance = ref_length(way);
    light->direction = ref_unit(way);
    double factor = share_at(emitter, ref_angle(light->direction, axis_of(&emitter->to_world, 2)));
    if (!isnan(range)) factor *= fmax(0, 1 - pow(light->distance / range, 4));
    for (int channel = 0; channel < 3; ++channel)
        light->irradiance[channel] *= factor / (light->distance * light->distance);
    return factor > 0;
}

bool ref_light_at(const mcv_scene *scene, const mcv_emitter *emitter, ref_vec point,
                  ref_random *random, ref_light *light) {
    *light = (ref_light){.instance = MCV_NONE};
    for (int channel = 0; channel < 3; ++channel)
        light->irradiance[channel] = emitter->radiance[channel];
    switch (emitter->type) {
    case MCV_EMITTER_COLLIMATED_BEAM:
        return beam_at(scene, emitter, point, light);
    case MCV_EMITTER_LASER:
        return ref_laser_at(scene, emitter, point, random, light);
    case MCV_EMITTER_DIRECTIONAL:
        light->direction = axis_of(&emitter->to_world, 2);
        light->distance = INFINITY;
        return true;
    default:
        return mcv_emitter_is_point_light(emitter->type) && point_at(emitter, point, light);
    }
}
