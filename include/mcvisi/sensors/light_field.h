/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Light field camera (type "lightField"; report 4.2.2): M x N macro pixels of J x K sensor pixels
 * each; the film has M·J x N·K pixels. All samples of a macro pixel look at the same focused point,
 * through different points of the main lens. With c the centre of the macro pixel that contains s,
 * (x, y) = c and o = -(s - c)/(J l_x/2, K l_y/2) · D_l/2, the report's linear map in this frame. It
 * is computed from integers (u = (column mod J + ξ)/J), because a float column + ξ could round into
 * the next macro pixel.
 *
 * "aperture": "square" is the report's; "circle" gives weight 0 outside D_l/2. With binning, each
 * sample looks through one of the binned macro pixels, chosen by the aperture sample, which is not
 * used otherwise. Irradiance: A = D_l² (the sampled square), h = b.
 *
 * focusDistance w may be given in place of imageDistance, and fNumber = b/D_l in place of
 * lensDiameter, as for the thin lens.
 *
 *     {"type": "lightField", "focalLength": "50mm", "imageDistance": "60mm", "lensDiameter":
 * "20mm", "spatialResolution": [160, 120], "angularResolution": [9, 9], "pixelSize": "4um"}
 */
#ifndef MCVISI_SENSORS_LIGHT_FIELD_H
#define MCVISI_SENSORS_LIGHT_FIELD_H

#include "mcvisi/sensors/sensor.h"

#define MCV_LIGHT_FIELD_PARAMS(X) \
    MCV_LENS_PARAMS(X) \
    X(int2, spatialResolution, MCV_REQUIRED, 1, 65536, "macro pixels M, N in x and y") \
    X(int2, angularResolution, MCV_REQUIRED, 1, 256, \
      "sensor pixels J, K of a macro pixel in x and y") \
    X(length2, pixelSize, MCV_REQUIRED, MCV_POSITIVE, 1, "width and height of a sensor pixel [m]") \
    MCV_READOUT_PARAMS(X) \
    X(choice, aperture, 0, 0, 1, "shape of the main lens") \
    X(choice, radiometry, 0, 0, 1, \
      "what a pixel measures: mean radiance [W/(m² sr)] or irradiance [W/m²]") \
    MCV_FALLOFF_PARAMS(X)

typedef struct mcv_light_field {
    mcv_centre centre_x, centre_y;      /* in macro pixels */
    uint binning_x, binning_y;          /* macro pixels */
    uint angular_width, angular_height; /* J, K */
    float slope_x, slope_y;             /* size of a macro pixel / b */
    float kappa;                        /* (b - f)/(b f) [1/m] */
    float radius;                       /* D_l / 2 [m] */
    float etendue;                      /* A/h², 0 for radiance */
    uint circle;                        /* 1: only the inscribed disk transmits light */
    float bend;                         /* 1/f if falloff is by image-side angles, else 0 [1/m] */
    uint padding;
} mcv_light_field;
MCV_ASSERT_SIZE(mcv_light_field, 64);

/* One of `count`, for ξ in [0, 1); the clamp is needed because the product may round up to
 * `count`. */
MCV_FUNCTION uint mcv_pick(float xi, uint count) {
    const uint i = (uint)(xi * (float)count);
    return i < count ? i : count - 1u;
}

/*
 * The camera ray through a point, -1 … 1 along columns and rows, of the pixel's square of the lens.
 * (film.x, film.y) chooses among the binned macro pixels.
 */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_light_field_through(MCV_CONSTANT const mcv_light_field *sensor,
                                                         mcv_film_sample film, float p_x,
                                                         float p_y) {
    mcv_sensor_ray sensor_ray;
    const uint column = film.column / sensor->angular_width;
    const uint row = film.row / sensor->angular_height;
    const float u =
        ((float)(film.column - column * sensor->angular_width) + mcv_fma(0.5f, p_x, 0.5f)) /
        (float)sensor->angular_width;
    const float v = ((float)(film.row - row * sensor->angular_height) + mcv_fma(0.5f, p_y, 0.5f)) /
                    (float)sensor->angular_height;
    const uint m = column * sensor->binning_x + mcv_pick(film.x, sensor->binning_x);
    const uint n = row * sensor->binning_y + mcv_pick(film.y, sensor->binning_y);
    const float lens_x = mcv_fma(2.0f, u, -1.0f);
    const float lens_y = -mcv_fma(2.0f, v, -1.0f);
    sensor_ray.origin = mcv_vec(lens_x * sensor->radius, lens_y * sensor->radius, 0.0f);
    sensor_ray.direction = mcv_vec(-mcv_fma(mcv_from_centre(sensor->centre_x, m, 0.5f),
                                            sensor->slope_x, sensor->kappa * sensor_ray.origin.x),
                                   mcv_fma(mcv_from_centre(sensor->centre_y, n, 0.5f),
                                           sensor->slope_y, -sensor->kappa * sensor_ray.origin.y),
                                   1.0f);
    sensor_ray.weight = sensor->circle && mcv_fma(lens_x, lens_x, lens_y * lens_y) > 1.0f
                            ? 0.0f
                            : mcv_sensor_ray_weight(sensor->etendue, sensor->bend,
                                                    sensor_ray.origin, sensor_ray.direction);
    return sensor_ray;
}

MCV_LOOP_FUNCTION mcv_sensor_ray mcv_light_field_sample(MCV_CONSTANT const mcv_light_field *sensor,
                                                        mcv_film_sample film, float xi, float eta) {
    mcv_film_sample binned = film;
    binned.x = xi;
    binned.y = eta;
    return mcv_light_field_through(sensor, binned, mcv_fma(2.0f, film.x, -1.0f),
                                   mcv_fma(2.0f, film.y, -1.0f));
}

#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_TRACING
/*
 * The macro pixel from (x, y), its sensor pixel from o. Camera rays pass only through centres of
 * macro pixels, which light paths hit with probability 0. For light paths each centre therefore
 * stands for its whole macro pixel; they measure the mean over it.
 */
MCV_FUNCTION float mcv_light_field_invert(MCV_CONSTANT const mcv_light_field *sensor,
                                          mcv_sensor_ray sensor_ray, mcv_film_point *place) {
    const float p_x = sensor_ray.origin.x / sensor->radius;
    const float p_y = sensor_ray.origin.y / sensor->radius;
    const float m = mcv_on_film(
        sensor->centre_x,
        -mcv_fma(sensor->kappa, sensor_ray.origin.x, sensor_ray.direction.x) / sensor->slope_x);
    const float n = mcv_on_film(
        sensor->centre_y,
        mcv_fma(sensor->kappa, sensor_ray.origin.y, sensor_ray.direction.y) / sensor->slope_y);
    const float width = (float)sensor->angular_width;
    const float height = (float)sensor->angular_height;
    if (mcv_abs(p_x) > 1.0f || mcv_abs(p_y) > 1.0f ||
        (sensor->circle && mcv_fma(p_x, p_x, p_y * p_y) > 1.0f))
        return 0.0f;
    const float j = (float)mcv_pick(mcv_fma(0.5f, p_x, 0.5f), sensor->angular_width);
    const float k = (float)mcv_pick(mcv_fma(-0.5f, p_y, 0.5f), sensor->angular_height);
    place->column = mcv_fma(mcv_floor(m / (float)sensor->binning_x), width, j + 0.5f);
    place->row = mcv_fma(mcv_floor(n / (float)sensor->binning_y), height, k + 0.5f);
    const float macro =
        sensor->slope_x * sensor->slope_y * (float)(sensor->binning_x * sensor->binning_y);
    return mcv_sensor_ray_weight(sensor->etendue, sensor->bend, sensor_ray.origin,
                                 sensor_ray.direction) *
           width * height / (4.0f * sensor->radius * sensor->radius * macro);
}

MCV_FUNCTION float mcv_light_field_connect(MCV_CONSTANT const mcv_light_field *sensor,
                                           mcv_vec3 point, float xi, float eta,
                                           mcv_sensor_ray *sensor_ray) {
    sensor_ray->origin = mcv_vec(mcv_fma(2.0f, xi, -1.0f) * sensor->radius,
                                 mcv_fma(2.0f, eta, -1.0f) * sensor->radius, 0.0f);
    sensor_ray->direction = mcv_vec((point.x - sensor_ray->origin.x) / point.z,
                                    (point.y - sensor_ray->origin.y) / point.z, 1.0f);
    return 4.0f * sensor->radius * sensor->radius;
}

/* The footprint of a macro pixel, divided among its sensor pixels. */
MCV_FUNCTION float mcv_light_field_footprint(MCV_CONSTANT const mcv_light_field *sensor, float z) {
    const float macro =
        sensor->slope_x * sensor->slope_y * (float)(sensor->binning_x * sensor->binning_y);
    return macro * z * z / (float)(sensor->angular_width * sensor->angular_height);
}
#endif

#endif
