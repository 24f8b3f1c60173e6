/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Slopes from the law of reflection: where a camera's ray meets the part and which place of the
 * screen it shows there give the normal, which halves the angle between both ways.
 */
#ifndef MCVISI_HOST_DEFLECTOMETRY_SLOPE_H
#define MCVISI_HOST_DEFLECTOMETRY_SLOPE_H

#include "scene/camera_model.h"
#include "scene/scene.h"

/* A screen in the world. */
typedef struct mcv_screen_place {
    const mcv_screen_params *params;
    mcv_transform to_world;
    double pixels[2]; /* W, H */
    bool flat;        /* take it as flat, whatever its parameters say */
} mcv_screen_place;

/* The point of the world at a place in pixels from the corner of pixel (0, 0). */
void mcv_screen_point(const mcv_screen_place *screen, const double pixel[2], double world[3]);

/* A camera ray: a point and a unit direction. */
typedef struct mcv_chief_ray {
    double point[3], direction[3];
} mcv_chief_ray;

/* The chief ray through the middle of a pixel. */
mcv_chief_ray mcv_chief_ray_of(const mcv_camera_model *model, uint32_t column, uint32_t row);

/* Where a ray meets the plane at a height over the node's x-y plane, in the node's axes [m]; false
 * where it does not. */
bool mcv_intersect_plane(const mcv_chief_ray *ray, const mcv_transform *plane, double height,
                         double at[3]);

/*
 * The slopes dz/dx and dz/dy in the node's axes of a surface that shows, at the place `at` in them,
 * the point `shown` of the world. false where no surface reflects so towards the camera.
 */
bool mcv_slopes_of(const mcv_chief_ray *ray, const mcv_transform *plane, const double at[3],
                   const double shown[3], double slopes[2]);

#endif
