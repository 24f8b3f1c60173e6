/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Directional light (type "directional", and KHR_lights_punctual): parallel rays along its node's
 * -z from infinitely far away, with the irradiance E on a plane across them, everywhere. The node's
 * place has no meaning. A beam with an edge is the collimated beam.
 *
 * Surfaces look for it, cameras and mirrors do not see it.
 *
 *     {"type": "directional", "irradiance": 10}
 *
 * KHR_lights_punctual gives lux: W/m² = lx/683.
 *
 * From the emitter's side: a place uniform on the disks across the axis that balls around smooth
 * bodies throw (one that lies on n of them has the density n/Σ πR²), the direction the axis,
 * carrying E over that density.
 */
#ifndef MCVISI_EMITTERS_DIRECTIONAL_H
#define MCVISI_EMITTERS_DIRECTIONAL_H

#include "mcvisi/emitters/emitter.h"

#define MCV_DIRECTIONAL_PARAMS(X) \
    X(spectrum, irradiance, MCV_REQUIRED, 0, 1e30, \
      "irradiance E on a plane across the light [W/m²]")

typedef struct mcv_directional {
    float axis[3]; /* unit; in which it shines */
    float reach;   /* from any surface no other is as far away [m] */
} mcv_directional;
MCV_ASSERT_SIZE(mcv_directional, 16);

#endif
