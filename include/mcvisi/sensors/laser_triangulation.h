/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Laser triangulation head (type "laserTriangulation"): a thin lens camera, most often with a
 * tilted film, that looks at a laser's line from the side. `render` gives its raw image, that of
 * the thin lens. `mcvisi scan` moves the head over the part and finds profiles of heights; the keys
 * beside those of the thin lens are its options, with the same names, which the command line
 * overrides.
 *
 *     {"type": "laserTriangulation", "focalLength": "16mm", "focusDistance": "150mm",
 *      "fNumber": 5.6, "tilt": "11deg", "resolution": [1280, 256], "pixelSize": "5um",
 *      "radiometry": "irradiance", "laser": "laser", "frame": "part", "feed": "0.1mm",
 *      "profiles": 100, "exposeTo": 0.8}
 */
#ifndef MCVISI_SENSORS_LASER_TRIANGULATION_H
#define MCVISI_SENSORS_LASER_TRIANGULATION_H

#include "mcvisi/sensors/thin_lens.h"

/* Its parameters beside those of a thin lens, as which it is rendered: options of scan, filterWidth
 * being --filter-width there. */
#define MCV_HEAD_PARAMS(X) \
    X(text, laser, MCV_UNSET, 0, 0, \
      "the laser's node, whose x-z plane the light lies in; by default \"laser\"") \
    X(text, frame, MCV_UNSET, 0, 0, \
      "coordinates are those of this node; by default those of the laser") \
    X(length, feed, MCV_UNSET, -1e3, 1e3, \
      "how far the part moves from profile to profile along the laser's y [m]") \
    X(integer, profiles, MCV_UNSET, 1, 100000, "number of profiles of a scan; by default 1") \
    X(number, profileRate, MCV_UNSET, MCV_POSITIVE, 1e9, \
      "profiles per second: the part moves during an exposure [Hz]") \
    X(number, exposeTo, MCV_UNSET, MCV_POSITIVE, 1000, \
      "exposure by which bright parts of the first profile reach this share of the full well, in " \
      "place of exposureTime") \
    X(length, filter, MCV_UNSET, MCV_POSITIVE, 1e-3, \
      "centre of the band of a filter in front of the lens, at normal incidence [m]") \
    X(length, filterWidth, MCV_UNSET, MCV_POSITIVE, 1e-3, \
      "width of the filter's band at half of its maximum [m]") \
    X(number, filterIndex, MCV_UNSET, 1, 10, \
      "effective index of the filter's layers; by default 1.8") \
    X(choice, extractor, 0, 0, 5, "method that finds the line's place") \
    X(integer, window, MCV_UNSET, 3, 63, \
      "pixels across the line that the extractor uses, an odd number; by default 15") \
    X(number, threshold, MCV_UNSET, 0, 1, \
      "share of the brightest pixel from which on a pixel belongs to the line; by default 0.1") \
    X(choice, across, 0, 0, 1, "the line has a place in each column, or in each row") \
    X(text, calibration, MCV_UNSET, 0, 0, \
      "file of `triangulate --calibrate` with the plane of the light, relative to the scene; by " \
      "default the true plane")

#endif
