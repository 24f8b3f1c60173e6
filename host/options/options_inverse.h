/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi inverse-pattern`: a part of MCV_OPTIONS (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_INVERSE_H
#define MCVISI_HOST_OPTIONS_OPTIONS_INVERSE_H

#define MCV_INVERSE_OPTIONS(X) \
    X(text, inverse, "output", 'o', "F.exr", MCV_IN_INVERSE, NULL, 0, 0, \
      "the pattern, which the emitter takes as its image; its second part is its standard error") \
    X(text, inverse_png, "png", 0, "F.png", MCV_IN_INVERSE, NULL, 0, 0, \
      "a preview of the pattern") \
    X(text, emitter, "emitter", 0, "NAME", MCV_IN_INVERSE, NULL, 0, 0, \
      "the emitter that shows it; by default the only one with pixels") \
    X(choice, method, "method", 0, "replay|least-squares", MCV_IN_INVERSE, "replay", 0, 0, \
      "replay, the light that would come back from the camera; or least-squares, the pattern of " \
      "0 " \
      "and more whose image is most even") \
    X(number, damping, "damping", 0, "F", MCV_IN_INVERSE, "0.01", 0, 1e6, \
      "for least-squares: the weight of the pattern's own squares, which bounds it where few " \
      "rays " \
      "tell of it") \
    X(choice, field, "field", 0, "bright|dark", MCV_IN_INVERSE, "bright", 0, 0, \
      "bright, the flawless part is even and defects are dark; or dark, the complement: light " \
      "that reaches no pixel through a flawless part, so that defects are bright") \
    X(count, pattern_bits, "bits", 0, "B", MCV_IN_INVERSE, "8", 0, 16, \
      "round the pattern to so many bits; 0: not at all") \
    X(text, good, "good", 0, "F.npz", MCV_IN_INVERSE, NULL, 0, 0, \
      "a matrix of the flawless part with another seed, for its image; by default MATRIX itself, " \
      "whose noise the pattern knows") \
    X(text, good_image, "good-image", 0, "F.exr", MCV_IN_INVERSE, NULL, 0, 0, \
      "the image of the flawless part under the pattern") \
    X(text, bad, "defect", 0, "F.npz", MCV_IN_INVERSE, NULL, 0, 0, \
      "the matrix of the part with a defect, of the same set-up") \
    X(text, bad_image, "defect-image", 0, "F.exr", MCV_IN_INVERSE, NULL, 0, 0, \
      "the image of the part with the defect under the pattern")

#endif
