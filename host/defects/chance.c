/* SPDX-License-Identifier: Apache-2.0 */
/* Defects in places by chance: the same seed gives the same places. */
#include "defects/defects.h"

#include "scene/geometry.h"
#include "scene/mesh.h"

#include <float.h>
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

/* The sums of areas of the instances' triangles, made where they are needed first. */
static bool know_areas(mcv_known_meshes *known, const mcv_scene *scene,
                       const uint32_t instances[2]) {
    if (!known->areas) known->areas = calloc((size_t)scene->instance_count + 1, sizeof(double *));
    if (!known->areas) return false;
    known->area_count = scene->instance_count;
    for (uint32_t i = instances[0]; i < instances[1]; ++i) {
        const uint32_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
        if (known->areas[i]) continue;
        double sum = 0, *sums = known->areas[i] = malloc((count + (size_t)1) * sizeof *sums);
        if (!sums) return false;
        for (uint32_t t = 0; t < count; ++t) sums[t] = sum += mcv_scene_triangle_area(scene, i, t);
    }
    return true;
}

static double area_of_instance(const mcv_known_meshes *known, const mcv_scene *scene, uint32_t i) {
    const uint32_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
    return count ? known->areas[i][count - 1] : 0;
}

static double area_of(const mcv_known_meshes *known, const mcv_scene *scene,
                      const uint32_t instances[2]) {
    double area = 0;
    for (uint32_t i = instances[0]; i < instances[1]; ++i)
        area += area_of_instance(known, scene, i);
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
    mcv_known_meshes own = {0}, *known = chance->known ? chance->known : &own;
    const bool memory = know_areas(known, scene, node->instances);
    const double mean = memory ? chance->density * area_of(known, scene, node->instances) : 0;
    mcv_known_meshes_free(&own);
    if (!memory) return mcv_fail_memory(place, error);
    /* Poisson's number: how many gaps of the mean 1 fit. */
    for (double sum = -log1p(-uniform(chance)); sum < mean; sum -= log1p(-uniform(chance)))
        if (++*count > MOST_DEFECTS)
            return mcv_fail_at(&here, error,
                               "%g/m² on %g m² are %.3g defects on average: at most %d are "
                               "supported",
                               chance->density, mean / chance->density, mean, MOST_DEFECTS);
    return MCV_OK;
}

/* The number of the triangle in which this much of the node's area is reached, one by one. */
static uint32_t count_to(const mcv_scene *scene, const mcv_placement *node, double area) {
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

/* The first triangle up to which the sum exceeds `area`, in order. */
static uint32_t first_beyond(const double *sums, uint32_t count, double area) {
    uint32_t low = 0, high = count - 1;
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (sums[middle] > area)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* The same by the sums. Where rounding of a sum may decide, the areas are counted one by one. */
static uint32_t triangle_at(const mcv_known_meshes *known, const mcv_scene *scene,
                            const mcv_placement *node, double area) {
    uint32_t number = 0, triangles = 0;
    double before = 0;
    for (uint32_t i = node->instances[0]; i < node->instances[1]; ++i)
        triangles += scene->meshes[scene->instances[i].mesh].triangle_count;
    const double slack = 2 * DBL_EPSILON * triangles * area_of(known, scene, node->instances);
    for (uint32_t i = node->instances[0]; i < node->instances[1]; ++i) {
        const uint32_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
        const double own = area_of_instance(known, scene, i);
        if (area < before + own && own > 0) {
            const double *sums = known->areas[i];
            const uint32_t t = first_beyond(sums, count, area - before);
            const double from = before + (t ? sums[t - 1] : 0), to = before + sums[t];
            if (area - slack > from && area + slack < to) return number + t;
            break;
        }
        before += own;
        number += count;
    }
    return count_to(scene, node, area);
}

/* An evenly chosen place of the node's triangles. */
static void choose_on_surface(const mcv_scene *scene, const mcv_placement *node, mcv_chance *chance,
                              mcv_defect_site *site) {
    const mcv_known_meshes *known = site->known;
    site->by_point = false;
    site->triangle =
        triangle_at(known, scene, node, uniform(chance) * area_of(known, scene, node->instances));
    const double r = sqrt(uniform(chance)), s = uniform(chance);
    site->barycentric[0] = 1 - r;
    site->barycentric[1] = r * (1 - s);
    site->barycentric[2] = r * s;
}

/* The box around the node's instances. */
static void box_of(const mcv_scene *scene, const mcv_placement *node, double bounds[2][3]) {
    double *lower = bounds[0], *upper = bounds[1];
    for (int k = 0; k < 3; ++k) lower[k] = INFINITY, upper[k] = -INFINITY;
    for (uint32_t i = node->instances[0]; i < node->instances[1]; ++i) {
        double box[2][3];
        mcv_scene_box(scene, i, box[0], box[1]);
        for (int k = 0; k < 3; ++k) {
            lower[k] = fmin(lower[k], box[0][k]);
            upper[k] = fmax(upper[k], box[1][k]);
        }
    }
}

/* A point of the box, along the node's axes. */
static void choose_in_box(const double bounds[2][3], const mcv_placement *node, mcv_chance *chance,
                          mcv_defect_site *site) {
    const double *lower = bounds[0], *upper = bounds[1];
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

/* One of the tries. */
static mcv_result try_place(const mcv_scene *scene, const mcv_defect_site *site,
                            const double bounds[2][3], mcv_chance *chance, mcv_defect *defect,
                            const mcv_json_path *place, mcv_error *reason) {
    mcv_defect_site one = *site;
    const bool directed =
        site->direction[0] != 0 || site->direction[1] != 0 || site->direction[2] != 0;
    const bool inside = mcv_defect_is_inside(defect->type);
    if (inside)
        choose_in_box(bounds, site->found, chance, &one);
    else
        choose_on_surface(scene, site->found, chance, &one);
    if (!directed) choose_direction(chance, one.direction);
    if (inside) return mcv_defect_locate_inside(scene, &one, defect, place, reason);
    MCV_TRY(mcv_defect_locate(scene, &one, defect, place, reason));
    return mcv_defect_fits(scene, site->known, defect, place, reason);
}

static mcv_result locate(const mcv_scene *scene, const mcv_defect_site *site, mcv_chance *chance,
                         mcv_defect *defect, const mcv_json_path *place, mcv_error *error) {
    const bool inside = mcv_defect_is_inside(defect->type);
    const uint32_t *instances = site->found->instances;
    double bounds[2][3] = {{0}};
    if (!inside && !know_areas(site->known, scene, instances)) return mcv_fail_memory(place, error);
    if (!inside && !(area_of(site->known, scene, instances) > 0))
        return mcv_fail_at(place, error, "node \"%s\" must have a mesh", site->node);
    if (inside) box_of(scene, site->found, bounds);
    mcv_error reason = {""};
    for (int attempt = 0; attempt < TRIES; ++attempt) {
        const mcv_result result =
            try_place(scene, site, (const double(*)[3])bounds, chance, defect, place, &reason);
        if (result == MCV_OK) return MCV_OK;
        if (result != MCV_BAD_INPUT) return mcv_fail(error, result, "%s", reason.text);
    }
    return mcv_fail(error, MCV_BAD_INPUT, "%s (in %d places by chance)", reason.text, TRIES);
}

mcv_result mcv_chance_locate(const mcv_scene *scene, const mcv_defect_site *site,
                             mcv_chance *chance, mcv_defect *defect, const mcv_json_path *place,
                             mcv_error *error) {
    mcv_known_meshes own = {0};
    mcv_defect_site known = *site;
    known.known = chance->known ? chance->known : &own;
    mcv_result result = mcv_defect_node(scene, site->node, &known.found, place, error);
    if (result == MCV_OK) result = locate(scene, &known, chance, defect, place, error);
    mcv_known_meshes_free(&own);
    return result;
}
