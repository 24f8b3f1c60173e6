/* SPDX-License-Identifier: Apache-2.0 */
/* Camera rays in the world. */
#ifndef MCVISI_KERNELS_SENSOR_RAY_H
#define MCVISI_KERNELS_SENSOR_RAY_H

#include "path/sampler.h"
#include "world.h"
#if MCV_WITH_MIXED
#include "geometry/double.h"
#endif

typedef struct mcv_ray {
    mcv_vec3 origin, direction; /* unit */
} mcv_ray;

/* The directions x, y, z of the optical frame, rows of world coordinates last. */
MCV_FUNCTION mcv_vec3 mcv_to_world(__constant const mcv_frame *frame, mcv_vec3 v) {
    __constant const float *m = frame->to_world;
    return mcv_vec(mcv_fma(m[0], v.x, mcv_fma(m[1], v.y, m[2] * v.z)),
                   mcv_fma(m[3], v.x, mcv_fma(m[4], v.y, m[5] * v.z)),
                   mcv_fma(m[6], v.x, mcv_fma(m[7], v.y, m[8] * v.z)));
}

#if MCV_WITH_LIGHT_TRACING
/* The other way round: the matrix is orthogonal. */
MCV_FUNCTION mcv_vec3 mcv_to_optical(__constant const mcv_frame *frame, mcv_vec3 v) {
    __constant const float *m = frame->to_world;
    return mcv_vec(mcv_fma(m[0], v.x, mcv_fma(m[3], v.y, m[6] * v.z)),
                   mcv_fma(m[1], v.x, mcv_fma(m[4], v.y, m[7] * v.z)),
                   mcv_fma(m[2], v.x, mcv_fma(m[5], v.y, m[8] * v.z)));
}

MCV_FUNCTION mcv_vec3 mcv_point_to_optical(__constant const mcv_frame *frame, mcv_vec3 p) {
    __constant const float *m = frame->to_world;
    return mcv_to_optical(frame, mcv_sub(p, mcv_vec(m[9], m[10], m[11])));
}
#endif

MCV_LOOP_FUNCTION mcv_ray mcv_place_sensor_ray(__constant const mcv_frame *frame,
                                               mcv_sensor_ray sensor_ray) {
    __constant const float *m = frame->to_world;
    mcv_ray ray;
    ray.origin = mcv_add(mcv_to_world(frame, sensor_ray.origin), mcv_vec(m[9], m[10], m[11]));
    ray.direction = mcv_normalize(mcv_to_world(frame, sensor_ray.direction));
    return ray;
}

#if MCV_WITH_MIXED
/* The same in double. */
MCV_LOOP_FUNCTION mcv_dvec mcv_frame_row(__constant const mcv_frame *frame, int row) {
    __constant const float *m = frame->to_world + 3 * row, *low = frame->to_world_low + 3 * row;
    return mcv_whole(mcv_vec(m[0], m[1], m[2]), mcv_vec(low[0], low[1], low[2]));
}

MCV_LOOP_FUNCTION mcv_precise_ray mcv_place_sensor_ray_precisely(__constant const mcv_frame *frame,
                                                                 mcv_sensor_ray sensor_ray) {
    const mcv_dvec x = mcv_frame_row(frame, 0), y = mcv_frame_row(frame, 1),
                   z = mcv_frame_row(frame, 2);
    const mcv_dvec o = mcv_widen(sensor_ray.origin), d = mcv_widen(sensor_ray.direction);
    mcv_precise_ray ray;
    ray.origin = mcv_add_d(mcv_frame_row(frame, 3),
                           mcv_dvec_of(mcv_dot_d(x, o), mcv_dot_d(y, o), mcv_dot_d(z, o)));
    ray.direction = mcv_normalize_d(mcv_dvec_of(mcv_dot_d(x, d), mcv_dot_d(y, d), mcv_dot_d(z, d)));
    return ray;
}
#endif

#if MCV_WITH_PUPIL_GUIDE
/* What each pixel sees through: the disk of the lens or stop, or of a light field camera its own
 * square of the lens. */
#if MCV_SENSOR_light_field
#define MCV_PUPIL_AREA 4.0f
#define MCV_PUPIL_REACH 1.41421356f
#else
#define MCV_PUPIL_AREA MCV_PI
#define MCV_PUPIL_REACH 1.0f
#endif

MCV_LOOP_FUNCTION int mcv_in_pupil(float p_x, float p_y) {
#if MCV_SENSOR_light_field
    return mcv_abs(p_x) <= 1.0f && mcv_abs(p_y) <= 1.0f;
#else
    return mcv_fma(p_x, p_x, p_y * p_y) <= 1.0f;
#endif
}

/*
 * A camera ray of a pixel: half of the samples take the whole pupil, half the ellipse of the
 * pixel's guide; weighed by the balance heuristic, density of the pupil over that of the mixture.
 */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_guided_sensor_ray(mcv_world world, mcv_film_sample film,
                                                       mcv_pair pair) {
    __global const mcv_device_pupil_guide *guide =
        world.pupil_guides + (size_t)film.row * world.frame->width + film.column;
    mcv_sensor_ray sensor_ray;
    float cosine, sine;
    if (!(guide->advantage > 0.0f)) return mcv_sensor_sample(world.sensor, film, pair.x, pair.y);
#if MCV_SENSOR_light_field
    /* The place in the pixel is that on the lens. */
    pair.x = film.x;
    pair.y = film.y;
#endif
    const int guided = pair.x >= 0.5f;
    const float xi = mcv_fma(2.0f, pair.x, guided ? -1.0f : 0.0f);
    const float r = mcv_disk(xi, pair.y, &cosine, &sine);
    const float x = film.x - 0.5f;
    const float y = film.y - 0.5f;
    const float centre_x =
        mcv_fma(guide->shift[0], x, mcv_fma(guide->shift[1], y, guide->centre[0]));
    const float centre_y =
        mcv_fma(guide->shift[2], x, mcv_fma(guide->shift[3], y, guide->centre[1]));
    float p_x = r * cosine;
    float p_y = r * sine;
    float inside = 1.0f;
    if (guided) {
        const float e_x = p_x;
        p_x = mcv_fma(guide->spread[0], e_x, mcv_fma(guide->spread[1], p_y, centre_x));
        p_y = mcv_fma(guide->spread[2], e_x, mcv_fma(guide->spread[3], p_y, centre_y));
    } else {
#if MCV_SENSOR_light_field
        p_x = mcv_fma(2.0f, xi, -1.0f);
        p_y = mcv_fma(2.0f, pair.y, -1.0f);
#endif
        /* |spread⁻¹ (p - centre)| */
        const float d_x = p_x - centre_x;
        const float d_y = p_y - centre_y;
        const float e_x = mcv_difference_of_products(guide->spread[3], d_x, guide->spread[1], d_y) *
                          guide->advantage;
        const float e_y = mcv_difference_of_products(guide->spread[0], d_y, guide->spread[2], d_x) *
                          guide->advantage;
        inside = mcv_fma(e_x, e_x, e_y * e_y) <= 1.0f ? 1.0f : 0.0f;
    }
    sensor_ray = mcv_sensor_through(world.sensor, film, p_x, p_y);
    const float advantage = guide->advantage * (MCV_PUPIL_AREA / MCV_PI);
    sensor_ray.weight = !guided || mcv_in_pupil(p_x, p_y)
                            ? sensor_ray.weight * 2.0f / mcv_fma(inside, advantage, 1.0f)
                            : 0.0f;
    return sensor_ray;
}
#endif

#endif
