/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Telecentric camera (type "telecentric"; report 4.2.1): a stop of diameter D_t in the image-side
 * focal plane z = -f of the main lens. For the image point s on z = -b and a point a uniform on the
 * stop, the point on the lens is o = s + (a - s) b/(b - f); the weight is 0 if |o| > D_l/2.
 *
 * Because the stop lies in the focal plane, the direction is exactly (-a_x/f, -a_y/f, 1). Every
 * chief ray is parallel to the axis, and the image scale m = (b - f)/f is the same at every depth.
 * b <= f is an error. The depth in focus is W = b f/(b - f). Irradiance: A = π D_t²/4 (the stop), h
 * = b - f. It is constant over the image, unless "falloff" is "imageSide": chief rays are oblique
 * there.
 *
 * Given are either focalLength, imageDistance, stopDiameter and lensDiameter or, as on a datasheet,
 * magnification m, workingDistance W and fNumber N (working, image side) or numericalAperture NA =
 * m/(2N) (object side):
 *
 *     f = W m/(1 + m)   b = f (1 + m)   D_t = 2 f NA   D_l = diagonal of the field + 2 W NA
 *
 * Both sets may be given if they agree.
 *
 * A real lens falls off towards the corner: relativeIllumination, a table of its datasheet,
 * multiplies the irradiance by a factor of the distance from the axis on the film.
 *
 *     {"type": "telecentric", "magnification": 0.25, "workingDistance": "110mm", "fNumber": 8,
 *      "resolution": [2448, 2048], "pixelSize": "3.45um"}
 */
#ifndef MCVISI_SENSORS_TELECENTRIC_H
#define MCVISI_SENSORS_TELECENTRIC_H

#include "mcvisi/sensors/sensor.h"
#if !MCV_ON_DEVICE || MCV_WITH_APERTURE
#include "mcvisi/sensors/aperture.h"
#endif
#if !MCV_ON_DEVICE || MCV_WITH_DISTORTION
#include "mcvisi/sensors/distortion.h"
#endif

#define MCV_TELECENTRIC_PARAMS(X) \
    X(length, focalLength, MCV_UNSET, MCV_POSITIVE, 1e3, "focal length f of the main lens [m]") \
    X(length, imageDistance, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "distance b > f from the main lens to the image plane [m]") \
    X(length, stopDiameter, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "diameter D_t of the telecentric stop [m]") \
    X(length, lensDiameter, MCV_UNSET, MCV_POSITIVE, 1e3, "diameter D_l of the main lens [m]") \
    X(number, magnification, MCV_UNSET, MCV_POSITIVE, 1e6, "image size over object size m") \
    X(length, workingDistance, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "distance W from the main lens to the plane in focus [m]") \
    X(number, fNumber, MCV_UNSET, MCV_POSITIVE, 1e9, "working f-number N on the image side") \
    X(number, numericalAperture, MCV_UNSET, MCV_POSITIVE, 1, \
      "numerical aperture on the object side, m/(2N)") \
    MCV_FILM_PARAMS(X) \
    MCV_FALLOFF_PARAMS(X) \
    MCV_APERTURE_PARAMS(X) \
    MCV_DISTORTION_PARAMS(X) \
    MCV_TIME_PARAMS(X) \
    X(curve, relativeIllumination, MCV_UNSET, 1, MCV_CURVE_POINTS, \
      "pairs [distance from the axis on the film, irradiance over that of an ideal lens]: the " \
      "fall-off of a real lens, of its datasheet")

typedef struct mcv_telecentric {
    mcv_centre centre_x, centre_y;
    float pixel_x,
        pixel_y;        /* (binned) pixel size [m] times f/(b - f): from image pixels to the lens */
    float stop_radius;  /* D_t / 2 [m] */
    float stop_to_lens; /* b/(b - f) */
    float stop_to_direction; /* 1/f [1/m] */
    float lens_radius;       /* D_l / 2 [m] */
    float etendue;           /* A/h², 0 for radiance */
    float bend;              /* 1/f if falloff is by image-side angles, else 0 [1/m] */
#if !MCV_ON_DEVICE || MCV_WITH_DISTORTION
    mcv_distortion distortion;
#elif MCV_WITH_APERTURE
    uint no_distortion[MCV_DISTORTION_SIZE / 4];
#endif
#if !MCV_ON_DEVICE || MCV_WITH_APERTURE
    mcv_aperture aperture;
#endif
} mcv_telecentric;
MCV_ASSERT_SIZE(mcv_telecentric, 48 + MCV_APERTURE_BYTES + MCV_DISTORTION_SIZE);

#if MCV_WITH_DISTORTION
/* The camera ray of (X, Y) on the film, over b - f, through the point a of the stop, y up: o = a
 * (1 + f/((b - f) e)) + f u. */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_telecentric_distorted(
    MCV_CONSTANT const mcv_telecentric *sensor, float film_x, float film_y, float a_x, float a_y) {
    mcv_sensor_ray sensor_ray;
    const float h_x = a_x * sensor->distortion.per_distance;
    const float h_y = -a_y * sensor->distortion.per_distance;
    const float f = 1.0f / sensor->stop_to_direction;
    const mcv_film_view view = mcv_view_film(&sensor->distortion, film_x, film_y, h_x, h_y);
    const float o_x = mcv_fma(f, mcv_fma(h_x, 1.0f / view.stretch, view.u_x), a_x);
    const float o_y = mcv_fma(-f, mcv_fma(h_y, 1.0f / view.stretch, view.u_y), a_y);
    sensor_ray.origin = mcv_vec(o_x, o_y, 0.0f);
    sensor_ray.direction = mcv_vec(-a_x / f, -a_y / f, 1.0f);
    sensor_ray.weight =
        mcv_fma(o_x, o_x, o_y * o_y) > sensor->lens_radius * sensor->lens_radius
            ? 0.0f
            : mcv_film_weight(sensor->etendue, sensor->bend, view, sensor_ray.direction, h_x, h_y);
    return sensor_ray;
}
#endif

/* The camera ray through a point of the stop, in stop radii, whatever the shape of the aperture. */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_telecentric_ray(MCV_CONSTANT const mcv_telecentric *sensor,
                                                     mcv_film_sample film, float p_x, float p_y) {
    const float a_x = sensor->stop_radius * p_x;
    const float a_y = sensor->stop_radius * p_y;
#if MCV_WITH_DISTORTION
    return mcv_telecentric_distorted(sensor,
                                     -mcv_from_centre(sensor->centre_x, film.column, film.x) *
                                         sensor->pixel_x * sensor->stop_to_direction,
                                     -mcv_from_centre(sensor->centre_y, film.row, film.y) *
                                         sensor->pixel_y * sensor->stop_to_direction,
                                     a_x, a_y);
#else
    mcv_sensor_ray sensor_ray;
    /* o = a b/(b - f) - s f/(b - f). Both factors are computed in double: a - s would cancel. */
    const float o_x =
        mcv_fma(a_x, sensor->stop_to_lens,
                -mcv_from_centre(sensor->centre_x, film.column, film.x) * sensor->pixel_x);
    const float o_y =
        mcv_fma(a_y, sensor->stop_to_lens,
                mcv_from_centre(sensor->centre_y, film.row, film.y) * sensor->pixel_y);
    sensor_ray.origin = mcv_vec(o_x, o_y, 0.0f);
    sensor_ray.direction =
        mcv_vec(-a_x * sensor->stop_to_direction, -a_y * sensor->stop_to_direction, 1.0f);
    sensor_ray.weight = mcv_fma(o_x, o_x, o_y * o_y) > sensor->lens_radius * sensor->lens_radius
                            ? 0.0f
                            : mcv_sensor_ray_weight(sensor->etendue, sensor->bend,
                                                    sensor_ray.origin, sensor_ray.direction);
    return sensor_ray;
#endif
}

/* The camera ray through a point of the stop, in stop radii. */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_telecentric_through(MCV_CONSTANT const mcv_telecentric *sensor,
                                                         mcv_film_sample film, float p_x,
                                                         float p_y) {
    mcv_sensor_ray sensor_ray = mcv_telecentric_ray(sensor, film, p_x, p_y);
    sensor_ray.weight *= MCV_PUPIL_WEIGHT(sensor, p_x, p_y);
    return sensor_ray;
}

MCV_LOOP_FUNCTION mcv_sensor_ray mcv_telecentric_sample(MCV_CONSTANT const mcv_telecentric *sensor,
                                                        mcv_film_sample film, float xi, float eta) {
    const mcv_pupil_sample p = MCV_SAMPLE_PUPIL(sensor, xi, eta);
    mcv_sensor_ray sensor_ray = mcv_telecentric_ray(sensor, film, p.x, p.y);
    sensor_ray.weight *= p.weight;
    return sensor_ray;
}

#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_TRACING
/* a = -f d, s from o = a b/(b - f) - s f/(b - f) */
MCV_FUNCTION float mcv_telecentric_invert_disc(MCV_CONSTANT const mcv_telecentric *sensor,
                                               mcv_sensor_ray sensor_ray, mcv_film_point *place) {
    const float a_x = -sensor_ray.direction.x / sensor->stop_to_direction;
    const float a_y = -sensor_ray.direction.y / sensor->stop_to_direction;
    const float o_x = sensor_ray.origin.x;
    const float o_y = sensor_ray.origin.y;
    const float stop = sensor->stop_radius * sensor->stop_to_direction; /* as a tangent */
#if MCV_WITH_DISTORTION
    /* (o - a)/f = u + a/(h e) */
    const float per = sensor->distortion.per_distance;
    float x, y;
    if (!mcv_find_on_film(&sensor->distortion, (o_x - a_x) * sensor->stop_to_direction,
                          (a_y - o_y) * sensor->stop_to_direction, a_x * per, -a_y * per, &x, &y))
        return 0.0f;
    const mcv_film_view view = mcv_view_film(&sensor->distortion, x, y, a_x * per, -a_y * per);
    const float to_column = sensor->pixel_x * sensor->stop_to_direction;
    const float to_row = sensor->pixel_y * sensor->stop_to_direction;
    place->column = mcv_on_film(sensor->centre_x, -x / to_column);
    place->row = mcv_on_film(sensor->centre_y, -y / to_row);
#else
    place->column =
        mcv_on_film(sensor->centre_x, mcv_fma(a_x, sensor->stop_to_lens, -o_x) / sensor->pixel_x);
    place->row =
        mcv_on_film(sensor->centre_y, mcv_fma(-a_y, sensor->stop_to_lens, o_y) / sensor->pixel_y);
#endif
    if (mcv_fma(a_x, a_x, a_y * a_y) > sensor->stop_radius * sensor->stop_radius ||
        mcv_fma(o_x, o_x, o_y * o_y) > sensor->lens_radius * sensor->lens_radius)
        return 0.0f;
#if MCV_WITH_DISTORTION
    return mcv_film_weight(sensor->etendue, sensor->bend, view, sensor_ray.direction, a_x * per,
                           -a_y * per) /
           (MCV_PI * stop * stop * sensor->pixel_x * sensor->pixel_y * view.object_share);
#else
    return mcv_sensor_ray_weight(sensor->etendue, sensor->bend, sensor_ray.origin,
                                 sensor_ray.direction) /
           (MCV_PI * stop * stop * sensor->pixel_x * sensor->pixel_y);
#endif
}

MCV_FUNCTION float mcv_telecentric_invert(MCV_CONSTANT const mcv_telecentric *sensor,
                                          mcv_sensor_ray sensor_ray, mcv_film_point *place) {
    const float disc = mcv_telecentric_invert_disc(sensor, sensor_ray, place);
#if MCV_WITH_APERTURE
    const float radius = -sensor->stop_to_direction * sensor->stop_radius;
    return disc * mcv_aperture_weight(&sensor->aperture, sensor_ray.direction.x / radius,
                                      sensor_ray.direction.y / radius);
#else
    return disc;
#endif
}

/* Chooses a point of the stop, which gives the direction. A point chosen on the lens would seldom
 * pass the stop. */
MCV_FUNCTION float mcv_telecentric_connect(MCV_CONSTANT const mcv_telecentric *sensor,
                                           mcv_vec3 point, float xi, float eta,
                                           mcv_sensor_ray *sensor_ray) {
    float cosine, sine;
    const float stop = sensor->stop_radius * sensor->stop_to_direction;
    const float r = stop * mcv_disk(xi, eta, &cosine, &sine);
    sensor_ray->direction = mcv_vec(r * cosine, r * sine, 1.0f);
    sensor_ray->origin = mcv_vec(mcv_fma(-point.z, sensor_ray->direction.x, point.x),
                                 mcv_fma(-point.z, sensor_ray->direction.y, point.y), 0.0f);
    return MCV_PI * stop * stop * point.z * point.z;
}

MCV_FUNCTION float mcv_telecentric_footprint(MCV_CONSTANT const mcv_telecentric *sensor, float z) {
    (void)z;
    return sensor->pixel_x * sensor->pixel_y;
}
#endif

#endif
