/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi deflectometry`: a part of MCV_OPTIONS (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_DEFLECTOMETRY_H
#define MCVISI_HOST_OPTIONS_OPTIONS_DEFLECTOMETRY_H

#define MCV_DEFLECTOMETRY_OPTIONS(X) \
    X(text, shape, "output", 'o', "F.exr", MCV_IN_DEFLECTOMETRY, NULL, 0, 0, \
      "the heights [m]; further parts are their standard uncertainty, slopes, places on the " \
      "screen and modulation") \
    X(text, shape_png, "png", 0, "F.png", MCV_IN_DEFLECTOMETRY, NULL, 0, 0, \
      "a picture of the heights") \
    X(text, slope_png, "slope-png", 0, "F.png", MCV_IN_DEFLECTOMETRY, NULL, 0, 0, \
      "a picture of the slopes: hue is the direction, saturation the size") \
    X(text, plane, "plane", 0, "NODE", MCV_IN_DEFLECTOMETRY, NULL, 0, 0, \
      "the part lies near the x-y plane of this node; heights are along its z") \
    X(text, screen, "screen", 0, "NAME", MCV_IN_DEFLECTOMETRY, NULL, 0, 0, \
      "the screen, where the scene has several") \
    X(choice, unwrap, "unwrap", 0, "heterodyne|gray", MCV_IN_DEFLECTOMETRY, "heterodyne", 0, 0, \
      "how periods are told apart: by fringes of one period less, or by a Gray code") \
    X(number, fringe_noise, "noise", 0, "S", MCV_IN_DEFLECTOMETRY, NULL, 0, 1e30, \
      "standard deviation of the camera's noise, in the unit of the image; by default only the " \
      "render has noise") \
    X(choice, removed_form, "remove-form", 0, "none|plane|quadric", MCV_IN_DEFLECTOMETRY, "none", \
      0, 0, \
      "subtract the best-fit plane, or the best-fit surface of second order, from heights and " \
      "slopes, so that waviness and defects remain") \
    X(flag, flat_screen, "flat-screen", 0, NULL, MCV_IN_DEFLECTOMETRY, NULL, 0, 0, \
      "evaluate as if the screen were flat, whatever its sag, to see the error by an unknown sag")

#endif
