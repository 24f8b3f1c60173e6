/* SPDX-License-Identifier: Apache-2.0 */
/* Moves vertices and turns normals as a defect does (mcvisi/defects.h). */
#include "defects/facets.h"

#include "scene/transform.h"

#include <math.h>

/* A vector of the world in the instance's frame: by the inverse of its matrix m. */
static void to_frame(const double m[9], const double vector[3], double local[3]) {
    double cofactors[3][3];
    mcv_cross3(m + 3, m + 6, cofactors[0]);
    mcv_cross3(m + 6, m, cofactors[1]);
    mcv_cross3(m, m + 3, cofactors[2]);
    const double determinant =
        m[0] * cofactors[0][0] + m[1] * cofactors[0][1] + m[2] * cofactors[0][2];
    for (int i = 0; i < 3; ++i)
        local[i] = (cofactors[0][i] * vector[0] + cofactors[1][i] * vector[1] +
                    cofactors[2][i] * vector[2]) /
                   determinant;
}

/* Normals go back by the transposed matrix. */
static void normal_to_frame(const mcv_transform *t, const double world[3], float normal[3]) {
    double local[3];
    for (int i = 0; i < 3; ++i)
        local[i] = t->m[i] * world[0] + t->m[3 + i] * world[1] + t->m[6 + i] * world[2];
    if (!mcv_normalize3(local, local)) return;
    for (int i = 0; i < 3; ++i) normal[i] = (float)local[i];
}

/* Along the normal of the ground, in the instance's frame. */
static void lift(const mcv_ground *ground, const mcv_transform *t, double h, float position[3]) {
    const double *n = ground->defect->axes[2], up[3] = {h * n[0], h * n[1], h * n[2]};
    double local[3];
    to_frame(t->m, up, local);
    for (int i = 0; i < 3; ++i) position[i] = (float)((double)position[i] + local[i]);
}

/* --- reliefs and pits --- */

/* n - grad h (n . n0), from the frame to the world and back. */
static void tilt_normal(const mcv_ground *ground, const mcv_transform *t, const double gradient[3],
                        float normal[3]) {
    const double *up = ground->defect->axes[2];
    double world[3];
    mcv_transform_normal(t, (const double[3]){normal[0], normal[1], normal[2]}, world);
    const double share = world[0] * up[0] + world[1] * up[1] + world[2] * up[2];
    for (int i = 0; i < 3; ++i) world[i] -= share * gradient[i];
    normal_to_frame(t, world, normal);
}

/* t + n0 (grad h . t) */
static void tilt_tangent(const mcv_ground *ground, const mcv_transform *t, const double gradient[3],
                         float tangent[3]) {
    double world[3], local[3];
    mcv_transform_vector(t, (const double[3]){tangent[0], tangent[1], tangent[2]}, world);
    const double rise = world[0] * gradient[0] + world[1] * gradient[1] + world[2] * gradient[2];
    for (int i = 0; i < 3; ++i) world[i] += rise * ground->defect->axes[2][i];
    to_frame(t->m, world, local);
    if (!mcv_normalize3(local, local)) return;
    for (int i = 0; i < 3; ++i) tangent[i] = (float)local[i];
}

/* A pit has a slope at its outline already. */
static void raise_corner(const mcv_ground *ground, const mcv_transform *t, const double at[3],
                         bool fixed, mcv_corner *corner) {
    const mcv_defect *d = ground->defect;
    double slope[2], gradient[3];
    const double h = mcv_defect_height(d, at[0], at[1], slope);
    if (h == 0 && slope[0] == 0 && slope[1] == 0) return;
    for (int i = 0; i < 3; ++i) gradient[i] = slope[0] * d->axes[0][i] + slope[1] * d->axes[1][i];
    if (!fixed) lift(ground, t, h, corner->position);
    tilt_normal(ground, t, gradient, corner->normal);
    tilt_tangent(ground, t, gradient, corner->tangent);
}

/* --- cuts --- */

static void cut_corner(const mcv_ground *ground, const mcv_transform *t, const double at[3],
                       bool fixed, mcv_corner *corner) {
    const mcv_defect *d = ground->defect;
    double normal[3], world[3] = {0, 0, 0};
    const double height = mcv_defect_cut(d, at[0], at[1], normal);
    if (!fixed) lift(ground, t, height - at[2], corner->position);
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i) world[i] += normal[k] * d->axes[k][i];
    normal_to_frame(t, world, corner->normal);
}

void mcv_facet_move(const mcv_ground *ground, mcv_facet *facet, int k) {
    const mcv_transform *t = &ground->scene->instances[facet->instance].to_world;
    mcv_corner *corner = &facet->corners[k];
    const bool fixed = facet->fixed >> k & 1;
    double at[3];
    mcv_ground_point(ground, facet->instance, corner->position, at);
    if (mcv_defect_kind_of(ground->defect->type) == MCV_KIND_CUT)
        cut_corner(ground, t, at, fixed, corner);
    else
        raise_corner(ground, t, at, fixed, corner);
}
