/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi lightfield`: a part of MCV_OPTIONS (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_LIGHTFIELD_H
#define MCVISI_HOST_OPTIONS_OPTIONS_LIGHTFIELD_H

#define MCV_LIGHTFIELD_OPTIONS(X) \
    X(text, processed, "output", 'o', "F.png|F.exr", MCV_IN_LIGHTFIELD, NULL, 0, 0, \
      "the file to write: a picture, or the values as OpenEXR; views keep their colours, the " \
      "gradient has pseudo-colours") \
    X(text, picture, "png", 0, "F.png", MCV_IN_LIGHTFIELD, NULL, 0, 0, \
      "the picture beside an OpenEXR output") \
    X(text, ratio, "ratio", 0, "F.png", MCV_IN_LIGHTFIELD, NULL, 0, 0, \
      "for emd-gradient: also a picture of the gradient over its noise floor, of an image that " \
      "states its standard errors") \
    X(choice, form, "form", 0, "normalized|mass", MCV_IN_LIGHTFIELD | MCV_IN_EXPERIMENTS, \
      "normalized", 0, 0, \
      "for emd-gradient: normalized, macro pixels of mass 1, which show deflection only; or " \
      "mass, macro pixels with their brightness, which show absorption too") \
    X(number, scale_end, "scale-end", 0, "V", MCV_IN_LIGHTFIELD, NULL, 0, 1e30, \
      "for emd-gradient: the value with the last colour, to compare pictures; by default 99.5 " \
      "% of the macro pixels lie below it") \
    X(size, angular, "angular", 0, "JxK", MCV_IN_LIGHTFIELD, NULL, 1, 256, \
      "pixels of a macro pixel, for images whose header does not state it")

#endif
