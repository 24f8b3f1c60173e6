/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ring light (type "ring"): a band about the node's z axis through which the camera looks. With
 * tilt 0 it is the flat annulus between the two diameters, facing -z. `tilt` turns the band about
 * its middle circle, the inner edge back and the outer one forward. At 90° it faces the axis (a
 * low-angle ring for dark fields); a negative tilt turns it away from the axis. Its area stays π/4
 * (D_o² - D_i²).
 *
 * A flat diffuse ring lights a point on the axis at distance h, on a plane that faces it, with E =
 * π L (R_o²/(R_o² + h²) - R_i²/(R_i² + h²)). With `halfAngle` each point emits into a cone about
 * the band's normal, as LEDs with lenses do. The circles are polygons of 128 sides with the
 * circles' area.
 *
 *     {"type": "ring", "innerDiameter": "40mm", "outerDiameter": "70mm", "tilt": "30deg",
 *      "power": 2}
 */
#ifndef MCVISI_PRESETS_RING_H
#define MCVISI_PRESETS_RING_H

#include "mcvisi/presets/preset.h"

#define MCV_RING_PARAMS(X) \
    X(length, innerDiameter, MCV_REQUIRED, MCV_POSITIVE, 1e6, \
      "inner diameter D_i of the flat ring [m]") \
    X(length, outerDiameter, MCV_REQUIRED, MCV_POSITIVE, 1e6, \
      "outer diameter D_o of the flat ring [m]") \
    X(angle, tilt, 0, -1.5707963267948966, 1.5707963267948966, \
      "angle of the band towards the axis [rad]") \
    MCV_DIRECTED_PRESET_PARAMS(X)

#endif
