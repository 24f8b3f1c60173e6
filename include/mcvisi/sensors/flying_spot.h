/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Flying spot scanner (type "flyingSpotScanner"): the laser scanner of transparent parts. A beam
 * stands at one place after the other, telecentric as behind an f-θ lens, and detectors behind the
 * part gather its light. Light goes both ways alike: the beam is the sensor, and what it meets is
 * the detector, an emitter that shines where and into which directions the detector receives. A
 * pixel is the share of the beam's power that a detector of radiance 1 receives.
 *
 * In the optical frame (mcvisi/sensors/sensor.h) the beam of pixel (i, j) has the axis x = (i + 1/2
 * - p_x) l_x, y = (p_y - j - 1/2) l_y along z. Its rays are those of a Gaussian Schell beam, whose
 * Wigner density is positive: with the 1/e² radius w0 of the waist at z = z_w, the half divergence
 * Θ = M² λ/(π w0) and four independent normal numbers n,
 *
 *     d = (Θ/2 n_1, Θ/2 n_2, 1)    o = axis + w0/2 (n_3, n_4) - z_w d, at z = 0
 *
 * so that w(z)² = w0² (1 + ((z - z_w) Θ/w0)²). Detectors in the Fourier plane of a collecting lens
 * receive directions, whatever the place: a lightField emitter of one macro pixel.
 *
 *     {"type": "flyingSpotScanner", "wavelength": "660nm", "beamDiameter": "100um",
 *      "widthMeasure": "1/e2", "workingDistance": "200mm", "resolution": [1397, 100],
 *      "pixelSize": "50um"}
 */
#ifndef MCVISI_SENSORS_FLYING_SPOT_H
#define MCVISI_SENSORS_FLYING_SPOT_H

#include "mcvisi/normal.h"
#include "mcvisi/sensors/sensor.h"

#define MCV_FLYING_SPOT_PARAMS(X) \
    X(length, wavelength, MCV_REQUIRED, 1e-7, 1e-4, "wavelength λ [m]") \
    X(number2, M2, 1, 1, 1e6, "beam quality M² in x and y, at least 1") \
    X(length2, beamDiameter, MCV_REQUIRED, MCV_POSITIVE, 1e3, \
      "diameter of the waist in x and y [m]") \
    X(choice, widthMeasure, 0, 0, 2, \
      "what the diameter is: \"1/e2\", down to 13.5 % of the peak, or \"FWHM\", to half of it") \
    X(length, workingDistance, 0, 0, 1e6, "distance of the waist from the node [m]") \
    X(int2, resolution, MCV_REQUIRED, 1, 65536, "positions of the beam in x and y") \
    X(length2, pixelSize, MCV_REQUIRED, MCV_POSITIVE, 1, \
      "distance of neighbouring positions in x and y [m]") \
    MCV_READOUT_PARAMS(X)

typedef struct mcv_flying_spot {
    mcv_centre centre_x, centre_y;
    float pixel_x, pixel_y; /* from one position to the next [m] */
    float spot[2];          /* standard deviation of the waist's rays: w0/2 [m] */
    float slope[2];         /* that of their slopes: Θ/2 */
    float distance;         /* of the waist [m] */
    uint padding;
} mcv_flying_spot;
MCV_ASSERT_SIZE(mcv_flying_spot, 48);

/* The place in the pixel chooses that in the waist. */
MCV_LOOP_FUNCTION mcv_sensor_ray mcv_flying_spot_sample(MCV_CONSTANT const mcv_flying_spot *sensor,
                                                        mcv_film_sample film, float xi, float eta) {
    mcv_sensor_ray sensor_ray;
    float turn[2], shift[2];
    mcv_normal_pair(xi, eta, turn);
    mcv_normal_pair(film.x, film.y, shift);
    sensor_ray.direction = mcv_vec(turn[0] * sensor->slope[0], turn[1] * sensor->slope[1], 1.0f);
    const float x = -mcv_from_centre(sensor->centre_x, film.column, 0.5f) * sensor->pixel_x;
    const float y = mcv_from_centre(sensor->centre_y, film.row, 0.5f) * sensor->pixel_y;
    sensor_ray.origin = mcv_vec(
        mcv_fma(-sensor->distance, sensor_ray.direction.x, mcv_fma(sensor->spot[0], shift[0], x)),
        mcv_fma(-sensor->distance, sensor_ray.direction.y, mcv_fma(sensor->spot[1], shift[1], y)),
        0.0f);
    sensor_ray.weight = 1.0f;
    return sensor_ray;
}

#endif
