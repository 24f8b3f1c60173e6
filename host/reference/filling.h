/* SPDX-License-Identifier: Apache-2.0 */
/* The share of a sensor's pupil, or of a light field camera's directions, that an emitter with a
 * cone fills. */
#ifndef MCVISI_HOST_REFERENCE_FILLING_H
#define MCVISI_HOST_REFERENCE_FILLING_H

#include "scene/scene.h"

/*
 * Camera rays from a grid of pixels and aperture points that hit the emitter first, without optics
 * between; `share` is the share of them that its cone lights. For a light field camera: of the
 * pixels (direction j, k of a macro pixel) with such a ray, the share with a lit one.
 */
typedef struct ref_filling {
    uint32_t emitter; /* of the scene */
    double share;     /* 0 … 1 */
} ref_filling;

/*
 * The sensor's fillings, one for each parallel emitter, telecentric projector and light field
 * emitter that faces it; the caller frees them. It uses some 10^5 rays, random in a fixed order, so
 * a share below 10^-4 may be 0. Fails only without memory.
 */
mcv_result ref_sensor_fillings(const mcv_scene *scene, uint32_t sensor, ref_filling **fillings,
                               uint32_t *count, mcv_error *error);

#endif
