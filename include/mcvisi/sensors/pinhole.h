/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pinhole camera (type "pinhole"): perspective without blur. All camera rays start in the origin,
 * with the direction (-s_x/b, -s_y/b, 1). It has no aperture, so it measures radiance only;
 * "irradiance" is an error.
 *
 *     {"type": "pinhole", "imageDistance": "16mm", "resolution": [640, 480], "pixelSize": "5um"}
 */
#ifndef MCVISI_SENSORS_PINHOLE_H
#define MCVISI_SENSORS_PINHOLE_H

#include "mcvisi/sensors/sensor.h"
#if !MCV_ON_DEVICE || MCV_WITH_DISTORTION
#include "mcvisi/sensors/distortion.h"
#endif

#define MCV_PINHOLE_PARAMS(X) \
    X(length, imageDistance, MCV_REQUIRED, MCV_POSITIVE, 1e3, \
      "distance b from the pinhole to the image plane [m]") \
    MCV_FILM_PARAMS(X) \
    MCV_DISTORTION_PARAMS(X) \
    MCV_TIME_PARAMS(X)

typedef struct mcv_pinhole {
    mcv_centre centre_x, centre_y;
    float slope_x, slope_y; /* (binned) pixel size / b */
    uint padding[2];
#if !MCV_ON_DEVICE || MCV_WITH_DISTORTION
    mcv_distortion distortion;
#elif MCV_WITH_APERTURE
    uint no_distortion[MCV_DISTORTION_SIZE / 4];
#endif
} mcv_pinhole;
MCV_ASSERT_SIZE(mcv_pinhole, 32 + MCV_DISTORTION_SIZE);

MCV_LOOP_FUNCTION mcv_sensor_ray mcv_pinhole_sample(MCV_CONSTANT const mcv_pinhole *sensor,
                                                    mcv_film_sample film, float xi, float eta) {
    mcv_sensor_ray sensor_ray;
    (void)xi;
    (void)eta;
    sensor_ray.origin = mcv_vec(0.0f, 0.0f, 0.0f);
    sensor_ray.direction =
        mcv_vec(-mcv_from_centre(sensor->centre_x, film.column, film.x) * sensor->slope_x,
                mcv_from_centre(sensor->centre_y, film.row, film.y) * sensor->slope_y, 1.0f);
#if MCV_WITH_DISTORTION
    const mcv_film_view view = mcv_view_film(&sensor->distortion, sensor_ray.direction.x,
                                             -sensor_ray.direction.y, 0.0f, 0.0f);
    sensor_ray.direction = mcv_vec(view.u_x, -view.u_y, 1.0f);
#endif
    sensor_ray.weight = 1.0f;
    return sensor_ray;
}

#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_TRACING
/* The lens is one point, so W is per area of d alone. Only connections reach it. */
MCV_FUNCTION float mcv_pinhole_invert(MCV_CONSTANT const mcv_pinhole *sensor,
                                      mcv_sensor_ray sensor_ray, mcv_film_point *place) {
    const int from_lens = sensor_ray.origin.x == 0.0f && sensor_ray.origin.y == 0.0f;
#if MCV_WITH_DISTORTION
    float x, y;
    if (!mcv_find_on_film(&sensor->distortion, sensor_ray.direction.x, -sensor_ray.direction.y,
                          0.0f, 0.0f, &x, &y))
        return 0.0f;
    place->column = mcv_on_film(sensor->centre_x, -x / sensor->slope_x);
    place->row = mcv_on_film(sensor->centre_y, -y / sensor->slope_y);
    const mcv_film_view view = mcv_view_film(&sensor->distortion, x, y, 0.0f, 0.0f);
    return from_lens ? 1.0f / (sensor->slope_x * sensor->slope_y * view.object_share) : 0.0f;
#else
    place->column = mcv_on_film(sensor->centre_x, -sensor_ray.direction.x / sensor->slope_x);
    place->row = mcv_on_film(sensor->centre_y, sensor_ray.direction.y / sensor->slope_y);
    return from_lens ? 1.0f / (sensor->slope_x * sensor->slope_y) : 0.0f;
#endif
}

MCV_FUNCTION float mcv_pinhole_connect(MCV_CONSTANT const mcv_pinhole *sensor, mcv_vec3 point,
                                       float xi, float eta, mcv_sensor_ray *sensor_ray) {
    (void)sensor;
    (void)xi;
    (void)eta;
    sensor_ray->origin = mcv_vec(0.0f, 0.0f, 0.0f);
    sensor_ray->direction = mcv_vec(point.x / point.z, point.y / point.z, 1.0f);
    return 1.0f;
}

MCV_FUNCTION float mcv_pinhole_footprint(MCV_CONSTANT const mcv_pinhole *sensor, float z) {
    return sensor->slope_x * sensor->slope_y * z * z;
}
#endif

#endif
