/* SPDX-License-Identifier: Apache-2.0 */
/* Which pixels see the surface that the defects of a scene have changed: the truth that a detection
 * is held against. */
#ifndef MCVISI_HOST_REFERENCE_DEFECT_MASK_H
#define MCVISI_HOST_REFERENCE_DEFECT_MASK_H

#include "io/values.h"
#include "scene/scene.h"

/*
 * The share of each pixel, 0 to 1, from which a ray through the middle of the lens meets changed
 * surface, or a defect inside of a body, before anything opaque. It passes through thin sheets and
 * beam splitters, and by refraction or total reflection through glass, rough or not. Reliefs count
 * where they are higher than a hundredth of their depth. MCV_BAD_INPUT for scenes without a defect.
 */
mcv_result ref_defect_mask(const mcv_scene *scene, uint32_t sensor, mcv_image *mask,
                           mcv_error *error);

#endif
