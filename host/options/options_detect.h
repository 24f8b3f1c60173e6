/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi detect`: a part of MCV_OPTIONS (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_DETECT_H
#define MCVISI_HOST_OPTIONS_OPTIONS_DETECT_H

#define MCV_DETECT_OPTIONS(X) \
    X(text, within, "within", 0, "X,Y,W,H|FILE", MCV_IN_DETECT, NULL, 0, 0, \
      "the pixels that count: a rectangle from the top-left corner, a polygon X,Y,X,Y,…, or an " \
      "image whose pixels above 0 count; by default all") \
    X(number, visible, "visible", 0, "K", MCV_IN_DETECT, "3", 0, 1e6, \
      "a pixel shows the defect where its difference is at least K deviations of the noise") \
    X(text, step, "step", 0, "STEP", MCV_IN_DETECT, NULL, 0, 0, \
      "by how much a parameter of the scene differs between the pictures, as in 1mm or 0.5deg: " \
      "tells how well any method can know it from one exposure") \
    X(text, mask, "output", 'o', "F.png", MCV_IN_DETECT, NULL, 0, 0, \
      "write which pixels show the defect: 255, the others 0; .png, .tif or .npy") \
    X(text, marred_rig, "rig", 0, "RIG.gltf", MCV_IN_DETECT, NULL, 0, 0, \
      "the rig of WITH.exr: tells which pixels see its defects, also through glass, and how " \
      "many of these show them") \
    X(text, detected, "html", 0, "F.html", MCV_IN_DETECT, NULL, 0, 0, \
      "also write a page: the answer, both pictures and their difference, with --rig the set-up " \
      "from the side, and what was assumed") \
    X(text, truth, "truth", 0, "F.png", MCV_IN_DETECT, NULL, 0, 0, \
      "with --rig: write the share of each pixel that sees a defect, 255 for all; .png, " \
      ".tif or .npy")

#endif
