/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Environment (type "environment"): radiance from infinitely far away in all directions. Rays that
 * leave the scene hit it. A scene has at most one; its node's position has no effect.
 *
 * Without `image` the radiance is the same in all directions, and next-event estimation does not
 * sample it. The image has W x H pixels by longitude and latitude; the radiance is `radiance` times
 * the pixel's value. In the node's frame, which the node's rotation turns, the direction d towards
 * the sky lies in
 *
 *     column = W (1/2 + atan2(d_x, -d_z)/2π)        row = H acos(d_y)/π
 *
 * The image's centre lies at the node's -z and its top at +y; an observer who looks along -z has
 * the image's right half on the right. A pixel is uniform, nothing is interpolated.
 *
 * Next-event estimation chooses a pixel by its brightness times its solid angle Ω = (4π/W)
 * sin(π/2H) sin((2 row + 1) π/2H), and a direction in it by solid angle. The power heuristic weighs
 * it against sampling of the BSDF.
 *
 *     {"type": "environment", "radiance": 0.1}
 *     {"type": "environment", "image": {"uri": "hall.exr"}, "radiance": 2}
 *
 * Emission: a direction chosen in this way, and a point uniform on the disk, across it, of the
 * scene's bounding sphere.
 */
#ifndef MCVISI_EMITTERS_ENVIRONMENT_H
#define MCVISI_EMITTERS_ENVIRONMENT_H

#include "mcvisi/emitters/emitter.h"

#define MCV_ENVIRONMENT_PARAMS(X) \
    X(spectrum, radiance, 1, 0, 1e30, "radiance L, of an image's value 1 [W/(m² sr)]") \
    X(image, image, MCV_UNSET, 0, 4294967294.0, \
      "by longitude and latitude: index or name of one of the file's images, or {\"uri\": " \
      "FILE.exr}")

typedef struct mcv_environment {
    float x[3], y[3], z[3]; /* the node's axes in the world */
    uint width, height;     /* of the image */
    uint padding;
} mcv_environment;
MCV_ASSERT_SIZE(mcv_environment, 48);

/* The image's pixel for a unit direction towards the sky. */
MCV_LOOP_FUNCTION void mcv_environment_pixel(MCV_GLOBAL const mcv_environment *sky,
                                             mcv_vec3 direction, uint *column, uint *row) {
    const float right = mcv_dot(direction, mcv_vec(sky->x[0], sky->x[1], sky->x[2]));
    const float up = mcv_dot(direction, mcv_vec(sky->y[0], sky->y[1], sky->y[2]));
    const float back = mcv_dot(direction, mcv_vec(sky->z[0], sky->z[1], sky->z[2]));
    const float level = mcv_sqrt(mcv_fma(right, right, back * back));
    *column = mcv_cell(mcv_fma(mcv_atan2(right, -back), 0.5f / MCV_PI, 0.5f), sky->width);
    *row = mcv_cell(mcv_atan2(level, up) / MCV_PI, sky->height);
}

/* The row's distance from the nearer pole, in rows. */
MCV_LOOP_FUNCTION uint mcv_environment_from_pole(MCV_GLOBAL const mcv_environment *sky, uint row) {
    return 2u * row < sky->height ? row : sky->height - 1u - row;
}

/* The solid angle of a pixel in the row [sr]. */
MCV_LOOP_FUNCTION float mcv_environment_solid_angle(MCV_GLOBAL const mcv_environment *sky,
                                                    uint row) {
    const float quarter = 0.25f / (float)sky->height;
    float height, middle, unused;
    mcv_sin_cos_turn(quarter, &height, &unused);
    mcv_sin_cos_turn((float)(2u * mcv_environment_from_pole(sky, row) + 1u) * quarter, &middle,
                     &unused);
    return 4.0f * MCV_PI / (float)sky->width * height * middle;
}

/* A direction uniform in the solid angle of the pixel: sin²(θ/2) is uniform. θ counts from the
 * nearer pole, where a cosine would lose its digits. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_environment_sample(MCV_GLOBAL const mcv_environment *sky,
                                                  uint column, uint row, float xi, float eta) {
    const float quarter = 0.25f / (float)sky->height;
    const float first = (float)mcv_environment_from_pole(sky, row);
    float s0, s1, sine, cosine, unused;
    mcv_sin_cos_turn(first * quarter, &s0, &unused);
    mcv_sin_cos_turn((first + 1.0f) * quarter, &s1, &unused);
    mcv_sin_cos_turn(((float)column + xi) / (float)sky->width - 0.5f, &sine, &cosine);
    const float q = mcv_fma(eta, s1 * s1 - s0 * s0, s0 * s0);
    const float left = 1.0f - q;
    const float level = left > 0.0f ? 2.0f * mcv_sqrt(q * left) : 0.0f;
    const float up = mcv_fma(-2.0f, q, 1.0f);
    mcv_vec3 d =
        mcv_scale(mcv_vec(sky->y[0], sky->y[1], sky->y[2]), 2u * row < sky->height ? up : -up);
    d = mcv_along(d, level * sine, mcv_vec(sky->x[0], sky->x[1], sky->x[2]));
    return mcv_along(d, -level * cosine, mcv_vec(sky->z[0], sky->z[1], sky->z[2]));
}

#endif
