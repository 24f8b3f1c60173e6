/* SPDX-License-Identifier: Apache-2.0 */
/* The part of a laser's picture that tells which places of surfaces the pixels see, so that speckle
 * moves with them (analysis/surface_noise.h). */
#ifndef MCVISI_HOST_VERBS_SURFACE_PART_H
#define MCVISI_HOST_VERBS_SURFACE_PART_H

#include "io/exr.h"
#include "reference/geometry.h"

/* Adds it to a picture of this sensor, which has q x q of its pixels for each of the image. */
mcv_result mcv_surface_part_add(const ref_geometry *geometry, const mcv_sensor *sensor, uint32_t q,
                                mcv_exr *laser, mcv_error *error);

/* The same for a scene at rest. */
mcv_result mcv_surface_part_of(const mcv_scene *scene, uint32_t sensor, uint32_t q, mcv_exr *laser,
                               mcv_error *error);

#endif
