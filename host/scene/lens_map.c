/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/lens_map.h"

#include <math.h>
#include <string.h>

mcv_lens_map mcv_lens_map_none(void) {
    return (mcv_lens_map){.axes = {{1, 0, 0}, {0, 1, 0}},
                          .tilt = NAN,
                          .direction = NAN,
                          .tilt_xy = {NAN, NAN},
                          .reach = INFINITY};
}

void mcv_lens_map_forget(mcv_lens_map *map) {
    map->model = MCV_UNDISTORTED;
    map->reach = INFINITY;
}

/* By the angle about (cosρ, sinρ, 0), Rodrigues' formula: the first two columns are the axes. */
void mcv_lens_map_tilt(mcv_lens_map *map, double tilt, double direction) {
    const double c = cos(direction), s = sin(direction), turn = cos(tilt), lift = sin(tilt);
    const double axes[2][3] = {{c * c * (1 - turn) + turn, c * s * (1 - turn), -s * lift},
                               {c * s * (1 - turn), s * s * (1 - turn) + turn, c * lift}};
    memcpy(map->axes, axes, sizeof axes);
    map->tilt = tilt;
    map->direction = direction;
    map->tilted = tilt != 0;
}

/* Rows 1 and 2 of R_y(τy) R_x(τx), as OpenCV writes these. */
void mcv_lens_map_tilt_xy(mcv_lens_map *map, double x, double y) {
    const double axes[2][3] = {{cos(y), sin(y) * sin(x), -sin(y) * cos(x)}, {0, cos(x), sin(x)}};
    memcpy(map->axes, axes, sizeof axes);
    map->tilt_xy[0] = x;
    map->tilt_xy[1] = y;
    map->tilted = x != 0 || y != 0;
}

/* --- the lens --- */

/* s of u, with the derivatives of s by u by rows; false where there is no s. */
static bool distort(const mcv_lens_map *m, const double u[2], double s[2], double by[4]) {
    const double x = u[0], y = u[1], r = x * x + y * y;
    if (m->model == MCV_DIVISION) {
        const double root = sqrt(1 - 4 * m->kappa * r), c = 2 / (1 + root),
                     grow = 2 * m->kappa * c * c / root;
        s[0] = c * x, s[1] = c * y;
        by[0] = c + grow * x * x, by[1] = by[2] = grow * x * y, by[3] = c + grow * y * y;
        return root > 0;
    }
    const double *k = m->k, *p = m->p, *t = m->s;
    const double above = 1 + r * (k[0] + r * (k[1] + r * k[2])),
                 below = 1 + r * (k[3] + r * (k[4] + r * k[5])), radial = above / below;
    const double above_r = k[0] + r * (2 * k[1] + 3 * r * k[2]),
                 below_r = k[3] + r * (2 * k[4] + 3 * r * k[5]),
                 grow = 2 * (above_r - radial * below_r) / below;
    const double prism[2] = {2 * (t[0] + 2 * r * t[1]), 2 * (t[2] + 2 * r * t[3])};
    s[0] = x * radial + 2 * p[0] * x * y + p[1] * (r + 2 * x * x) + r * (t[0] + r * t[1]);
    s[1] = y * radial + p[0] * (r + 2 * y * y) + 2 * p[1] * x * y + r * (t[2] + r * t[3]);
    by[0] = radial + grow * x * x + 2 * p[0] * y + 6 * p[1] * x + prism[0] * x;
    by[1] = grow * x * y + 2 * p[0] * x + 2 * p[1] * y + prism[0] * y;
    by[2] = grow * x * y + 2 * p[0] * x + 2 * p[1] * y + prism[1] * x;
    by[3] = radial + grow * y * y + 6 * p[0] * y + 2 * p[1] * x + prism[1] * y;
    return below > 0;
}

void mcv_lens_map_distort(const mcv_lens_map *map, const double u[2], double s[2]) {
    double by[4];
    distort(map, u, s, by);
}

/* The device takes as many steps from the same start; in double one more makes the last digits
 * right. */
bool mcv_lens_map_undistort(const mcv_lens_map *map, const double s[2], double u[2]) {
    double at[2], by[4], error = INFINITY;
    u[0] = s[0], u[1] = s[1];
    if (map->model == MCV_UNDISTORTED) return true;
    if (map->model == MCV_DIVISION) {
        /* |u| grows with |s| as long as κ |s|² is between -1 and 1. */
        const double bent = map->kappa * (s[0] * s[0] + s[1] * s[1]);
        u[0] /= 1 + bent, u[1] /= 1 + bent;
        return fabs(bent) < 1;
    }
    for (int step = 0; step <= MCV_UNDISTORT_STEPS; ++step) {
        if (!distort(map, u, at, by)) return false;
        const double inverse = 1 / (by[0] * by[3] - by[1] * by[2]), x = at[0] - s[0],
                     y = at[1] - s[1];
        error = hypot(x, y);
        u[0] -= (by[3] * x - by[1] * y) * inverse;
        u[1] -= (by[0] * y - by[2] * x) * inverse;
    }
    return error < 1e-9 && hypot(u[0], u[1]) <= map->reach;
}

/* Along rays from the axis: up to where the area that a slope maps to turns over, or twice as far
 * as any film. */
void mcv_lens_map_find_reach(mcv_lens_map *map) {
    enum { RAYS = 64, STEPS = 2000 };
    static const double most = 20;
    map->reach = map->model == MCV_UNDISTORTED ? INFINITY : most;
    if (map->model == MCV_DIVISION)
        map->reach = map->kappa > 0 ? sqrt(1 / (4 * map->kappa)) : INFINITY;
    if (map->model != MCV_BROWN_CONRADY) return;
    for (int ray = 0; ray < RAYS; ++ray) {
        const double angle = 2 * M_PI * ray / RAYS, c = cos(angle), s = sin(angle);
        /* Steps grow with the slope. */
        for (double r = 1e-3; r < map->reach; r *= 1 + 10.0 / STEPS) {
            const double u[2] = {r * c, r * s};
            double at[2], by[4];
            if (distort(map, u, at, by) && by[0] * by[3] - by[1] * by[2] > 0 &&
                c * (by[0] * c + by[1] * s) + s * (by[2] * c + by[3] * s) > 0)
                continue;
            map->reach = r;
            break;
        }
    }
}

/* --- the film --- */

bool mcv_lens_map_look(const mcv_lens_map *map, const double film[2], double u[2],
                       double *stretch) {
    const double(*a)[3] = map->axes;
    const double e = 1 + film[0] * a[0][2] + film[1] * a[1][2],
                 s[2] = {(film[0] * a[0][0] + film[1] * a[1][0]) / e,
                         (film[0] * a[0][1] + film[1] * a[1][1]) / e};
    *stretch = e;
    return e > 0 && mcv_lens_map_undistort(map, s, u);
}

bool mcv_lens_map_meet(const mcv_lens_map *map, const double u[2], double film[2]) {
    const double(*a)[3] = map->axes;
    double s[2] = {u[0], u[1]};
    if (!(hypot(u[0], u[1]) <= map->reach)) return false;
    if (map->model != MCV_UNDISTORTED) mcv_lens_map_distort(map, u, s);
    const double n[3] = {a[0][1] * a[1][2] - a[0][2] * a[1][1],
                         a[0][2] * a[1][0] - a[0][0] * a[1][2],
                         a[0][0] * a[1][1] - a[0][1] * a[1][0]},
                 facing = n[0] * s[0] + n[1] * s[1] + n[2], e = n[2] / facing;
    if (!(facing > 0)) return false;
    for (int i = 0; i < 2; ++i)
        film[i] = e * s[0] * a[i][0] + e * s[1] * a[i][1] + (e - 1) * a[i][2];
    return true;
}
