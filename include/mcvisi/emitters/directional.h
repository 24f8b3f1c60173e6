/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Directional light (type "directional", and KHR_lights_punctual): parallel rays along its node's
 * -z from infinitely far away, with the irradiance E on a plane across them, everywhere. The node's
 * position has no effect. A beam with an edge is the collimated beam.
 *
 * Only next-event estimation and light paths find it: it is invisible to cameras and in mirrors.
 *
 *     {"type": "directional", "irradiance": 10}
 *
 * KHR_lights_punctual gives lux: W/m² = lx/683.
 *
 * Emission: a point uniform on the disks, across the axis, onto which bounding balls of smooth
 * bodies project. A point on n of them has the density n/Σ πR². The direction is the axis; the path
 * carries E over that density.
 */
#ifndef MCVISI_EMITTERS_DIRECTIONAL_H
#define MCVISI_EMITTERS_DIRECTIONAL_H

#include "mcvisi/emitters/emitter.h"

#define MCV_DIRECTIONAL_PARAMS(X) \
    X(spectrum, irradiance, MCV_REQUIRED, 0, 1e30, \
      "irradiance E on a plane across the light [W/m²]")

typedef struct mcv_directional {
    float axis[3]; /* unit; direction of emission */
    float reach;   /* larger than the distance between any two points of surfaces [m] */
} mcv_directional;
MCV_ASSERT_SIZE(mcv_directional, 16);

#endif
