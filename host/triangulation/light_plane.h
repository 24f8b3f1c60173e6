/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The plane of a laser's light as a calibration finds it: from lines on a flat target whose place
 * is known. Where the chief rays of a line's places meet the target is where the light is. Of
 * several images with the target at other places, such as the steps of a staircase or along a
 * tilted plane, these points lie in the light's plane; it is fitted by least squares of distances.
 */
#ifndef MCVISI_HOST_TRIANGULATION_LIGHT_PLANE_H
#define MCVISI_HOST_TRIANGULATION_LIGHT_PLANE_H

#include "scene/camera_model.h"

#include <stddef.h>

/* In the camera's coordinates: x right, y down, z forward [m]. */
typedef struct mcv_light_plane {
    double point[3], normal[3]; /* the middle of the points; unit */
    double residual;            /* root of the mean square of the points' distances [m] */
    double spread[2];           /* of the points along the plane, the larger one first [m] */
} mcv_light_plane;

/* Where the chief ray of a place of the image meets a plane of the world, in the camera's
 * coordinates; false where it does not before a perspective camera. */
bool mcv_target_place(const mcv_camera_model *model, const double point[3], const double normal[3],
                      const double place[2], double at[3]);

/* Fits the plane. False for fewer than three points, or points that lie on a straight line within a
 * hundredth of its length. */
bool mcv_light_plane_fit(const double (*points)[3], size_t count, mcv_light_plane *plane);

/* The laser's node, without scale, turned and shifted so that its x-z plane is this one. False
 * where its z axis is the plane's normal within 1.5e-8 rad, so that no axis in the plane is
 * nearest. */
bool mcv_light_plane_turn(const mcv_light_plane *plane, const mcv_camera_model *model,
                          const mcv_transform *laser, mcv_transform *turned);

#endif
