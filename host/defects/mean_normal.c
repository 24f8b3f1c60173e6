/* SPDX-License-Identifier: Apache-2.0 */
/* The mean normal of a surface about a point: on an edge that between its sides. */
#include "defects/defects.h"

#include "scene/geometry.h"

#include <math.h>

typedef struct about {
    const double *point;
    double radius;
    double sum[3]; /* of areas times normals */
} about;

/* Shares of the radius: pieces of triangles below count by their middles. */
static const double finest = 1.0 / 16;

static double distance(const double a[3], const double b[3]) {
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

/* A piece of a triangle, halved across its longest edge until it is small or lies outside. */
static void gather(about *to, const double a[3], const double b[3], const double c[3]) {
    const double *const p[3] = {a, b, c};
    double middle[3], longest = 0;
    int edge = 0;
    for (int i = 0; i < 3; ++i) middle[i] = (a[i] + b[i] + c[i]) / 3;
    for (int k = 0; k < 3; ++k) {
        const double length = distance(p[k], p[(k + 1) % 3]);
        if (length > longest) longest = length, edge = k;
    }
    const double away = distance(middle, to->point);
    if (away > to->radius + longest) return;
    if (longest > finest * to->radius) {
        const double *u = p[edge], *v = p[(edge + 1) % 3], *w = p[(edge + 2) % 3];
        double half[3];
        for (int i = 0; i < 3; ++i) half[i] = 0.5 * (u[i] + v[i]);
        gather(to, u, half, w);
        gather(to, half, v, w);
        return;
    }
    if (away > to->radius) return;
    double e[2][3], n[3];
    for (int i = 0; i < 3; ++i) e[0][i] = b[i] - a[i], e[1][i] = c[i] - a[i];
    mcv_cross3(e[0], e[1], n);
    for (int i = 0; i < 3; ++i) to->sum[i] += n[i];
}

bool mcv_defect_mean_normal(const mcv_scene *scene, const uint32_t instances[2],
                            const double point[3], double radius, double normal[3]) {
    about to = {.point = point, .radius = radius};
    for (uint32_t i = instances[0]; i < instances[1]; ++i)
        for (uint32_t t = 0; t < scene->meshes[scene->instances[i].mesh].triangle_count; ++t) {
            double c[3][3];
            mcv_scene_corners(scene, i, t, c);
            gather(&to, c[0], c[1], c[2]);
        }
    return mcv_normalize3(to.sum, normal);
}
