/* SPDX-License-Identifier: Apache-2.0 */
#include "triangulation/light_plane.h"

#include <float.h>
#include <lapacke.h>
#include <math.h>
#include <string.h>

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void to_camera(const mcv_camera_model *model, const double world[3], double at[3]) {
    for (int i = 0; i < 3; ++i) at[i] = dot(model->rotation + 3 * i, world) + model->translation[i];
}

bool mcv_target_place(const mcv_camera_model *model, const double point[3], const double normal[3],
                      const double place[2], double at[3]) {
    double from[3], to[3], along[3], aside[3], world[3];
    /* A chief ray is straight: two depths tell it. */
    mcv_camera_model_unproject(model, place, 1, from);
    mcv_camera_model_unproject(model, place, 2, to);
    for (int i = 0; i < 3; ++i) {
        along[i] = to[i] - from[i];
        aside[i] = point[i] - from[i];
    }
    const double steps = dot(normal, aside) / dot(normal, along);
    for (int i = 0; i < 3; ++i) world[i] = from[i] + steps * along[i];
    to_camera(model, world, at);
    return isfinite(steps) && (model->telecentric || steps > -1);
}

/* --- the fit --- */

bool mcv_light_plane_fit(const double (*points)[3], size_t count, mcv_light_plane *plane) {
    double a[3][3] = {{0}}, squares[3];
    memset(plane, 0, sizeof *plane);
    if (count < 3) return false;
    for (size_t n = 0; n < count; ++n)
        for (int i = 0; i < 3; ++i) plane->point[i] += points[n][i] / (double)count;
    for (size_t n = 0; n < count; ++n)
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k)
                a[i][k] += (points[n][i] - plane->point[i]) * (points[n][k] - plane->point[k]) /
                           (double)count;
    /* Ascending; eigenvectors become rows. */
    if (LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', 3, a[0], 3, squares) != 0) return false;
    memcpy(plane->normal, a[0], sizeof plane->normal);
    plane->residual = sqrt(fmax(squares[0], 0));
    plane->spread[0] = sqrt(fmax(squares[2], 0));
    plane->spread[1] = sqrt(fmax(squares[1], 0));
    return plane->spread[1] > 1e-2 * plane->spread[0];
}

/* --- the laser's axes --- */

bool mcv_light_plane_turn(const mcv_light_plane *plane, const mcv_camera_model *model,
                          const mcv_transform *laser, mcv_transform *turned) {
    const double *m = laser->m, z[3] = {m[2], m[5], m[8]}, origin[3] = {m[9], m[10], m[11]};
    double axes[3][3] = {{0}}, seen[3], aside = 0;
    /* R turns the world to the camera: its transpose turns back. */
    for (int i = 0; i < 3; ++i)
        axes[1][i] = model->rotation[i] * plane->normal[0] +
                     model->rotation[3 + i] * plane->normal[1] +
                     model->rotation[6 + i] * plane->normal[2];
    if (axes[1][0] * m[1] + axes[1][1] * m[4] + axes[1][2] * m[7] < 0)
        for (int i = 0; i < 3; ++i) axes[1][i] = -axes[1][i];
    to_camera(model, origin, seen);
    for (int i = 0; i < 3; ++i) aside += (seen[i] - plane->point[i]) * plane->normal[i];
    const double out = dot(z, axes[1]);
    for (int i = 0; i < 3; ++i) axes[2][i] = z[i] - out * axes[1][i];
    const double length = sqrt(dot(axes[2], axes[2]));
    /* Rounding of ε leaves ε/length of its direction: half of the digits here. */
    if (!(length > sqrt(DBL_EPSILON))) return false;
    for (int i = 0; i < 3; ++i) axes[2][i] /= length;
    mcv_cross3(axes[1], axes[2], axes[0]);
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) turned->m[3 * i + k] = axes[k][i];
        /* The plane's own normal, whatever the sign of y. */
        const double normal = model->rotation[i] * plane->normal[0] +
                              model->rotation[3 + i] * plane->normal[1] +
                              model->rotation[6 + i] * plane->normal[2];
        turned->m[9 + i] = origin[i] - aside * normal;
    }
    return true;
}
