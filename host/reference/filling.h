/* SPDX-License-Identifier: Apache-2.0 */
/* How much of a sensor's pupil, or of a light field camera's directions, an emitter that shines
 * into a cone fills. */
#ifndef MCVISI_HOST_REFERENCE_FILLING_H
#define MCVISI_HOST_REFERENCE_FILLING_H

#include "scene/scene.h"

/*
 * Of the rays of sight of a grid of pixels and places on the aperture that meet the emitter before
 * anything else, so without optics between, the share that its cone lights. Of a light field
 * camera: of the pixels (direction j, k of a macro pixel) with such a ray those with one that is
 * lit.
 */
typedef struct ref_filling {
    uint32_t emitter; /* of the scene */
    double share;     /* 0 … 1 */
} ref_filling;

/*
 * The sensor's fillings, one for each parallel emitter, telecentric projector and light field
 * emitter that it faces; the caller frees them. At most some 10^5 rays, random in a fixed order, so
 * a share below 10^-4 may read 0. Fails only without memory.
 */
mcv_result ref_sensor_fillings(const mcv_scene *scene, uint32_t sensor, ref_filling **fillings,
                               uint32_t *count, mcv_error *error);

#endif
