/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Coaxial light (type "coaxial"): a half mirror at 45° in the camera's view and a panel beside it,
 * so that light comes from where the camera looks from. Its window, `size` wide (x) and high (y),
 * lies about the node's origin; the light leaves along -z, the camera looks through from +z. The
 * half mirror stands in the origin, turned about x: its edge at +y lies at +z. The panel, of the
 * window's size, stands upright at y = +0.55 of the height and shines along -y, diffusely or with
 * `halfAngle` into a cone; a black wall of its size at y = -0.55 takes what passes the mirror.
 *
 * Of the panel's light the share `reflectance` reaches the part, and `transmittance` of what the
 * part sends back the camera; whatever the angle. A mirror under it, seen through it, has the
 * radiance reflectance · transmittance · L. `power` is that of the panel. Diffuse light of the
 * panel also falls through the window without the mirror, at slants beyond some 50° from the axis:
 * on shiny parts it does not show, on rough ones it does; a halfAngle below 40° keeps it off.
 *
 *     {"type": "coaxial", "size": ["50mm", "50mm"], "power": 1}
 */
#ifndef MCVISI_PRESETS_COAXIAL_H
#define MCVISI_PRESETS_COAXIAL_H

#include "mcvisi/presets/preset.h"

#define MCV_COAXIAL_PARAMS(X) \
    X(length2, size, MCV_REQUIRED, MCV_POSITIVE, 1e6, "width and height of the window [m]") \
    X(number, reflectance, 0.5, 0, 1, "share of the light that the half mirror reflects") \
    X(number, transmittance, 0.5, 0, 1, "share of the light that the half mirror passes") \
    MCV_DIRECTED_PRESET_PARAMS(X)

#endif
