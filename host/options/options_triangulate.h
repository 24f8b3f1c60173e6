/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `mcvisi triangulate`: a part of MCV_OPTIONS (options/options.h). */
#ifndef MCVISI_HOST_OPTIONS_OPTIONS_TRIANGULATE_H
#define MCVISI_HOST_OPTIONS_OPTIONS_TRIANGULATE_H

#define MCV_TRIANGULATE_OPTIONS(X) \
    X(list, profiles, "output", 'o', "FILE", MCV_IN_PROFILES, NULL, 0, 0, \
      "write the profiles: .csv, a row for each place; with --laser also .exr, a range image, " \
      ".npz or .npy, arrays for NumPy, or .ply, points") \
    X(choice, extractor, "extractor", 0, "cog|parabola|logGauss|blaisRioux|gauss|steger", \
      MCV_IN_PROFILES, "cog", 0, 0, \
      "method that finds the line's place: centre of gravity, a parabola or a Gaussian through " \
      "three pixels, Blais and Rioux's zero crossing, the fit of a Gaussian, the top of a ridge") \
    X(count, line_window, "window", 0, "N", MCV_IN_PROFILES, "15", 3, 63, \
      "pixels across the line that cog, gauss and steger use, an odd number; peaks that are " \
      "nearer than half of it count as one") \
    X(number, line_threshold, "threshold", 0, "F", MCV_IN_PROFILES, "0.1", 0, 1, \
      "a pixel belongs to the line if it is brighter than F times the image's brightest pixel") \
    X(choice, line_across, "across", 0, "columns|rows", MCV_IN_PROFILES, "columns", 0, 0, \
      "the line runs across the columns and has a place in each of them, or across the rows") \
    X(text, laser, "laser", 0, "NODE", MCV_IN_PROFILES, NULL, 0, 0, \
      "compute heights: the light lies in the x-z plane of this node, whose pose is in the " \
      "image's header") \
    X(text, frame, "frame", 0, "NODE", MCV_IN_PROFILES, NULL, 0, 0, \
      "coordinates are those of this node, by its pose in each image's header; by default those " \
      "of the laser: x along the line, z towards the laser") \
    X(lengths, feed, "feed", 0, "D", MCV_IN_PROFILES, NULL, -1e3, 1e3, \
      "how far the part moves from image to image along the laser's y [m], or with a unit, " \
      "0.1mm; not with a node of --frame that moves with the part") \
    X(text, calibrate, "calibrate", 0, "F.json", MCV_IN_TRIANGULATE, NULL, 0, 0, \
      "fit the plane of the light to images of a flat target at several places, and write it for " \
      "--calibration; it needs --target") \
    X(text, target, "target", 0, "NODE:AXIS=D", MCV_IN_TRIANGULATE, NULL, 0, 0, \
      "the target's surface: the plane across an axis of this node of each image's header, at D " \
      "from its origin [m], or with a unit, as in plate:z=3mm") \
    X(text, calibration, "calibration", 0, "F.json", MCV_IN_PROFILES, NULL, 0, 0, \
      "compute heights with the plane of the light that --calibrate has found, in place of the " \
      "node's") \
    X(choice, distortion_known, "distortion", 0, "known|ignored", MCV_IN_PROFILES, "known", 0, 0, \
      "whether the evaluation knows the lens's distortion or ignores it")

#endif
