/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Line scan camera (type "lineScan"): the example of "A sensor" in docs/adding-an-element.md.
 *
 * One row of pixels behind a pinhole, past which the part moves along y by `linePitch` from line
 * to line: perspective in x, parallel in y. The image is the stack of lines, row 0 at +y. In the
 * optical frame (mcvisi/sensors/sensor.h) the line of row v sees along
 *
 *     o = (0, (p_y - v) linePitch, 0)        d = (-s_x/b, 0, 1)
 *
 * Like a pinhole it measures radiance only. Of pixelSize the height has no meaning.
 *
 *     {"type": "lineScan", "imageDistance": "50mm", "linePitch": "0.1mm", "resolution": [2048,
 * 500], "pixelSize": "7um"}
 */
#ifndef MCVISI_SENSORS_LINE_SCAN_H
#define MCVISI_SENSORS_LINE_SCAN_H

#include "mcvisi/sensors/sensor.h"

/* X(kind, key, default, min, max, "doc [unit]"): parser, ranges, units, --set, check, help and
 * schema follow (mcvisi/params.h). */
#define MCV_LINE_SCAN_PARAMS(X) \
    X(length, imageDistance, MCV_REQUIRED, MCV_POSITIVE, 1e3, \
      "distance b from the pinhole to the line of pixels [m]") \
    X(length, linePitch, MCV_REQUIRED, MCV_POSITIVE, 1e3, \
      "how far the part moves from line to line [m]") \
    MCV_FILM_PARAMS(X)

/* What the device needs, computed in double by mcv_line_scan_prepare: 4-byte scalars, a multiple of
 * 16 bytes. */
typedef struct mcv_line_scan {
    mcv_centre centre_x, centre_y; /* the principal point */
    float slope_x;                 /* (binned) pixel width / b */
    float pitch;                   /* (binned) linePitch [m] */
    uint padding[2];
} mcv_line_scan;
MCV_ASSERT_SIZE(mcv_line_scan, 32);

/* Host and device compile this. film: the pixel and the place inside it; (xi, eta): a place on the
 * aperture, in [0, 1)², of which there is none. */
MCV_FUNCTION mcv_sensor_ray mcv_line_scan_sample(MCV_CONSTANT const mcv_line_scan *sensor,
                                                 mcv_film_sample film, float xi, float eta) {
    mcv_sensor_ray sensor_ray;
    (void)xi;
    (void)eta;
    sensor_ray.origin =
        mcv_vec(0.0f, mcv_from_centre(sensor->centre_y, film.row, film.y) * sensor->pitch, 0.0f);
    sensor_ray.direction = mcv_vec(
        -mcv_from_centre(sensor->centre_x, film.column, film.x) * sensor->slope_x, 0.0f, 1.0f);
    sensor_ray.weight = 1.0f;
    return sensor_ray;
}

#endif
