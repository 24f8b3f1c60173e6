/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi transport`, `mcvisi relight` and `mcvisi explain`: a part of MCV_OPTIONS
 * (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_TRANSPORT_H
#define MCVISI_HOST_OPTIONS_OPTIONS_TRANSPORT_H

#define MCV_TRANSPORT_OPTIONS(X) \
    X(text, matrix, "output", 'o', "F.npz|F.mtx", MCV_IN_TRANSPORT, NULL, 0, 0, \
      "the matrix: .npz for Python (scipy.sparse.load_npz) and `mcvisi relight`, .mtx for " \
      "MATLAB; by default the name of the scene with .npz") \
    X(text, white, "white", 0, "F.exr", MCV_IN_TRANSPORT, NULL, 0, 0, \
      "also write the image of a white pattern, the sums of the matrix's rows") \
    X(choice, elements, "elements", 0, "pixels|lamps", MCV_IN_TRANSPORT, "pixels", 0, 0, \
      "columns of the matrix: pixels, each pixel of an emitter's image that is not interpolated, " \
      "and other emitters as a whole; lamps, all emitters as a whole") \
    X(count, element_bin, "bin", 0, "N", MCV_IN_TRANSPORT, "1", 1, 65536, \
      "combine squares of N x N pixels (of a light field: directions) into one column; patterns " \
      "then have one pixel per square") \
    X(number, keep, "keep", 0, "F", MCV_IN_TRANSPORT, "1", 0, 1, \
      "keep the strongest entries of each row that make up this share of its sum; the others " \
      "become one entry in an additional column") \
    X(text, relit, "output", 'o', "F.exr", MCV_IN_RELIGHT, NULL, 0, 0, \
      "the image; its second part is the standard error") \
    X(text, relit_png, "png", 0, "F.png", MCV_IN_RELIGHT, NULL, 0, 0, "a preview of the image") \
    X(list, patterns, "pattern", 0, "[EMITTER=]F.exr", MCV_IN_RELIGHT, NULL, 0, 0, \
      "the image that an emitter shows: .exr or .npy with linear values, or .png with 8 bits " \
      "as a scene reads it; by default that of the scene; the emitter may be left out where " \
      "only one has pixels; may be repeated for other emitters") \
    X(text, sequence, "sequence", 0, "[EMITTER=]PATTERN", MCV_IN_RELIGHT, NULL, 0, 0, \
      "make the images of a sequence of patterns, which the emitter shows one after the other: a " \
      "pattern as in scenes, such as '{\"type\": \"phaseShift\", \"steps\": 4, \"periods\": " \
      "16}'; " \
      "the files get numbers, as in F-0.exr") \
    X(choice, fit, "fit", 0, "none|uniform|contrast", MCV_IN_RELIGHT, "none", 0, 0, \
      "find the weights of the emitters, 0 or more: uniform, for the most even region; contrast, " \
      "for the largest contrast to noise of the region against the background") \
    X(text, lit_region, "region", 0, "X,Y,W,H", MCV_IN_RELIGHT | MCV_IN_INVERSE, NULL, 0, 0, \
      "region of the image, in pixels from the top-left corner: a rectangle, a polygon " \
      "X,Y,X,Y,X,Y,… or an image F.png, whose pixels above 0 belong to it; for --fit, by " \
      "default the whole image; it is measured, too") \
    X(text, lit_background, "background", 0, "X,Y,W,H", MCV_IN_RELIGHT | MCV_IN_INVERSE, NULL, 0, \
      0, "region to compare --region with") \
    X(text, pixel, "pixel", 0, "X,Y", MCV_IN_EXPLAIN, NULL, 0, 0, \
      "column and row of the pixel, from 0,0 in the top left corner") \
    X(count, pixel_samples, "spp", 0, "N", MCV_IN_EXPLAIN, "16384", 16, 1ull << 32, \
      "trace N paths of the pixel") \
    X(count, routes, "routes", 0, "N", MCV_IN_EXPLAIN, "10", 1, 1000, \
      "list the N routes that contribute most") \
    X(text, explained, "html", 0, "F.html", MCV_IN_EXPLAIN, NULL, 0, 0, \
      "also write a page with the routes, and their strongest paths drawn in the set-up") \
    X(text, explained_svg, "svg", 0, "F.svg", MCV_IN_EXPLAIN, NULL, 0, 0, \
      "also draw the strongest path of each route in the set-up, from the side")

#endif
