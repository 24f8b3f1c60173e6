/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Camera with crossed slits (type "crossedSlits"): the example of "A sensor" in
 * docs/adding-an-element.md.
 *
 * Two slits take the place of a pinhole: an upright one at the origin, and a level one
 * `slitDistance` h nearer to the scene. A ray passes both, so that the image is a perspective in x
 * from one depth and in y from another: at the depth z a pixel sees l_x z/b times l_y (z - h)/(b +
 * h). In the optical frame (mcvisi/sensors/sensor.h) the point s of the film sees along
 *
 *     o = (0, s_y h/(b + h), 0)        d = (-s_x/b, -s_y/(b + h), 1)
 *
 * Like a pinhole it measures radiance only.
 *
 *     {"type": "crossedSlits", "imageDistance": "50mm", "slitDistance": "20mm", "resolution": [640,
 * 480], "pixelSize": "10um"}
 */
#ifndef MCVISI_SENSORS_CROSSED_SLITS_H
#define MCVISI_SENSORS_CROSSED_SLITS_H

#include "mcvisi/sensors/sensor.h"

/* X(kind, key, default, min, max, "doc [unit]"): parser, ranges, units, --set, check, help and
 * schema follow (mcvisi/params.h). */
#define MCV_CROSSED_SLITS_PARAMS(X) \
    X(length, imageDistance, MCV_REQUIRED, MCV_POSITIVE, 1e3, \
      "distance b from the upright slit to the image plane [m]") \
    X(length, slitDistance, MCV_REQUIRED, MCV_POSITIVE, 1e3, \
      "how far the level slit lies before the upright one [m]") \
    MCV_FILM_PARAMS(X)

/* What the device needs, computed in double by mcv_crossed_slits_prepare: 4-byte scalars, a
 * multiple of 16 bytes. */
typedef struct mcv_crossed_slits {
    mcv_centre centre_x, centre_y; /* the principal point */
    float slope_x;                 /* (binned) pixel width / b */
    float slope_y;                 /* (binned) pixel height / (b + h) */
    float ahead;                   /* h [m] */
    uint padding;
} mcv_crossed_slits;
MCV_ASSERT_SIZE(mcv_crossed_slits, 32);

/* Host and device compile this. film: the pixel and the place inside it; (xi, eta): a place on the
 * aperture, in [0, 1)², of which there is none. */
MCV_FUNCTION mcv_sensor_ray mcv_crossed_slits_sample(MCV_CONSTANT const mcv_crossed_slits *sensor,
                                                     mcv_film_sample film, float xi, float eta) {
    mcv_sensor_ray sensor_ray;
    const float d_y = mcv_from_centre(sensor->centre_y, film.row, film.y) * sensor->slope_y;
    (void)xi;
    (void)eta;
    sensor_ray.origin = mcv_vec(0.0f, -d_y * sensor->ahead, 0.0f);
    sensor_ray.direction = mcv_vec(
        -mcv_from_centre(sensor->centre_x, film.column, film.x) * sensor->slope_x, d_y, 1.0f);
    sensor_ray.weight = 1.0f;
    return sensor_ray;
}

#endif
