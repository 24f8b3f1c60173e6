/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Screen (type "screen"): a monitor of W x H pixels, as deflectometry shows fringes on it. Pixels
 * have the distance p (`pixelPitch`) and a dark gap g (`pixelGap`) between them. A pixel whose
 * value is v has the radiance
 *
 *     L v^γ cos^n θ        θ: angle from the normal        exitance 2π L v^γ/(n + 2)
 *
 * within its lit part, the share (1 - g_x/p_x) (1 - g_y/p_y) of its area. L is `radiance`. γ
 * (`gamma`) is 1 for a screen whose response is linear. A measured screen has an error of some
 * percent there, which bends the phase of fringes. n (`falloffExponent`) is 0 for an even screen, 1
 * to 4 for common panels.
 *
 * Source of the fall-off: M. Born, E. Wolf, Principles of Optics, 4.8.1 (Lambert's law is n = 0).
 *
 * W x H are the pixels of `image`, or the `resolution` of `pattern`. A pixel is uniform, nothing is
 * interpolated. Who faces the screen with the node's y up sees row 0 on top and column 0 at left:
 * column 0 lies at the node's +x, and light leaves along -z.
 *
 * No screen is flat. With ξ and η from -1 to 1 across its width and height a point rises towards
 * the side that emits by
 *
 *     s = s_x ξ² + s_y η² + t ξη + q_x ξ⁴ + q_y η⁴
 *
 * `sag` is s_x, s_y, `twist` is t, `fourth` is q_x, q_y. The surface is then a mesh of 64 x 64
 * cells: from the polynomial it differs by at most (s/4 + 3 q/2)/64² of each direction.
 *
 *     {"type": "screen", "pattern": {"type": "phaseShift", "steps": 8, "periods": 16,
 *      "resolution": [1280, 800]}, "pixelPitch": "0.25mm", "radiance": 100}
 */
#ifndef MCVISI_EMITTERS_SCREEN_H
#define MCVISI_EMITTERS_SCREEN_H

#include "mcvisi/elementary.h"
#include "mcvisi/emitters/emitter.h"

#define MCV_SCREEN_PARAMS(X) \
    MCV_PICTURE_PARAMS(X) \
    X(length2, pixelPitch, MCV_REQUIRED, MCV_POSITIVE, 1, \
      "distance of neighbouring pixels in x and y [m]") \
    X(length2, pixelGap, 0, 0, 1, "dark gap between neighbouring pixels in x and y [m]") \
    X(spectrum, radiance, MCV_UNSET, 0, 1e30, \
      "radiance L of the image's value 1 along the normal, within a pixel [W/(m² sr)]") \
    X(spectrum, power, MCV_UNSET, 0, 1e30, "power of the whole screen, in place of radiance [W]") \
    X(number, gamma, 1, 0.1, 10, "exponent γ from the image's value to the share of L") \
    X(number, falloffExponent, 0, 0, 100, "exponent n of the fall-off with the angle, cos^n θ") \
    X(length2, sag, 0, -1, 1, \
      "rise of the middles of the edges over the screen's middle, as the square [m]") \
    X(length, twist, 0, -1, 1, "rise of two opposite corners, and fall of the others [m]") \
    X(length2, fourth, 0, -1, 1, \
      "rise of the middles of the edges over the screen's middle, as the fourth power [m]")

typedef struct mcv_screen {
    float exponent; /* n */
    uint columns, rows;
    float lit[2]; /* share of a pixel's width and height that is lit */
} mcv_screen;

/* The radiance, over L, at an angle of the given cosine. Scenes that do not need the feature SCREEN
 * have no such emitter on the device. */
MCV_LOOP_FUNCTION float mcv_screen_profile(MCV_GLOBAL const mcv_screen *screen, float cosine) {
#if !MCV_ON_DEVICE || MCV_WITH_SCREEN
    return mcv_cosine_power(cosine, screen->exponent);
#else
    (void)screen, (void)cosine;
    return 0.0f;
#endif
}

#if !MCV_ON_DEVICE || MCV_WITH_SCREEN
/* 1 within the lit part of a pixel, 0 in a gap; (u, v): place on the screen in its width and
 * height, from the corner of pixel (0, 0). */
MCV_LOOP_FUNCTION float mcv_screen_lit(MCV_GLOBAL const mcv_screen *screen, float u, float v) {
    const float x = u * (float)screen->columns;
    const float y = v * (float)screen->rows;
    const float across = mcv_abs(x - mcv_floor(x) - 0.5f);
    const float down = mcv_abs(y - mcv_floor(y) - 0.5f);
    const int lit = (across <= 0.5f * screen->lit[0]) & (down <= 0.5f * screen->lit[1]);
    return lit ? 1.0f : 0.0f;
}
#endif

#endif
