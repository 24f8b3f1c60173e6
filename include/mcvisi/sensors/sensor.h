/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What all sensors share.
 *
 * Optical frame: the origin lies in the centre of the main lens, x points right, y up, z towards
 * the scene. z is the node's -z, so the frame is left-handed: it must not be used with cross
 * products. The image plane is at z = -b. The stored image is upright, row 0 on top. The image
 * point (column, row), in pixels from the top-left corner, lies at s = ((p_x - column) l_x, (row -
 * p_y) l_y). p is the principal point, by default (W/2, H/2). With κ = (b - f)/(b f) = 1/w_z the
 * report's (4.1), (4.2) and d = w - o become, scaled by κ,
 *
 *     d = (-x/b - κ o_x, -y/b - κ o_y, 1)
 *
 * for the point (x, y) on the image plane and o on the main lens. This form includes focus at
 * infinity.
 *
 * Radiometry: with "radiance" the weight of a ray is 0 or 1. The pixel is the mean radiance over
 * the samples; a smaller stop does not darken the image. With "irradiance" [W/m² on the pixel] the
 * weight is A cos⁴θ / h², A the area that is sampled at distance h. "falloff" chooses θ:
 *
 *     objectSide  cosθ = 1/|d|. All light that leaves the object and enters the lens falls on the
 *                 image, which is b/w as large: energy is conserved.
 *     imageSide   cosθ = 1/|(o - s)/b| = 1/|d + o/f|. What the pixel sees of the pupil has the
 *                 object's radiance: radiance is conserved. A uniform field gives π sin²θ' on the
 *                 axis.
 *
 * A thin lens images planes onto planes at any aperture. A lens that conserves both energy and
 * radiance cannot, because it obeys the sine condition. The two choices agree at small angles and
 * differ by the square of the aperture's tangent.
 *
 * A sensor may lie inside a body of glass or fluid. The media around the centre of its lens are
 * used for the whole lens.
 *
 * A sensor is one header with
 *     MCV_<NAME>_PARAMS(X)    its parameters (mcvisi/params.h)
 *     mcv_<name>              what the device needs of them, 4-byte scalars
 *     mcv_<name>_sample       pixel and aperture sample -> camera ray
 *     mcv_<name>_through      pixel and point of the pupil, in its radii -> camera ray; for sensors
 *                             with pupil guiding (kernels/path/sensor_ray.h)
 *     mcv_<name>_connect, mcv_<name>_invert, mcv_<name>_footprint
 *                             for light paths, see below; without them light paths do not reach it
 * and one line in MCV_SENSORS (mcvisi/elements.h). host/scene/sensors.c has
 *     mcv_<name>_resolve      derives parameters from others, refuses contradictions
 *     mcv_<name>_prepare      parameters -> device struct, in double
 */
#ifndef MCVISI_SENSORS_SENSOR_H
#define MCVISI_SENSORS_SENSOR_H

#include "mcvisi/params.h"
#include "mcvisi/sampling.h"

/*
 * Lens parameters of the sensors that are not telecentric. Focus: imageDistance b or focusDistance
 * w, 1/f = 1/w + 1/b. Aperture: lensDiameter D_l or the working f-number N = b/D_l, as for the
 * telecentric camera. The number engraved on a lens is f/D_l = N f/b: equal to N at infinity, half
 * of it at magnification 1.
 */
#define MCV_LENS_PARAMS(X) \
    X(length, focalLength, MCV_REQUIRED, MCV_POSITIVE, 1e3, "focal length f of the main lens [m]") \
    X(length, imageDistance, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "distance b from the main lens to the image plane [m]") \
    X(length, focusDistance, MCV_UNSET, MCV_POSITIVE, DBL_MAX, \
      "depth w > f in focus, from the main lens [m]") \
    X(length, lensDiameter, MCV_UNSET, MCV_POSITIVE, 1e3, \
      "diameter D_l of the main lens; of a square one, the side [m]") \
    X(number, fNumber, MCV_UNSET, MCV_POSITIVE, 1e9, "working f-number N = b/D_l on the image side")

/*
 * The region of the film that is read out, in pixels; for a light field camera in whole macro
 * pixels. Each pixel of the image sees exactly what the same pixel of the whole film sees. A binned
 * pixel is the union of binning x pixels (light field camera: of the pixels at the same position in
 * their macro pixels). Radiance and irradiance [W/m²] are the mean over it; its power grows with
 * its area.
 */
#define MCV_READOUT_PARAMS(X) \
    X(number2, principalPoint, MCV_UNSET, -1e6, 1e6, \
      "where the optical axis meets the film, in pixels from its top-left corner; by default its " \
      "centre") \
    X(int4, regionOfInterest, MCV_UNSET, 0, 65536, \
      "column, row, width and height of the region that is read out, in (macro) pixels; by " \
      "default all") \
    X(int2, binning, 1, 1, 65536, \
      "(macro) pixels in x and y that are read out as one; must divide the size of the region")

/* Film parameters of the sensors whose pixels form one grid. */
#define MCV_FILM_PARAMS(X) \
    X(int2, resolution, MCV_REQUIRED, 1, 65536, "pixels in x and y") \
    X(length2, pixelSize, MCV_REQUIRED, MCV_POSITIVE, 1, "width and height of a pixel [m]") \
    MCV_READOUT_PARAMS(X) \
    X(choice, radiometry, 0, 0, 1, \
      "what a pixel measures: mean radiance [W/(m² sr)] or irradiance [W/m²]")

/*
 * Tilt of the film and distortion of the lens (mcvisi/sensors/distortion.h). tilt and tiltX, tiltY
 * say the same, and so do k1 and what a datasheet states of it, about the middle of the whole film:
 *
 *     tvDistortion         ΔH/H: the image of a straight line through both upper corners bends by
 *                          ΔH, H is the height of the film; positive where corners go outwards
 *     geometricDistortion  (r' - r)/r of the farthest corner, r' its distance from the axis
 */
#define MCV_DISTORTION_PARAMS(X) \
    X(angle, tilt, MCV_UNSET, -1.57, 1.57, \
      "angle between film and main lens [rad]; HALCON's Tilt") \
    X(angle, tiltDirection, MCV_UNSET, -1e3, 1e3, \
      "axis of the tilt, from the image's x (right) towards its y (down) [rad]; HALCON's Rot") \
    X(angle, tiltX, MCV_UNSET, -1.57, 1.57, "τx of OpenCV, a tilt about the image's x [rad]") \
    X(angle, tiltY, MCV_UNSET, -1.57, 1.57, "τy of OpenCV, a tilt about the image's y [rad]") \
    X(number, k1, MCV_UNSET, -1e9, 1e9, "radial distortion of OpenCV, of r²") \
    X(number, k2, MCV_UNSET, -1e9, 1e9, "of r⁴") \
    X(number, k3, MCV_UNSET, -1e9, 1e9, "of r⁶") \
    X(number, k4, MCV_UNSET, -1e9, 1e9, "of r² in the denominator") \
    X(number, k5, MCV_UNSET, -1e9, 1e9, "of r⁴ in the denominator") \
    X(number, k6, MCV_UNSET, -1e9, 1e9, "of r⁶ in the denominator") \
    X(number, p1, MCV_UNSET, -1e9, 1e9, "tangential distortion of OpenCV, along y") \
    X(number, p2, MCV_UNSET, -1e9, 1e9, "tangential distortion of OpenCV, along x") \
    X(number, s1, MCV_UNSET, -1e9, 1e9, "thin prism distortion of OpenCV: x, r²") \
    X(number, s2, MCV_UNSET, -1e9, 1e9, "x, r⁴") \
    X(number, s3, MCV_UNSET, -1e9, 1e9, "y, r²") \
    X(number, s4, MCV_UNSET, -1e9, 1e9, "y, r⁴") \
    X(number, kappa, MCV_UNSET, -1e12, 1e12, \
      "HALCON's Kappa, of the division model, in place of k1 … s4 [1/m²]") \
    X(number, tvDistortion, MCV_UNSET, -1, 1, \
      "bend of a horizontal line at the film's edge over the film's height, in place of k1") \
    X(number, geometricDistortion, MCV_UNSET, -1, 1, \
      "relative shift of the film's farthest corner, in place of k1")

/* Time (mcvisi/motion.h). */
#define MCV_TIME_PARAMS(X) \
    X(choice, shutter, 0, 0, 2, "which rows are exposed when: all at once, in turn, or one line") \
    MCV_EXPOSURE_PARAMS(X)

#define MCV_EXPOSURE_PARAMS(X) \
    X(number, exposureTime, MCV_UNSET, 0, 1e6, "time for which a row is exposed [s]") \
    X(number, lineTime, MCV_UNSET, MCV_POSITIVE, 1e6, \
      "time between rows of a rolling shutter or lines [s]") \
    X(number, lineRate, MCV_UNSET, MCV_POSITIVE, 1e12, \
      "rows or lines per second, in place of lineTime [Hz]") \
    X(integer, stages, MCV_UNSET, 1, 1024, "stages of a TDI line sensor") \
    X(number, encoderJitter, MCV_UNSET, 0, 1e6, \
      "standard deviation of when an encoder begins a line [s]") \
    X(number, encoderRipple, MCV_UNSET, 0, 1e6, "amplitude of its periodic error [s]") \
    X(number, encoderPeriod, MCV_UNSET, MCV_POSITIVE, 1e9, "period of that error, in lines") \
    X(integer, encoderSeed, MCV_UNSET, 0, 1e9, "which run of the machine: chooses the jitter") \
    X(number, strobeDelay, MCV_UNSET, 0, 1e6, "when a strobe begins, after the first row [s]") \
    X(number, strobeTime, MCV_UNSET, MCV_POSITIVE, 1e6, "for how long it lights [s]")

/* The device struct of a sensor with these parameters ends in a mcv_distortion of so many bytes,
 * behind which an mcv_aperture may stand. Programs without these features know nothing of them. */
#if !MCV_ON_DEVICE || MCV_WITH_DISTORTION || MCV_WITH_APERTURE
#define MCV_DISTORTION_SIZE 220
#else
#define MCV_DISTORTION_SIZE 0
#endif

/* Of thin lens and telecentric cameras (mcvisi/sensors/aperture.h). */
#if !MCV_ON_DEVICE || MCV_WITH_APERTURE
#define MCV_APERTURE_BYTES 4136
#else
#define MCV_APERTURE_BYTES 0
#endif

#define MCV_APERTURE_PARAMS(X) \
    X(choice, aperture, 2, 2, 7, "what of the round aperture is open") \
    X(number, apertureRatio, MCV_UNSET, MCV_POSITIVE, 0.999, \
      "inner over outer radius of a ring, by default 0.5") \
    X(angle, apertureRotation, MCV_UNSET, -1e3, 1e3, \
      "direction of the open half, or of the first corner of blades, from right towards up [rad]") \
    X(integer, apertureBlades, MCV_UNSET, 3, 64, "corners of blades, by default 6") \
    X(integer, apertureOrder, MCV_UNSET, 5, 31, \
      "cells of a side of a code, a prime; by default 13") \
    X(mask, apertureMask, MCV_UNSET, 1, MCV_MASK_SIDE, \
      "rows of what the cells of the square about the aperture pass, the upper row first, as the " \
      "camera looks")

/* For the sensors with a lens. */
#define MCV_FALLOFF_PARAMS(X) \
    X(choice, falloff, 0, 0, 1, \
      "side whose angles enter the cos⁴ of irradiance: the object's or the image's")

/* A camera ray in the optical frame. The direction has z = 1 and is not normalised. */
typedef struct mcv_sensor_ray {
    mcv_vec3 origin, direction;
    float weight; /* 0: the ray does not pass the lens */
} mcv_sensor_ray;

/* Where in the image a ray starts: the pixel's indices from the top-left corner, and the position
 * (x, y) inside the pixel in [0, 1). */
typedef struct mcv_film_sample {
    uint column, row;
    float x, y;
} mcv_film_sample;

/* A position on the film, in pixels of the image. */
typedef struct mcv_film_point {
    float column, row;
} mcv_film_point;

/*
 * Light paths reach the sensor in the opposite direction. Let o be the point on the lens and d the
 * direction (z = 1) of a camera ray. A pixel is the mean of weight x radiance over its area and the
 * aperture samples, which is the integral of W(o, d) L over o and d_x, d_y:
 *
 *     mcv_<name>_invert    The ray's position on the film, and W [1/m²]; 0 if the ray does not pass
 *                          lens and stop. The inverse of mcv_<name>_sample.
 *     mcv_<name>_connect   A camera ray to a point z > 0 of the optical frame, with o sampled on
 *                          the aperture. Returns the inverse of o's density [m²].
 *     mcv_<name>_footprint The area, across the axis at the depth z, that a pixel sees through one
 *                          point of the lens [m²].
 *
 * A point of intensity J towards o adds J |d|/z² W over that density. Light of the flux Φ along the
 * camera ray adds Φ |d|⁴ W.
 */

/* A coordinate of the principal point in pixels of the image: half of an integer, and the rest, at
 * most 1/4. */
typedef struct mcv_centre {
    int halves;
    float low;
} mcv_centre;

/*
 * centre - (index + offset), the distance from the principal point in pixels. If the rest is 0, as
 * for a principal point in the middle, only the last operation rounds; otherwise the error is 2^-25
 * pixels larger.
 */
MCV_FUNCTION float mcv_from_centre(mcv_centre centre, uint index, float offset) {
    return 0.5f * (float)(centre.halves - 2 * (int)index) - (offset - centre.low);
}

#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_TRACING
/* The inverse of mcv_from_centre: the coordinate on the film. */
MCV_FUNCTION float mcv_on_film(mcv_centre centre, float from_centre) {
    return 0.5f * (float)centre.halves + (centre.low - from_centre);
}
#endif

/* The radiometric weight. etendue = A/h² for irradiance, 0 for radiance; bend = 1/f for falloff by
 * image-side angles, 0 for object-side ones. */
MCV_FUNCTION float mcv_sensor_ray_weight(float etendue, float bend, mcv_vec3 origin,
                                         mcv_vec3 direction) {
    const mcv_vec3 counted = mcv_vec(mcv_fma(bend, origin.x, direction.x),
                                     mcv_fma(bend, origin.y, direction.y), direction.z);
    const float squared = mcv_dot(counted, counted);
    return etendue > 0.0f ? etendue / (squared * squared) : 1.0f;
}

/* A place of the pupil, in its radii, and the weight of a ray through it. */
typedef struct mcv_pupil_sample {
    float x, y, weight;
} mcv_pupil_sample;

/* A place of the whole disc. */
MCV_LOOP_FUNCTION mcv_pupil_sample mcv_sample_disc(float xi, float eta) {
    mcv_pupil_sample to;
    float cosine, sine;
    const float r = mcv_disk(xi, eta, &cosine, &sine);
    to.x = r * cosine;
    to.y = r * sine;
    to.weight = 1.0f;
    return to;
}

/* A place of a sensor's pupil, and the weight of a ray through a place that is uniform on the disc
 * (mcvisi/sensors/aperture.h). */
#if MCV_WITH_APERTURE
#define MCV_SAMPLE_PUPIL(sensor, xi, eta) mcv_sample_aperture(&(sensor)->aperture, xi, eta)
#define MCV_PUPIL_WEIGHT(sensor, x, y) mcv_aperture_weight(&(sensor)->aperture, x, y)
#else
#define MCV_SAMPLE_PUPIL(sensor, xi, eta) mcv_sample_disc(xi, eta)
#define MCV_PUPIL_WEIGHT(sensor, x, y) 1.0f
#endif

#endif
