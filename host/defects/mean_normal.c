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

/* Would gather() leave out each triangle of the box? Its edges are no longer than the diagonal. */
static bool is_box_away(const about *to, const mcv_transform *to_world, const mcv_box *box) {
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const mcv_spread s = mcv_box_spread(box, to_world, to->point, axes);
    double off[3];
    for (int k = 0; k < 3; ++k) off[k] = fmax(0, fabs(s.middle[k]) - s.half[k]);
    return hypot(hypot(off[0], off[1]), off[2]) >
           1.000001 * (to->radius + 2 * hypot(hypot(s.half[0], s.half[1]), s.half[2]));
}

static void gather_instance(about *to, const mcv_scene *scene, mcv_known_meshes *known,
                            uint32_t instance) {
    const mcv_instance *placed = scene->instances + instance;
    const uint32_t count = scene->meshes[placed->mesh].triangle_count;
    const mcv_mesh_boxes *boxes = known ? mcv_known_boxes(known, scene, placed->mesh) : NULL;
    if (boxes && is_box_away(to, &placed->to_world, &boxes->all)) return;
    for (uint32_t t = 0; t < count; ++t) {
        if (boxes && t % MCV_BOX_TRIANGLES == 0 &&
            is_box_away(to, &placed->to_world, boxes->items + t / MCV_BOX_TRIANGLES)) {
            t += MCV_BOX_TRIANGLES - 1;
            continue;
        }
        double c[3][3];
        mcv_scene_corners(scene, instance, t, c);
        gather(to, c[0], c[1], c[2]);
    }
}

bool mcv_defect_mean_normal(const mcv_scene *scene, mcv_known_meshes *known,
                            const uint32_t instances[2], const double point[3], double radius,
                            double normal[3]) {
    about to = {.point = point, .radius = radius};
    for (uint32_t i = instances[0]; i < instances[1]; ++i) gather_instance(&to, scene, known, i);
    return mcv_normalize3(to.sum, normal);
}
