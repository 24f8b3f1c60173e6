/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Dome light (type "dome"): a hemisphere of diameter D about the node's origin, open towards -z,
 * with a hole of diameter d at its top (+z) for the camera. Its inside has the radiance L
 * everywhere and in all directions, and absorbs what falls on it. This is the ideal of a white dome
 * lit from its rim; L includes that dome's own interreflections. Light from the part that the dome
 * would reflect is left out; it is little if the part is small or dark.
 *
 * In the centre of the opening a plane that faces the dome has the irradiance E = π L (1 - d²/D²).
 * The inside's area is π D √(D² - d²)/2. Its circles are polygons of 128 sides with the circles'
 * area.
 *
 *     {"type": "dome", "diameter": "120mm", "holeDiameter": "20mm", "radiance": 10}
 */
#ifndef MCVISI_PRESETS_DOME_H
#define MCVISI_PRESETS_DOME_H

#include "mcvisi/presets/preset.h"

#define MCV_DOME_PARAMS(X) \
    X(length, diameter, MCV_REQUIRED, MCV_POSITIVE, 1e6, "diameter D of the dome [m]") \
    X(length, holeDiameter, MCV_REQUIRED, MCV_POSITIVE, 1e6, \
      "diameter d of the hole for the camera [m]") \
    MCV_PRESET_PARAMS(X)

#endif
