/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/filling.h"

#include <stdlib.h>

#include "reference/geometry.h"
#include "reference/random.h"
#include "reference/sensor_ray.h"
#include "scene/emitters.h"
#include "scene/sensors.h"

enum { PIXELS = 16, PLACES = 16, PLACES_IN_PIXEL = 4, MOST_RAYS = 1 << 18 };

/* Of one emitter: how many samples of the pupil see it, and how many of these it lights. */
typedef struct tally {
    uint64_t seen, lit;
    bool seen_now, lit_now; /* in the pixel at work */
} tally;

/* Is it dark from some directions? */
static bool has_cone(const mcv_emitter *emitter) {
    return emitter->type == MCV_EMITTER_PARALLEL ||
           emitter->type == MCV_EMITTER_TELECENTRIC_PROJECTOR ||
           emitter->type == MCV_EMITTER_LIGHT_FIELD_EMITTER ||
           emitter->type == MCV_EMITTER_PROJECTOR;
}

/* Does light of the image leave this place on a projector's lens in a direction? In the node's
 * axes, the image's tangents as in its header.
 */
static bool in_picture(const mcv_scene *scene, const mcv_emitter *emitter, ref_vec place,
                       ref_vec direction) {
    const mcv_projector_params *p = &emitter->as.projector;
    const double kappa = 1 / p->focalLength - 1 / p->imageDistance;
    uint32_t pixels[2];
    mcv_picture_resolution(&p->pattern, scene->textures + emitter->texture, pixels);
    if (!(direction.z < 0) || hypot(place.x, place.y) > p->lensDiameter / 2) return false;
    const double right = direction.x / -direction.z + kappa * place.x,
                 up = direction.y / -direction.z + kappa * place.y;
    return fabs(right) <= pixels[0] * p->pixelSize[0] / (2 * p->imageDistance) &&
           fabs(up) <= pixels[1] * p->pixelSize[1] / (2 * p->imageDistance);
}

/* Does it emit along `direction` from a place where it has this normal, whatever its image says? */
static bool in_cone(const mcv_scene *scene, const mcv_emitter *emitter, ref_vec direction,
                    const ref_surface *surface) {
    const double *m = scene->instances[emitter->instance].to_world.m;
    const ref_vec normal = surface->normal;
    if (emitter->type == MCV_EMITTER_PARALLEL)
        return ref_angle(direction, normal) <= emitter->as.parallel.halfAngle;
    if (emitter->type == MCV_EMITTER_TELECENTRIC_PROJECTOR)
        return ref_angle(direction, normal) <= emitter->as.telecentric_projector.halfAngle;
    const double range = emitter->as.light_field_emitter.angularRange;
    const ref_vec right = {m[0], m[3], m[6]}, up = {m[1], m[4], m[7]}, back = {m[2], m[5], m[8]};
    if (emitter->type == MCV_EMITTER_PROJECTOR) {
        const ref_vec place = ref_sub(surface->position, (ref_vec){m[9], m[10], m[11]});
        return in_picture(
            scene, emitter, (ref_vec){ref_dot(place, right), ref_dot(place, up), 0},
            (ref_vec){ref_dot(direction, right), ref_dot(direction, up), ref_dot(direction, back)});
    }
    return fabs(ref_dot(direction, right)) <= range && fabs(ref_dot(direction, up)) <= range;
}

/* Follows one camera ray to the first surface. */
static void look(const ref_geometry *geometry, ref_sensor_ray sensor_ray, tally *tallies) {
    const mcv_scene *scene = geometry->scene;
    ref_hit hit;
    if (!(sensor_ray.weight > 0) ||
        !ref_closest_hit(geometry, sensor_ray.origin, sensor_ray.direction, MCV_NONE, &hit))
        return;
    const uint32_t number = scene->instances[hit.triangle->instance].emitter;
    if (number == MCV_NONE || !has_cone(scene->emitters + number)) return;
    const ref_surface surface = ref_surface_at(geometry, &hit);
    const ref_vec back = ref_scale(-1, sensor_ray.direction);
    if (!(ref_dot(back, surface.geometric) > 0)) return; /* behind it there is nothing to face */
    const bool lit = in_cone(scene, scene->emitters + number, back, &surface);
    tallies[number].seen_now = true;
    tallies[number].lit_now = tallies[number].lit_now || lit;
}

/* Counts the rays since the last call as one sample of the pupil. */
static void count(tally *tallies, uint32_t emitters) {
    for (uint32_t i = 0; i < emitters; ++i) {
        tallies[i].seen += tallies[i].seen_now;
        tallies[i].lit += tallies[i].lit_now;
        tallies[i].seen_now = tallies[i].lit_now = false;
    }
}

/* The k-th of `count` evenly spread over `size`. */
static uint32_t spread(uint32_t k, uint32_t count, uint32_t size) {
    return (uint32_t)(((uint64_t)2 * k + 1) * size / (2 * count));
}

static uint32_t least(uint32_t a, uint32_t b) { return a < b ? a : b; }

static void look_through_pupil(const ref_geometry *geometry, const mcv_sensor *sensor,
                               tally *tallies) {
    uint32_t width, height;
    mcv_sensor_film_size(sensor, &width, &height);
    const uint32_t columns = least(width, PIXELS), rows = least(height, PIXELS);
    ref_random random = {1};
    for (uint32_t i = 0; i < columns * rows * PLACES * PLACES; ++i) {
        const uint32_t place = i % (PLACES * PLACES), pixel = i / (PLACES * PLACES);
        const uint32_t across = place % PLACES, down = place / PLACES;
        const double u = (across + ref_random_unit(&random)) / PLACES;
        const double v = (down + ref_random_unit(&random)) / PLACES;
        look(geometry,
             ref_sensor_ray_sample(sensor, spread(pixel % columns, columns, width),
                                   spread(pixel / columns, rows, height), 0.5, 0.5, u, v),
             tallies);
        count(tallies, geometry->scene->emitter_count);
    }
}

static void look_from_macro_pixels(const ref_geometry *geometry, const mcv_sensor *sensor,
                                   tally *tallies) {
    const mcv_readout readout = mcv_sensor_readout(sensor);
    const uint32_t j = readout.angular[0], k = readout.angular[1],
                   places = PLACES_IN_PIXEL * PLACES_IN_PIXEL;
    uint32_t across = PIXELS;
    while (across > 1 && (uint64_t)across * across * j * k * places > MOST_RAYS) --across;
    const uint32_t columns = least(readout.size[0], across), rows = least(readout.size[1], across);
    ref_random random = {1};
    for (uint32_t i = 0; i < columns * rows * j * k; ++i) {
        const uint32_t macro = i / (j * k);
        const uint32_t column = spread(macro % columns, columns, readout.size[0]) * j + i % j;
        const uint32_t row = spread(macro / columns, rows, readout.size[1]) * k + i / j % k;
        for (uint32_t place = 0; place < places; ++place) {
            const uint32_t right = place % PLACES_IN_PIXEL, down = place / PLACES_IN_PIXEL;
            const double x = (right + ref_random_unit(&random)) / PLACES_IN_PIXEL;
            const double y = (down + ref_random_unit(&random)) / PLACES_IN_PIXEL;
            look(geometry, ref_sensor_ray_sample(sensor, column, row, x, y, 0.5, 0.5), tallies);
        }
        count(tallies, geometry->scene->emitter_count);
    }
}

mcv_result ref_sensor_fillings(const mcv_scene *scene, uint32_t sensor, ref_filling **fillings,
                               uint32_t *filling_count, mcv_error *error) {
    bool any = false;
    *fillings = NULL;
    *filling_count = 0;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) any = any || has_cone(scene->emitters + i);
    if (!any) return MCV_OK;
    ref_geometry geometry;
    MCV_TRY(ref_geometry_new(scene, &geometry, error));
    tally *tallies = calloc(scene->emitter_count, sizeof *tallies);
    *fillings = calloc(scene->emitter_count, sizeof **fillings);
    if (tallies && *fillings) {
        const mcv_sensor *from = scene->sensors + sensor;
        if (from->type == MCV_SENSOR_LIGHT_FIELD)
            look_from_macro_pixels(&geometry, from, tallies);
        else
            look_through_pupil(&geometry, from, tallies);
        for (uint32_t i = 0; i < scene->emitter_count; ++i)
            if (tallies[i].seen > 0)
                (*fillings)[(*filling_count)++] =
                    (ref_filling){i, (double)tallies[i].lit / (double)tallies[i].seen};
    }
    const bool failed = !tallies || !*fillings;
    ref_geometry_free(&geometry);
    free(tallies);
    return failed ? mcv_fail(error, MCV_FAILED, "%s: no memory for its emitters", scene->path)
                  : MCV_OK;
}
