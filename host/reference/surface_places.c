/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/surface_places.h"

#include "core/parallel.h"
#include "reference/sensor_ray.h"
#include "scene/materials.h"
#include "scene/sensors.h"

typedef struct looking {
    const ref_geometry *geometry;
    const mcv_sensor *sensor;
    uint32_t q;
    mcv_image *places;
} looking;

/* The first surface that is no thin sheet. */
static bool meet(const ref_geometry *geometry, const ref_sensor_ray *ray, ref_vec *position,
                 uint32_t *instance) {
    const mcv_scene *scene = geometry->scene;
    ref_skip skip = {0};
    ref_hit hit;
    while (ref_next_hit(geometry, ray->origin, ray->direction, &skip, &hit)) {
        *instance = hit.triangle->instance;
        *position = ref_add(ray->origin, ref_scale(hit.distance, ray->direction));
        const mcv_material *material = scene->materials + scene->instances[*instance].material;
        if (!mcv_material_is_plate(material->type) || skip.count == REF_SKIPS) return true;
        skip.numbers[skip.count++] = hit.triangle->number;
    }
    return false;
}

static void look_through_row(void *user, size_t row) {
    const looking *l = user;
    const size_t plane = (size_t)l->places->width * l->places->height;
    for (uint32_t column = 0; column < l->places->width; ++column) {
        const ref_sensor_ray ray =
            ref_sensor_ray_sample(l->sensor, l->q * column, l->q * (uint32_t)row, 0, 0, 0, 0);
        float *pixel = l->places->pixels + row * l->places->width + column;
        ref_vec position;
        uint32_t instance;
        mcv_transform node;
        for (size_t c = 0; c < 4; ++c) pixel[c * plane] = 0;
        if (!meet(l->geometry, &ray, &position, &instance) ||
            !mcv_transform_rigid(&l->geometry->scene->instances[instance].to_world, &node))
            continue;
        const double from[3] = {position.x - node.m[9], position.y - node.m[10],
                                position.z - node.m[11]};
        for (size_t c = 0; c < 3; ++c)
            pixel[c * plane] =
                (float)(node.m[c] * from[0] + node.m[3 + c] * from[1] + node.m[6 + c] * from[2]);
        pixel[3 * plane] = (float)(instance + 1);
    }
}

mcv_result ref_surface_places(const ref_geometry *geometry, const mcv_sensor *sensor, uint32_t q,
                              mcv_image *places, mcv_error *error) {
    uint32_t width, height;
    mcv_sensor_film_size(sensor, &width, &height);
    MCV_TRY(mcv_image_new(places, width / q + 1, height / q + 1, 4, error));
    looking l = {.geometry = geometry, .sensor = sensor, .q = q, .places = places};
    mcv_in_parallel(places->height, look_through_row, &l);
    return MCV_OK;
}
