/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Point light (type "point", and KHR_lights_punctual): the radiant intensity I, from its node's
 * origin, in all directions; Φ = 4π I (per channel). A surface at distance r that faces it has the
 * irradiance I/r². With a `range` R this is multiplied by max(0, 1 - (r/R)⁴), as the extension
 * recommends.
 *
 * Only next-event estimation and light paths find it: it is invisible to cameras and in mirrors.
 *
 *     {"type": "point", "intensity": 0.5}
 *
 * KHR_lights_punctual gives candela: W/sr = cd/683. This undoes the conversion of Blender's
 * exporter from watts.
 */
#ifndef MCVISI_EMITTERS_POINT_H
#define MCVISI_EMITTERS_POINT_H

#include "mcvisi/emitters/emitter.h"

#define MCV_POINT_PARAMS(X) MCV_INTENSITY_PARAMS(X)

typedef struct mcv_point {
    uint nothing; /* C does not allow empty structs */
} mcv_point;

MCV_LOOP_FUNCTION float mcv_point_profile(MCV_GLOBAL const mcv_point *light, float edge, float q) {
    (void)light, (void)edge, (void)q;
    return 1.0f;
}

#endif
