/* SPDX-License-Identifier: Apache-2.0 */
/*
 * LED panel (type "ledPanel"): the example of "An emitter with a surface" in
 * docs/adding-an-element.md.
 *
 * Bars and panels of LEDs with lenses light a part more directedly than an even (Lambertian) panel
 * does. From afar their radiant intensity falls as cos^n θ with the angle θ from the normal, and is
 * one half of the greatest at the half-power angle θ_h of their data sheet. The radiance is the
 * intensity over the area that is seen, A cosθ:
 *
 *     L cos^(n-1) θ        n = -ln 2/ln cosθ_h        exitance M = 2π L/(n + 1)
 *
 * θ_h = 60° is the even panel, n = 1; 30° is n = 4.8. L is the radiance along the normal. Single
 * LEDs are not resolved. Source: I. Moreno and C.-C. Sun, Optics Express 16 (2008) 1808-1819. The
 * panel is the rectangle that `size` spans, or its node's mesh.
 *
 *     {"type": "ledPanel", "size": ["200mm", "50mm"], "power": 4, "halfPowerAngle": "30deg"}
 */
#ifndef MCVISI_EMITTERS_LED_PANEL_H
#define MCVISI_EMITTERS_LED_PANEL_H

#include "mcvisi/elementary.h"
#include "mcvisi/emitters/emitter.h"

/* X(kind, key, default, min, max, "doc [unit]"): parser, ranges, units, --set, check, help and
 * schema follow (mcvisi/params.h). MCV_RADIANCE_PARAMS has radiance, power and size. */
#define MCV_LED_PANEL_PARAMS(X) \
    X(angle, halfPowerAngle, MCV_REQUIRED, 0.017453292519943295, 1.0471975511965976, \
      "angle θ_h from the normal at which the intensity is half of the greatest [rad]") \
    MCV_RADIANCE_PARAMS(X)

/* What the device needs: words of 4 bytes, at most 3. */
typedef struct mcv_led_panel {
    float exponent; /* n - 1 */
} mcv_led_panel;

/* The radiance, over L, at an angle of the given cosine; nothing comes from behind. Host and device
 * compile it; a loop over paths calls it, so it has no branches. */
MCV_LOOP_FUNCTION float mcv_led_panel_profile(MCV_GLOBAL const mcv_led_panel *light, float cosine) {
    return mcv_cosine_power(cosine, light->exponent);
}

#endif
