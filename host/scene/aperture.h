/* SPDX-License-Identifier: Apache-2.0 */
/* Apertures that are no full disc (mcvisi/sensors/aperture.h), in double. */
#ifndef MCVISI_HOST_SCENE_APERTURE_H
#define MCVISI_HOST_SCENE_APERTURE_H

#include "core/json_path.h"
#include "scene/scene.h"

/* The parameters of MCV_APERTURE_PARAMS: those that the shape does not have are NaN or 0. */
typedef struct mcv_aperture_shape {
    int shape; /* MCV_APERTURE_… */
    double ratio, rotation;
    uint32_t blades, order;
    const mcv_mask *mask; /* of the sensor; NULL: none */
} mcv_aperture_shape;

/* Of a sensor; a disc where it has no such parameters. */
mcv_aperture_shape mcv_sensor_aperture(const mcv_sensor *sensor);

/* Fills in defaults of the shape; refuses parameters of other shapes, and orders of a code that are
 * no primes. */
mcv_result mcv_sensor_resolve_aperture(mcv_sensor *sensor, const mcv_json_path *place,
                                       mcv_error *error);

/* Is the cell of a code open? (i, j) from 0, i to the right and j down. */
bool mcv_code_is_open(uint32_t order, uint32_t i, uint32_t j);

/* Are its numbers those of its shape? Those of other shapes may be any. */
bool mcv_aperture_is_valid(const mcv_aperture_shape *shape);

/* Share of the disc that is open. */
double mcv_aperture_open(const mcv_aperture_shape *shape);

/* The length of what is open's border over its area, relative to the disc's 2/r. Of a code about
 * so: a border lies on half of the cells' sides. */
double mcv_aperture_border(const mcv_aperture_shape *shape);

/* For the device; `irradiance`: the open area counts. */
void mcv_aperture_prepare(const mcv_aperture_shape *shape, bool irradiance, mcv_aperture *device);

#define MCV_APERTURE_SHAPE_OF(p) \
    ((mcv_aperture_shape){(p)->aperture, (p)->apertureRatio, (p)->apertureRotation, \
                          (p)->apertureBlades, (p)->apertureOrder, &(p)->apertureMask})

#endif
