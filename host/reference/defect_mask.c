/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/defect_mask.h"

#include "core/parallel.h"
#include "defects/defects.h"
#include "reference/interface.h"
#include "reference/path.h"
#include "scene/materials.h"
#include "scene/sensors.h"

#include <stdlib.h>

enum {
    SIDE = 8,           /* rays along a pixel's side */
    MOST_SURFACES = 64, /* on the way of one: it may be caught by total reflection */
};

typedef struct looking {
    const mcv_scene *scene;
    const mcv_sensor *sensor;
    ref_geometry geometry;
    ref_media media; /* around the sensor */
    mcv_image *mask;
} looking;

static bool is_changed(const mcv_scene *scene, uint32_t instance, ref_vec position) {
    const double world[3] = {position.x, position.y, position.z};
    for (uint32_t i = 0; i < scene->defect_count; ++i)
        if (mcv_defect_changed(scene->defects + i, instance, world)) return true;
    return false;
}

/* Where a ray goes on behind a smooth interface: refracted, or else by total reflection. */
static ref_vec pass(const looking *l, const ref_surface *surface, const ref_hits *hits,
                    ref_vec direction, ref_media *media) {
    const ref_interaction interaction = ref_make_interaction(surface, direction);
    ref_media far;
    ref_media_cross_all(media, &far, hits->count, hits->instances, hits->fronts);
    const double from = ref_media_ior(ref_media_filling(media, l->scene), MCV_ALBEDO_CHANNEL),
                 to = ref_media_ior(ref_media_filling(&far, l->scene), MCV_ALBEDO_CHANNEL);
    if (ref_reflectance(&interaction, from, to) == 1) return ref_reflect(&interaction);
    *media = far;
    return ref_refract(&interaction, from, to);
}

/* On the way to the first surface that is neither a thin sheet nor that of glass. */
static bool meets_defect(const looking *l, const ref_sensor_ray *ray) {
    ref_vec origin = ray->origin, direction = ray->direction;
    ref_media media = l->media;
    ref_skip skip = {0};
    ref_hit hit;
    for (int met = 0;
         met < MOST_SURFACES && ref_next_hit(&l->geometry, origin, direction, &skip, &hit); ++met) {
        const ref_surface surface = ref_surface_at(&l->geometry, &hit);
        const mcv_material *material =
            l->scene->materials + l->scene->instances[surface.instance].material;
        if (is_changed(l->scene, surface.instance, surface.position)) return true;
        if (mcv_material_is_plate(material->type)) {
            if (skip.count == REF_SKIPS) return false;
            skip.numbers[skip.count++] = surface.number;
            continue;
        }
        if (!mcv_material_has_medium(material->type)) return false;
        const ref_hits hits = ref_hits_at(&l->geometry, origin, direction, &skip, &hit);
        direction = pass(l, &surface, &hits, direction, &media);
        origin = surface.position;
        skip = hits.numbers;
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

static mcv_result find_media(looking *l, mcv_error *error) {
    const double *lens = l->sensor->to_world.m + 9;
    int *winding = calloc(l->scene->instance_count + (size_t)1, sizeof *winding);
    const mcv_result result =
        winding ? ref_media_at(&l->geometry, ref_from(lens), winding, &l->media, error)
                : mcv_fail(error, MCV_FAILED, "no memory for the media around the sensor");
    free(winding);
    return result;
}

static mcv_result check(const mcv_scene *scene, mcv_error *error) {
    if (scene->defect_count == 0)
        return mcv_fail(error, MCV_BAD_INPUT, "%s: the scene has no defect", scene->path);
    return MCV_OK;
}

mcv_result ref_defect_mask(const mcv_scene *scene, uint32_t sensor, mcv_image *mask,
                           mcv_error *error) {
    looking l = {.scene = scene, .sensor = scene->sensors + sensor, .mask = mask};
    uint32_t width, height;
    MCV_TRY(check(scene, error));
    mcv_sensor_film_size(l.sensor, &width, &height);
    MCV_TRY(mcv_image_new(mask, width, height, 1, error));
    mcv_result result = ref_geometry_new(scene, &l.geometry, error);
    if (result == MCV_OK) result = find_media(&l, error);
    if (result == MCV_OK)
        mcv_in_parallel(height, look_through_row, &l);
    else
        mcv_image_free(mask);
    ref_geometry_free(&l.geometry);
    return result;
}
