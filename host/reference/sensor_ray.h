/* SPDX-License-Identifier: Apache-2.0 */
/* Camera rays of the sensors, from the report's equations (4.1), (4.2) and section 4.2. */
#ifndef MCVISI_HOST_REFERENCE_SENSOR_RAY_H
#define MCVISI_HOST_REFERENCE_SENSOR_RAY_H

#include "reference/random.h"
#include "reference/vector.h"
#include "scene/scene.h"

typedef struct ref_sensor_ray {
    ref_vec origin, direction; /* world; the direction is unit */
    double weight; /* radiance: 1 or, where the lens blocks, 0; irradiance: A cos⁴θ/h² [sr] */
    double time;   /* [s] */
} ref_sensor_ray;

/*
 * Pixel (column, row) from the top-left corner, the position (x, y) in it and the aperture sample
 * (u, v), all in [0, 1). (u, v) = (0, 0) is the centre of a round aperture. A light field camera
 * uses (u, v) only to choose one of the binned macro pixels.
 */
ref_sensor_ray ref_sensor_ray_sample(const mcv_sensor *sensor, uint32_t column, uint32_t row,
                                     double x, double y, double u, double v);

/* The same at a moment of the row's exposure, chosen by (ξ, η) in [0, 1): the time, and the stage
 * of a TDI sensor (mcvisi/motion.h). */
ref_sensor_ray ref_sensor_ray_at(const mcv_sensor *sensor, uint32_t column, uint32_t row, double x,
                                 double y, double u, double v, double xi, double eta);

/* A ray for (x, y, u, v) = place. Of a sensor for which the time matters, (ξ, η) are drawn. */
ref_sensor_ray ref_sensor_ray_draw(const mcv_scene *scene, const mcv_sensor *sensor,
                                   uint32_t column, uint32_t row, const double place[4],
                                   ref_random *random);

#endif
