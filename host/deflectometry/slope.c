/* SPDX-License-Identifier: Apache-2.0 */
#include "deflectometry/slope.h"

#include <math.h>

#include "scene/emitters.h"

void mcv_screen_point(const mcv_screen_place *screen, const double pixel[2], double world[3]) {
    double place[3] = {0, 0, 0}, share[2];
    for (int i = 0; i < 2; ++i) { /* column 0 at +x, row 0 at +y */
        share[i] = 1 - 2 * pixel[i] / screen->pixels[i];
        place[i] = share[i] * screen->pixels[i] * screen->params->pixelPitch[i] / 2;
    }
    if (!screen->flat) place[2] = -mcv_screen_rise(screen->params, share[0], share[1]);
    mcv_transform_point(&screen->to_world, place, world);
}

static void make_unit(double v[3]) {
    const double length = hypot(hypot(v[0], v[1]), v[2]);
    for (int i = 0; i < 3; ++i) v[i] /= length;
}

mcv_chief_ray mcv_chief_ray_of(const mcv_camera_model *model, uint32_t column, uint32_t row) {
    mcv_chief_ray ray = {0};
    const double pixel[2] = {column + 0.5, row + 0.5};
    /* Two depths that differ by about the distance of the part keep the direction's digits. */
    const double far =
        model->focused_depth > 0 && isfinite(model->focused_depth) ? model->focused_depth : 1;
    double end[3];
    mcv_camera_model_unproject(model, pixel, far / 2, ray.point);
    mcv_camera_model_unproject(model, pixel, far, end);
    for (int i = 0; i < 3; ++i) ray.direction[i] = end[i] - ray.point[i];
    make_unit(ray.direction);
    return ray;
}

/* A vector of the world in the axes of a node, which have no scale. */
static void to_axes(const mcv_transform *node, const double v[3], double out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = node->m[i] * v[0] + node->m[3 + i] * v[1] + node->m[6 + i] * v[2];
}

bool mcv_intersect_plane(const mcv_chief_ray *ray, const mcv_transform *plane, double height,
                         double at[3]) {
    double way[3], from[3], direction[3];
    for (int i = 0; i < 3; ++i) way[i] = ray->point[i] - plane->m[9 + i];
    to_axes(plane, way, from);
    to_axes(plane, ray->direction, direction);
    const double t = (height - from[2]) / direction[2];
    for (int i = 0; i < 2; ++i) at[i] = from[i] + t * direction[i];
    at[2] = height;
    return isfinite(t);
}

bool mcv_slopes_of(const mcv_chief_ray *ray, const mcv_transform *plane, const double at[3],
                   const double shown[3], double slopes[2]) {
    double world[3], normal[3], back[3];
    for (int i = 0; i < 3; ++i) world[i] = shown[i] - plane->m[9 + i];
    to_axes(plane, world, normal);
    for (int i = 0; i < 3; ++i) normal[i] -= at[i];
    make_unit(normal);
    to_axes(plane, ray->direction, back);
    for (int i = 0; i < 3; ++i) normal[i] -= back[i];
    /* The camera and the screen lie on the same side of the surface. */
    if (!(normal[2] * -back[2] > 0)) return false;
    for (int i = 0; i < 2; ++i) slopes[i] = -normal[i] / normal[2];
    return true;
}
