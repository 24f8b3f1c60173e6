/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi deflection`: a part of MCV_OPTIONS (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_DEFLECTION_H
#define MCVISI_HOST_OPTIONS_OPTIONS_DEFLECTION_H

#define MCV_DEFLECTION_OPTIONS(X) \
    X(text, deflected, "output", 'o', "F.exr", MCV_IN_DEFLECTION, NULL, 0, 0, \
      "the deflection in x and y, its standard error, the covariance of the directions, and the " \
      "transmitted and lost share") \
    X(text, directions, "histogram", 0, "F.exr", MCV_IN_DEFLECTION, NULL, 0, 0, \
      "also write the histograms of directions: JxK pixels for each place, as of a light field " \
      "camera, which `mcvisi lightfield` takes") \
    X(text, deflected_png, "png", 0, "F.png", MCV_IN_DEFLECTION, NULL, 0, 0, \
      "a picture: hue is the direction of the deflection, strength its size") \
    X(text, undisturbed, "reference", 0, "EMPTY.npz", MCV_IN_DEFLECTION, NULL, 0, 0, \
      "the matrix of the same set-up without the part: deflections are measured from its " \
      "directions, and shares are of its light") \
    X(number, strongest, "scale-end", 0, "V", MCV_IN_DEFLECTION, NULL, 0, 1e30, \
      "the deflection with the strongest colour, to compare pictures; by default 99.5 % of " \
      "the places lie below it")

#endif
