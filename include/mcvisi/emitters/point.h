/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Point light (type "point", and KHR_lights_punctual): the same radiant intensity I from its node's
 * origin in all directions, Φ = 4π I (per channel). A surface at distance r, turned towards it, has
 * the irradiance I/r²; where a `range` R is given that times max(0, 1 - (r/R)⁴), as the extension
 * recommends.
 *
 * It is smaller than any ray: surfaces look for it, cameras and mirrors do not see it.
 *
 *     {"type": "point", "intensity": 0.5}
 *
 * KHR_lights_punctual gives candela: W/sr = cd/683, which undoes what Blender's exporter does to
 * its watts.
 *
 * On the device it is a spot light that shines everywhere.
 */
#ifndef MCVISI_EMITTERS_POINT_H
#define MCVISI_EMITTERS_POINT_H

#include "mcvisi/emitters/emitter.h"

#define MCV_POINT_PARAMS(X) MCV_INTENSITY_PARAMS(X)

#endif
