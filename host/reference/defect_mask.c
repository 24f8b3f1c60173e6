/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/defect_mask.h"

#include "core/parallel.h"
#include "defects/defects.h"
#include "reference/geometry.h"
#include "reference/sensor_ray.h"
#include "scene/materials.h"
#include "scene/sensors.h"

enum { SIDE = 8 }; /* rays along a pixel's side */

typedef struct looking {
    const mcv_scene *scene;
    const mcv_sensor *sensor;
    ref_geometry geometry;
    mcv_image *mask;
} looking;

static bool is_changed(const mcv_scene *scene, uint32_t instance, ref_vec position) {
    const double world[3] = {position.x, position.y, position.z};
    for (uint32_t i = 0; i < scene->defect_count; ++i)
        if (mcv_defect_changed(scene->defects + i, instance, world)) return true;
    return false;
}

/* The first surface that is no thin sheet. */
static bool meets_defect(const looking *l, const ref_sensor_ray *ray) {
    ref_skip skip = {0};
    ref_hit hit;
    while (ref_next_hit(&l->geometry, ray->origin, ray->direction, &skip, &hit)) {
        const uint32_t instance = hit.triangle->instance;
        const mcv_material *material = l->scene->materials + l->scene->instances[instance].material;
        if (!mcv_material_is_plate(material->type) || skip.count == REF_SKIPS)
            return is_changed(l->scene, instance,
                              ref_add(ray->origin, ref_scale(hit.distance, ray->direction)));
        skip.numbers[skip.count++] = hit.triangle->number;
    }
    return false;
}

static void look_through_row(void *user, size_t row) {
    const looking *l = user;
    for (uint32_t column = 0; column < l->mask->width; ++column) {
        uint32_t found = 0;
        for (int j = 0; j < SIDE; ++j)
            for (int i = 0; i < SIDE; ++i) {
                const ref_sensor_ray ray = ref_sensor_ray_sample(
                    l->sensor, column, (uint32_t)row, (i + 0.5) / SIDE, (j + 0.5) / SIDE, 0, 0);
                found += ray.weight > 0 && meets_defect(l, &ray);
            }
        l->mask->pixels[row * l->mask->width + column] = (float)found / (SIDE * SIDE);
    }
}

static mcv_result check(const mcv_scene *scene, mcv_error *error) {
    if (scene->defect_count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no defect", scene->path);
    for (uint32_t i = 0; i < scene->defect_count; ++i)
        if (mcv_defect_is_inside(scene->defects[i].type))
            return mcv_fail(error, MCV_BAD_INPUT,
                            "%s: defects/%s lies inside of a body, whose surface bends the light: "
                            "which pixels see it is known for defects on surfaces only",
                            scene->path, scene->defects[i].name);
    return MCV_OK;
}

mcv_result ref_defect_mask(const mcv_scene *scene, uint32_t sensor, mcv_image *mask,
                           mcv_error *error) {
    looking l = {.scene = scene, .sensor = scene->sensors + sensor, .mask = mask};
    uint32_t width, height;
    MCV_TRY(check(scene, error));
    mcv_sensor_film_size(l.sensor, &width, &height);
    MCV_TRY(mcv_image_new(mask, width, height, 1, error));
    const mcv_result result = ref_geometry_new(scene, &l.geometry, error);
    if (result == MCV_OK) {
        mcv_in_parallel(height, look_through_row, &l);
        ref_geometry_free(&l.geometry);
    } else {
        mcv_image_free(mask);
    }
    return result;
}
