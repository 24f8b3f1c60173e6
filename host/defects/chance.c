/* SPDX-License-Identifier: Apache-2.0 */
/* Defects in places by chance: the same seed gives the same places. */
#include "defects/defects.h"

#include "scene/geometry.h"
#include "scene/mesh.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_DEFECTS = 1000, TRIES = 1000 };

/* splitmix64, as a number in [0, 1). */
static double uniform(mcv_chance *chance) {
    uint64_t x = chance->state += 0x9e3779b97f4a7c15U;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9U;
    x = (x ^ x >> 27) * 0x94d049bb133111ebU;
    return (double)((x ^ x >> 31) >> 11) * 0x1p-53;
}

static double area_of(const mcv_scene *scene, const uint32_t instances[2]) {
    double area = 0;
    for (uint32_t i = instances[0]; i < instances[1]; ++i) area += mcv_scene_area(scene, i);
    return area;
}

mcv_result mcv_chance_count(const mcv_scene *scene, const char *node_name, mcv_chance *chance,
                            uint64_t *count, const mcv_json_path *place, mcv_error *error) {
    const mcv_placement *node = NULL;
    const mcv_json_path here = mcv_json_path_key(place, "density");
    *count = chance->count;
    if (chance->count) return MCV_OK;
    const mcv_result found = mcv_defect_node(scene, node_name, &node, place, error);
    if (found != MCV_OK || !node) return found;
    const double mean = chance->density * area_of(scene, node->instances);
    /* Poisson's number: how many gaps of the mean 1 fit. */
    for (double sum = -log1p(-uniform(chance)); sum < mean; sum -= log1p(-uniform(chance)))
        if (++*count > MOST_DEFECTS)
            return mcv_fail_at(&here, error,
                               "%g/m² on %g m² are %.3g defects on average: at most %d are "
                               "supported",
                               chance->density, mean / chance->density, mean, MOST_DEFECTS);
    return MCV_OK;
}

/* The number of the triangle in which this much of the node's area is reached. */
static uint32_t triangle_at(const mcv_scene *scene, const mcv_placement *node, double area) {
    uint32_t number = 0, last = 0;
    for (uint32_t i = node->instances[0]; i < node->instances[1]; ++i) {
        const uint32_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
        for (uint32_t t = 0; t < count; ++t, ++number) {
            const double own = mcv_scene_triangle_area(scene, i, t);
            if (own > 0) last = number;
            area -= own;
            if (area < 0) return last;
        }
    }
    return last;
}

/* An evenly chosen place of the node's triangles. */
static void choose_on_surface(const mcv_scene *scene, const mcv_placement *node, mcv_chance *chance,
                              mcv_defect_site *site) {
    site->by_point = false;
    site->triangle = triangle_at(scene, node, uniform(chance) * area_of(scene, node->instances));
    const double r = sqrt(uniform(chance)), s = uniform(chance);
    site->barycentric[0] = 1 - r;
    site->barycentric[1] = r * (1 - s);
    site->barycentric[2] = r * s;
}

/* A point of the box around the node's instances, along the node's axes. */
static void choose_in_box(const mcv_scene *scene, const mcv_placement *node, mcv_chance *chance,
                          mcv_defect_site *site) {
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = node->instances[0]; i < node->instances[1]; ++i) {
        double box[2][3];
        mcv_scene_box(scene, i, box[0], box[1]);
        for (int k = 0; k < 3; ++k) {
            lower[k] = fmin(lower[k], box[0][k]);
            upper[k] = fmax(upper[k], box[1][k]);
        }
    }
    double from[3];
    const double *m = node->to_world.m; /* unit axes */
    for (int k = 0; k < 3; ++k)
        from[k] = lower[k] + uniform(chance) * (upper[k] - lower[k]) - m[9 + k];
    site->by_point = true;
    for (int k = 0; k < 3; ++k)
        site->at[k] = m[k] * from[0] + m[3 + k] * from[1] + m[6 + k] * from[2];
}

static void choose_direction(mcv_chance *chance, double direction[3]) {
    const double z = 2 * uniform(chance) - 1, angle = 2 * M_PI * uniform(chance),
                 r = sqrt(1 - z * z);
    direction[0] = r * cos(angle);
    direction[1] = r * sin(angle);
    direction[2] = z;
}

mcv_result mcv_chance_locate(const mcv_scene *scene, const mcv_defect_site *site,
                             mcv_chance *chance, mcv_defect *defect, const mcv_json_path *place,
                             mcv_error *error) {
    const mcv_placement *node = NULL;
    const bool inside = mcv_defect_is_inside(defect->type);
    const bool directed =
        site->direction[0] != 0 || site->direction[1] != 0 || site->direction[2] != 0;
    const mcv_result found = mcv_defect_node(scene, site->node, &node, place, error);
    if (found != MCV_OK || !node) return found;
    if (!inside && !(area_of(scene, node->instances) > 0))
        return mcv_fail_at(place, error, "node \"%s\" must have a mesh", site->node);
    mcv_error reason = {""};
    for (int attempt = 0; attempt < TRIES; ++attempt) {
        mcv_defect_site one = *site;
        (inside ? choose_in_box : choose_on_surface)(scene, node, chance, &one);
        if (!directed) choose_direction(chance, one.direction);
        mcv_result result = inside ? mcv_defect_locate_inside(scene, &one, defect, place, &reason)
                                   : mcv_defect_locate(scene, &one, defect, place, &reason);
        if (result == MCV_OK && !inside) result = mcv_defect_fits(scene, defect, place, &reason);
        if (result == MCV_OK) return MCV_OK;
        if (result != MCV_BAD_INPUT) return mcv_fail(error, result, "%s", reason.text);
    }
    return mcv_fail(error, MCV_BAD_INPUT, "%s (in %d places by chance)", reason.text, TRIES);
}
