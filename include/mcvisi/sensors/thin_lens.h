/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Thin lens camera (type "thinLens"): entocentric, with depth of field. The image point s lies on
 * the plane z = -b, o is uniform on the lens's disk of diameter D_l. The depth in focus is 1/κ, κ =
 * (b - f)/(b f); with b < f it is a virtual plane behind the lens. Irradiance: A = π D_l²/4, h = b.
 *
 * focusDistance w, the depth in focus, may be given in place of imageDistance: b = f w/(w - f).
 * fNumber, the working one N = b/D_l (mcvisi/sensors/sensor.h), may be given in place of
 * lensDiameter. Both of a pair may be given if they agree.
 *
 *     {"type": "thinLens", "focalLength": "25mm", "focusDistance": "400mm", "fNumber": 4,
 *      "resolution": [1280, 1024], "pixelSize": "4.8um", "radiometry": "irradiance"}
 */
#ifndef MCVISI_SENSORS_THIN_LENS_H
#define MCVISI_SENSORS_THIN_LENS_H

#include "mcvisi/sensors/sensor.h"
#if !MCV_ON_DEVICE || MCV_WITH_APERTURE
#include "mcvisi/sensors/aperture.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_DISTORTION
#include "mcvisi/sensors/distortion.h"
#endif

#define MCV_THIN_LENS_VIEW_PARAMS(X) \
    MCV_LENS_PARAMS(X) \
    MCV_FILM_PARAMS(X) \
    MCV_FALLOFF_PARAMS(X) \
    MCV_APERTURE_PARAMS(X) \
    MCV_DISTORTION_PARAMS(X)
#define MCV_THIN_LENS_PARAMS(X) \
    MCV_THIN_LENS_VIEW_PARAMS(X) \
    MCV_TIME_PARAMS(X)

/* Type "lineScan": a thin lens camera of which one line is read. */
#define MCV_LINE_SCAN_PARAMS(X) \
    MCV_THIN_LENS_VIEW_PARAMS(X) \
    X(choice, shutter, 2, 2, 2, "one line for all rows of the image, which are times") \
    MCV_EXPOSURE_PARAMS(X)

typedef struct mcv_thin_lens {
    mcv_centre centre_x, centre_y;
    float slope_x, slope_y; /* (binned) pixel size / b */
    float kappa;            /* (b - f)/(b f) [1/m] */
    float radius;           /* D_l / 2 [m] */
    float etendue;          /* A/h², 0 for radiance */
    float bend;             /* 1/f if falloff is by image-side angles, else 0 [1/m] */
    uint padding[2];
#if !MCV_ON_DEVICE || MCV_WITH_DISTORTION
    mcv_distortion distortion;
#elif MCV_WITH_APERTURE
    uint no_distortion[MCV_DISTORTION_SIZE / 4];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_APERTURE
    mcv_aperture aperture;
#endif
} mcv_thin_lens;
MCV_ASSERT_SIZE(mcv_thin_lens, 48 + MCV_APERTURE_BYTES + MCV_DISTORTION_SIZE);

#if MCV_WITH_DISTORTION
/* The camera ray of (X, Y) on the film, through a point of the lens, y up. Each place is in focus
 * at its own depth: 1/w = 1/f - 1/(b e). */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_thin_lens_distorted(MCV_CONSTANT const mcv_thin_lens *sensor,
                                                         float film_x, float film_y, float o_x,
                                                         float o_y) {
    mcv_sensor_ray sensor_ray;
    const float a_x = o_x * sensor->distortion.per_distance;
    const float a_y = -o_y * sensor->distortion.per_distance;
    const mcv_film_view view = mcv_view_film(&sensor->distortion, film_x, film_y, a_x, a_y);
    const float lean = (view.stretch - 1.0f) / view.stretch; /* 1 - 1/e */
    sensor_ray.origin = mcv_vec(o_x, o_y, 0.0f);
    sensor_ray.direction =
        mcv_vec(mcv_fma(-lean, a_x, mcv_fma(-sensor->kappa, o_x, view.u_x)),
                mcv_fma(lean, a_y, -mcv_fma(sensor->kappa, o_y, view.u_y)), 1.0f);
    sensor_ray.weight =
        mcv_film_weight(sensor->etendue, sensor->bend, view, sensor_ray.direction, a_x, a_y);
    return sensor_ray;
}
#endif

/* The camera ray through a point of the lens, in lens radii, whatever the shape of the aperture. */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_thin_lens_ray(MCV_CONSTANT const mcv_thin_lens *sensor,
                                                   mcv_film_sample film, float p_x, float p_y) {
#if MCV_WITH_DISTORTION
    return mcv_thin_lens_distorted(
        sensor, -mcv_from_centre(sensor->centre_x, film.column, film.x) * sensor->slope_x,
        -mcv_from_centre(sensor->centre_y, film.row, film.y) * sensor->slope_y,
        sensor->radius * p_x, sensor->radius * p_y);
#else
    mcv_sensor_ray sensor_ray;
    sensor_ray.origin = mcv_vec(sensor->radius * p_x, sensor->radius * p_y, 0.0f);
    sensor_ray.direction = mcv_vec(-mcv_fma(mcv_from_centre(sensor->centre_x, film.column, film.x),
                                            sensor->slope_x, sensor->kappa * sensor_ray.origin.x),
                                   mcv_fma(mcv_from_centre(sensor->centre_y, film.row, film.y),
                                           sensor->slope_y, -sensor->kappa * sensor_ray.origin.y),
                                   1.0f);
    sensor_ray.weight = mcv_sensor_ray_weight(sensor->etendue, sensor->bend, sensor_ray.origin,
                                              sensor_ray.direction);
    return sensor_ray;
#endif
}

/* The camera ray through a point of the lens, in lens radii. */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_thin_lens_through(MCV_CONSTANT const mcv_thin_lens *sensor,
                                                       mcv_film_sample film, float p_x, float p_y) {
    mcv_sensor_ray sensor_ray = mcv_thin_lens_ray(sensor, film, p_x, p_y);
    sensor_ray.weight *= MCV_PUPIL_WEIGHT(sensor, p_x, p_y);
    return sensor_ray;
}

MCV_LOOP_FUNCTION mcv_sensor_ray mcv_thin_lens_sample(MCV_CONSTANT const mcv_thin_lens *sensor,
                                                      mcv_film_sample film, float xi, float eta) {
    const mcv_pupil_sample p = MCV_SAMPLE_PUPIL(sensor, xi, eta);
    mcv_sensor_ray sensor_ray = mcv_thin_lens_ray(sensor, film, p.x, p.y);
    sensor_ray.weight *= p.weight;
    return sensor_ray;
}

#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_TRACING
/* s/b = -(d + κ o) */
MCV_FUNCTION float mcv_thin_lens_invert_disc(MCV_CONSTANT const mcv_thin_lens *sensor,
                                             mcv_sensor_ray sensor_ray, mcv_film_point *place) {
    const float squared = sensor->radius * sensor->radius;
    const float o_x = sensor_ray.origin.x;
    const float o_y = sensor_ray.origin.y;
#if MCV_WITH_DISTORTION
    const float per = sensor->distortion.per_distance;
    const float bend = sensor->kappa + per; /* 1/f */
    float x, y;
    if (!mcv_find_on_film(&sensor->distortion, mcv_fma(bend, o_x, sensor_ray.direction.x),
                          -mcv_fma(bend, o_y, sensor_ray.direction.y), o_x * per, -o_y * per, &x,
                          &y) ||
        mcv_fma(o_x, o_x, o_y * o_y) > squared)
        return 0.0f;
    place->column = mcv_on_film(sensor->centre_x, -x / sensor->slope_x);
    place->row = mcv_on_film(sensor->centre_y, -y / sensor->slope_y);
    const mcv_film_view view = mcv_view_film(&sensor->distortion, x, y, o_x * per, -o_y * per);
    return mcv_film_weight(sensor->etendue, sensor->bend, view, sensor_ray.direction, o_x * per,
                           -o_y * per) /
           (MCV_PI * squared * sensor->slope_x * sensor->slope_y * view.object_share);
#else
    place->column = mcv_on_film(
        sensor->centre_x, -mcv_fma(sensor->kappa, o_x, sensor_ray.direction.x) / sensor->slope_x);
    place->row = mcv_on_film(sensor->centre_y,
                             mcv_fma(sensor->kappa, o_y, sensor_ray.direction.y) / sensor->slope_y);
    if (mcv_fma(o_x, o_x, o_y * o_y) > squared) return 0.0f;
    return mcv_sensor_ray_weight(sensor->etendue, sensor->bend, sensor_ray.origin,
                                 sensor_ray.direction) /
           (MCV_PI * squared * sensor->slope_x * sensor->slope_y);
#endif
}

MCV_FUNCTION float mcv_thin_lens_invert(MCV_CONSTANT const mcv_thin_lens *sensor,
                                        mcv_sensor_ray sensor_ray, mcv_film_point *place) {
    const float disc = mcv_thin_lens_invert_disc(sensor, sensor_ray, place);
#if MCV_WITH_APERTURE
    return disc * mcv_aperture_weight(&sensor->aperture, sensor_ray.origin.x / sensor->radius,
                                      sensor_ray.origin.y / sensor->radius);
#else
    return disc;
#endif
}

MCV_FUNCTION float mcv_thin_lens_connect(MCV_CONSTANT const mcv_thin_lens *sensor, mcv_vec3 point,
                                         float xi, float eta, mcv_sensor_ray *sensor_ray) {
    float cosine, sine;
    const float r = sensor->radius * mcv_disk(xi, eta, &cosine, &sine);
    sensor_ray->origin = mcv_vec(r * cosine, r * sine, 0.0f);
    sensor_ray->direction = mcv_vec((point.x - sensor_ray->origin.x) / point.z,
                                    (point.y - sensor_ray->origin.y) / point.z, 1.0f);
    return MCV_PI * sensor->radius * sensor->radius;
}

MCV_FUNCTION float mcv_thin_lens_footprint(MCV_CONSTANT const mcv_thin_lens *sensor, float z) {
    return sensor->slope_x * sensor->slope_y * z * z;
}
#endif

#endif
