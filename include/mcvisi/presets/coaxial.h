/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Coaxial light (type "coaxial"): a half mirror at 45° before the camera and a panel beside it, so
 * that light arrives from the direction of the camera. Its window, `size` wide (x) and high (y), is
 * centred in the node's origin; the light leaves along -z, the camera looks through from +z. The
 * half mirror stands in the origin, turned about x: its edge at +y lies at +z. The panel, of the
 * window's size, stands upright at y = +0.55 of the height. It emits along -y, diffusely or with
 * `halfAngle` into a cone. A black wall of its size at y = -0.55 absorbs what the mirror transmits.
 *
 * The share `reflectance` of the panel's light reaches the part; the share `transmittance` of the
 * light from the part reaches the camera. Neither depends on the angle. A mirror under the light,
 * seen through it, has the radiance reflectance · transmittance · L. `power` is that of the panel.
 *
 * Diffuse light of the panel also leaves the window without meeting the mirror, at angles above
 * about 50° from the axis. Shiny parts do not show it, rough ones do; a halfAngle below 40° avoids
 * it.
 *
 *     {"type": "coaxial", "size": ["50mm", "50mm"], "power": 1}
 */
#ifndef MCVISI_PRESETS_COAXIAL_H
#define MCVISI_PRESETS_COAXIAL_H

#include "mcvisi/presets/preset.h"

#define MCV_COAXIAL_PARAMS(X) \
    X(length2, size, MCV_REQUIRED, MCV_POSITIVE, 1e6, "width and height of the window [m]") \
    X(number, reflectance, 0.5, 0, 1, "share of the light that the half mirror reflects") \
    X(number, transmittance, 0.5, 0, 1, "share of the light that the half mirror transmits") \
    MCV_DIRECTED_PRESET_PARAMS(X)

#endif
