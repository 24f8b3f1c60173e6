/* SPDX-License-Identifier: Apache-2.0 */
/* The place of a defect: the nearest point of its node's meshes, and the frame there. */
#include "defects/defects.h"

#include "core/json.h"
#include "scene/geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* --- the node --- */

/* How many nodes of the scene's file, or of its assets, have this name; *found: the last. */
static uint32_t count_named(const mcv_scene *scene, const char *name, bool of_asset,
                            const mcv_placement **found) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->frame_count; ++i) {
        if (scene->frames[i].of_asset != of_asset || strcmp(scene->frames[i].name, name) != 0)
            continue;
        *found = scene->frames + i;
        ++count;
    }
    return count;
}

mcv_result mcv_defect_node(const mcv_scene *scene, const char *name, const mcv_placement **node,
                           const mcv_json_path *place, mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, "node");
    const uint32_t rigs = count_named(scene, name, false, node),
                   found = rigs ? rigs : count_named(scene, name, true, node);
    if (found == 1 && *node) return MCV_OK;
    if (found > 1)
        return mcv_fail_at(&here, error, "%u nodes are called \"%s\": give them names of their own",
                           found, name);
    const char **names = calloc((size_t)scene->frame_count + 1, sizeof *names);
    for (uint32_t i = 0; names && i < scene->frame_count; ++i) names[i] = scene->frames[i].name;
    const char *nearest = names ? mcv_nearest_word(name, names, scene->frame_count) : NULL;
    free((void *)names);
    return mcv_fail_at(&here, error, "there is no node \"%s\"%s%s%s", name,
                       nearest ? "; did you mean \"" : "", nearest ? nearest : "",
                       nearest ? "\"?" : "");
}

/* --- the point --- */

/* The barycentric coordinates of the triangle's point that is nearest to p. By regions (Ericson,
 * Real-Time Collision Detection, 5.1.5). */
static void nearest_in_triangle(const double c[3][3], const double p[3], double weights[3]) {
    double ab[3], ac[3], from[3][3];
    for (int i = 0; i < 3; ++i) {
        ab[i] = c[1][i] - c[0][i];
        ac[i] = c[2][i] - c[0][i];
        for (int k = 0; k < 3; ++k) from[k][i] = p[i] - c[k][i];
    }
    double d[3][2];
    for (int k = 0; k < 3; ++k) d[k][0] = dot(ab, from[k]), d[k][1] = dot(ac, from[k]);
    const double va = d[1][0] * d[2][1] - d[2][0] * d[1][1],
                 vb = d[2][0] * d[0][1] - d[0][0] * d[2][1],
                 vc = d[0][0] * d[1][1] - d[1][0] * d[0][1];
    const double to_b = d[1][1] - d[1][0], to_c = d[2][0] - d[2][1];
    double v = 0, w = 0;
    if (d[0][0] <= 0 && d[0][1] <= 0) {
        v = w = 0;
    } else if (d[1][0] >= 0 && d[1][1] <= d[1][0]) {
        v = 1;
    } else if (vc <= 0 && d[0][0] >= 0 && d[1][0] <= 0) {
        v = d[0][0] / (d[0][0] - d[1][0]);
    } else if (d[2][1] >= 0 && d[2][0] <= d[2][1]) {
        w = 1;
    } else if (vb <= 0 && d[0][1] >= 0 && d[2][1] <= 0) {
        w = d[0][1] / (d[0][1] - d[2][1]);
    } else if (va <= 0 && to_b >= 0 && to_c >= 0) {
        w = to_b / (to_b + to_c);
        v = 1 - w;
    } else if (va + vb + vc > 0) {
        v = vb / (va + vb + vc);
        w = vc / (va + vb + vc);
    }
    weights[0] = 1 - v - w;
    weights[1] = v;
    weights[2] = w;
}

/* A point on a triangle of an instance. */
typedef struct spot {
    uint32_t instance, triangle;
    double weights[3], point[3], distance;
} spot;

static void combine(const double c[3][3], const double weights[3], double point[3]) {
    for (int i = 0; i < 3; ++i)
        point[i] = weights[0] * c[0][i] + weights[1] * c[1][i] + weights[2] * c[2][i];
}

/* Is every point of the triangle farther from p than `distance`? True is right: no point is farther
 * from the first corner than a side's coordinates together. */
static bool is_farther(const double c[3][3], const double p[3], double distance) {
    double from[3], reach = 0;
    for (int k = 1; k < 3; ++k)
        for (int i = 0; i < 3; ++i) reach += fabs(c[k][i] - c[0][i]);
    for (int i = 0; i < 3; ++i) from[i] = c[0][i] - p[i];
    return dot(from, from) > 1.000001 * (distance + reach) * (distance + reach);
}

/* The nearest point of the instances; distance infinite without triangles. *size: the largest
 * coordinate of a corner, for the rounding. */
static spot nearest_spot(const mcv_scene *scene, const uint32_t instances[2], const double p[3],
                         double *size) {
    spot best = {.distance = INFINITY};
    *size = 0;
    for (uint32_t i = instances[0]; i < instances[1]; ++i) {
        const uint32_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
        for (uint32_t t = 0; t < count; ++t) {
            double c[3][3];
            spot one = {.instance = i, .triangle = t};
            mcv_scene_corners(scene, i, t, c);
            for (int k = 0; k < 9; ++k) {
                const double away = fabs(c[k / 3][k % 3]);
                if (away > *size) *size = away;
            }
            if (is_farther((const double(*)[3])c, p, best.distance)) continue;
            nearest_in_triangle((const double(*)[3])c, p, one.weights);
            combine((const double(*)[3])c, one.weights, one.point);
            double off[3];
            for (int k = 0; k < 3; ++k) off[k] = one.point[k] - p[k];
            if (dot(off, off) < 1.000001 * best.distance * best.distance) {
                one.distance = hypot(hypot(off[0], off[1]), off[2]);
                if (one.distance < best.distance) best = one;
            }
        }
    }
    return best;
}

double mcv_defect_distance(const mcv_scene *scene, const uint32_t instances[2],
                           const double point[3], uint32_t *instance) {
    double size;
    const spot nearest = nearest_spot(scene, instances, point, &size);
    *instance = nearest.instance;
    return nearest.distance;
}

/* The triangle by its number among those of the instances. */
static bool numbered_spot(const mcv_scene *scene, const uint32_t instances[2],
                          const mcv_defect_site *site, spot *found) {
    uint32_t left = site->triangle;
    for (uint32_t i = instances[0]; i < instances[1]; ++i) {
        const uint32_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
        if (left >= count) {
            left -= count;
            continue;
        }
        double c[3][3];
        *found = (spot){.instance = i, .triangle = left};
        memcpy(found->weights, site->barycentric, sizeof found->weights);
        if (mcv_transform_determinant(&scene->instances[i].to_world) < 0) {
            found->weights[1] = site->barycentric[2]; /* the corners of the scene run back */
            found->weights[2] = site->barycentric[1];
        }
        mcv_scene_corners(scene, i, left, c);
        combine((const double(*)[3])c, found->weights, found->point);
        return true;
    }
    return false;
}

static uint32_t count_triangles(const mcv_scene *scene, const uint32_t instances[2]) {
    uint32_t count = 0;
    for (uint32_t i = instances[0]; i < instances[1]; ++i)
        count += scene->meshes[scene->instances[i].mesh].triangle_count;
    return count;
}

static mcv_result find_by_point(const mcv_scene *scene, const mcv_placement *node,
                                const mcv_defect_site *site, double tolerance, spot *found,
                                const mcv_json_path *place, mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, "at");
    double world[3], size, near[3] = {0, 0, 0};
    mcv_transform_point(&node->to_world, site->at, world);
    *found = nearest_spot(scene, node->instances, world, &size);
    /* The second term: positions are float32. */
    if (found->distance <= fmax(tolerance, 4 * (double)FLT_EPSILON * size)) return MCV_OK;
    const double *m = node->to_world.m;
    for (int i = 0; i < 3; ++i) /* the node's axes are unit vectors */
        for (int k = 0; k < 3; ++k) near[i] += m[3 * k + i] * (found->point[k] - m[9 + k]);
    for (int i = 0; i < 3; ++i)
        if (fabs(near[i]) < 1e-12 * size) near[i] = 0; /* rounding */
    return mcv_fail_at(&here, error,
                       "lies %.3g m off the surface of node \"%s\", more than half of the defect's "
                       "size: the nearest point is [%.9g, %.9g, %.9g]",
                       found->distance, node->name, near[0], near[1], near[2]);
}

/* --- the frame --- */

/* The direction, or else the node's x axis, else its y axis, made perpendicular to the normal. */
static bool first_axis(const mcv_placement *node, const double direction[3], double axes[3][3]) {
    const double *normal = axes[2];
    const bool given = direction[0] != 0 || direction[1] != 0 || direction[2] != 0;
    for (int attempt = 0; attempt < (given ? 1 : 2); ++attempt) {
        const double x[3] = {attempt == 0, attempt == 1, 0};
        double world[3], unit[3];
        mcv_transform_vector(&node->to_world, given ? direction : x, world);
        if (!mcv_normalize3(world, unit)) return false;
        const double along = dot(unit, normal);
        if (fabs(along) > 0.99) continue;
        for (int i = 0; i < 3; ++i) unit[i] -= along * normal[i];
        return mcv_normalize3(unit, axes[0]);
    }
    return false;
}

/* What a chip or a missing part turns up: the direction, else the mean normal, which a burr has,
 * too. Others have the normal of the surface. */
static bool find_normal(const mcv_scene *scene, const mcv_placement *node, const spot *at,
                        const mcv_defect_site *site, const mcv_defect *defect, double normal[3]) {
    const double *direction = site->direction;
    const bool cut = mcv_defect_kind_of(defect->type) == MCV_KIND_CUT;
    double normals[3][3], sum[3];
    if (cut && (direction[0] != 0 || direction[1] != 0 || direction[2] != 0)) {
        mcv_transform_vector(&node->to_world, direction, sum);
        return mcv_normalize3(sum, normal);
    }
    if ((cut || defect->type == MCV_DEFECT_BURR) &&
        mcv_defect_mean_normal(scene, site->known, node->instances, at->point, defect->size / 2,
                               normal))
        return true;
    mcv_scene_vertex_normals(scene, at->instance, at->triangle, normals);
    combine((const double(*)[3])normals, at->weights, sum);
    if (!mcv_normalize3(sum, normal)) memcpy(normal, normals[0], sizeof normals[0]);
    return true;
}

static bool make_axes(const mcv_scene *scene, const mcv_placement *node, const spot *at,
                      const mcv_defect_site *site, mcv_defect *defect) {
    static const double none[3] = {0, 0, 0};
    const bool cut = mcv_defect_kind_of(defect->type) == MCV_KIND_CUT;
    double(*axes)[3] = defect->axes;
    if (!find_normal(scene, node, at, site, defect, axes[2]) ||
        !first_axis(node, cut ? none : site->direction, axes))
        return false;
    mcv_cross3(axes[2], axes[0], axes[1]);
    return true;
}

mcv_result mcv_defect_locate(const mcv_scene *scene, const mcv_defect_site *site,
                             mcv_defect *defect, const mcv_json_path *place, mcv_error *error) {
    const mcv_placement *node = site->found;
    spot at;
    const mcv_json_path here = mcv_json_path_key(place, "node"),
                        number = mcv_json_path_key(place, "triangle"),
                        direction = mcv_json_path_key(place, "direction");
    if (!node) MCV_TRY(mcv_defect_node(scene, site->node, &node, place, error));
    const uint32_t triangles = count_triangles(scene, node->instances);
    if (!triangles)
        return mcv_fail_at(&here, error,
                           "\"%s\" must have a mesh or an exact surface, with the nodes below it",
                           site->node);
    memcpy(defect->instances, node->instances, sizeof defect->instances);
    if (site->by_point)
        MCV_TRY(find_by_point(scene, node, site, defect->size / 2, &at, place, error));
    else if (!numbered_spot(scene, node->instances, site, &at))
        return mcv_fail_at(&number, error, "%u does not exist: triangles go from 0 to %u",
                           site->triangle, triangles - 1);
    memcpy(defect->centre, at.point, sizeof defect->centre);
    if (!make_axes(scene, node, &at, site, defect))
        return mcv_fail_at(&direction, error,
                           "must be a direction along the surface, not along its normal");
    return MCV_OK;
}
