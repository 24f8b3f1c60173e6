/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi scan` that no other verb has: a part of MCV_OPTIONS (options/options.h).
 */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_SCAN_H
#define MCVISI_HOST_OPTIONS_OPTIONS_SCAN_H

#define MCV_SCAN_OPTIONS(X) \
    X(count, profile_count, "profiles", 0, "N", MCV_IN_SCAN, "1", 1, 100000, "number of profiles") \
    X(choice, scan_speckle, "speckle", 0, "on|off", MCV_IN_SCAN, "on", 0, 0, \
      "speckle, which belongs to the part and moves with it") \
    X(lengths, filter, "filter", 0, "L", MCV_IN_SCAN, NULL, 0, 1e-3, \
      "a bandpass filter in front of the lens: the centre of its band at normal incidence [m], " \
      "or with a unit, 660nm; it needs --filter-width") \
    X(lengths, filter_width, "filter-width", 0, "W", MCV_IN_SCAN, NULL, 0, 1e-3, \
      "width of the filter's band at half of its maximum [m], or with a unit, 20nm") \
    X(number, filter_index, "filter-index", 0, "N", MCV_IN_SCAN, "1.8", 0, 10, \
      "effective index of the filter's layers: it shifts the band of oblique light to the blue, " \
      "and a low index shifts it more") \
    X(text, raw_images, "images", 0, "PREFIX", MCV_IN_SCAN, NULL, 0, 0, \
      "also write the grey values of each profile: PREFIX0000.exr, PREFIX0001.exr …, with the " \
      "rows that the line can reach") \
    X(flag, budget, "budget", 0, NULL, MCV_IN_SCAN, NULL, 0, 0, \
      "state what each cause contributes to the error of the heights, by a separate run, and " \
      "compare the sum with the error by all of them together") \
    X(number, profile_rate, "profile-rate", 0, "F", MCV_IN_SCAN, NULL, 0, 1e9, \
      "profiles per second: the part moves by --feed times F, and its speckle is fainter by the " \
      "way " \
      "that its image goes during --exposure-time") \
    X(text, pose, "pose", 0, "D,A", MCV_IN_SCAN, NULL, 0, 0, \
      "standard uncertainties of the camera's place along each of its axes and of its turn about " \
      "each, against the laser, as in 10um,0.005deg: --budget states their effect on heights")

#endif
