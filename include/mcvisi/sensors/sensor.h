/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What all sensors share.
 *
 * Optical frame: origin in the centre of the main lens, x right, y up, z towards the scene (z = -z
 * of the node, so the frame is left-handed: no cross products in it). The image plane is at z = -b.
 * The stored image is upright, row 0 on top: the image point (column, row) in pixels from the
 * top-left corner lies at s = ((p_x - column) l_x, (row - p_y) l_y), p the principal point, by
 * default (W/2, H/2). With κ = (b - f)/(b f) = 1/w_z the report's (4.1), (4.2) and d = w - o
 * become, scaled by κ,
 *
 *     d = (-x/b - κ o_x, -y/b - κ o_y, 1)
 *
 * for the point (x, y) on the image plane and o on the main lens: one form, focus at infinity
 * included.
 *
 * Radiometry: "radiance" weighs each ray 0 or 1 (pixel = mean radiance over the samples; closing
 * the stop does not darken the image); "irradiance" [W/m² on the pixel] weighs it A cos⁴θ / h², A
 * the area sampled at distance h. "falloff" says which θ:
 *
 *     objectSide  cosθ = 1/|d|: the light that leaves the object and enters the lens all falls on
 * the image, b/w as large. So energy is kept. imageSide   cosθ = 1/|(o - s)/b| = 1/|d + o/f|: what
 * the pixel sees of the pupil has the object's radiance. So radiance is kept, and a uniform field
 * gives π sin²θ' on the axis.
 *
 * A thin lens maps planes onto planes at any aperture, which no lens that keeps energy and radiance
 * can (those obey the sine condition): both agree at small angles and differ by the square of the
 * aperture's tangent.
 *
 * A sensor may lie inside a body of glass or fluid: the media that surround the centre of its lens
 * are taken for the whole lens.
 *
 * A sensor is one header with
 *     MCV_<NAME>_PARAMS(X)    its parameters (mcvisi/params.h)
 *     mcv_<name>              what the device needs of them, 4-byte scalars
 *     mcv_<name>_sample       pixel and aperture sample -> ray of sight
 *     mcv_<name>_through      pixel and point of the pupil in its radii -> ray of sight; of sensors
 * that can aim (kernels/path/sensor_ray.h) mcv_<name>_connect, mcv_<name>_invert,
 * mcv_<name>_footprint for light paths, see below; a sensor without them is not reached by any one
 * line in MCV_SENSORS (mcvisi/elements.h), and in host/scene/sensors.c mcv_<name>_resolve fills in
 * parameters that follow from others, refuses contradictions mcv_<name>_prepare      parameters ->
 * device struct, in double
 */
#ifndef MCVISI_SENSORS_SENSOR_H
#define MCVISI_SENSORS_SENSOR_H

#include "mcvisi/params.h"
#include "mcvisi/sampling.h"

/*
 * Lens parameters of the sensors that are not telecentric. Focus: imageDistance b or focusDistance
 * w, 1/f = 1/w + 1/b. Aperture: lensDiameter D_l or fNumber N = b/D_l, the working one as of the
 * telecentric camera; engraved on a lens is f/D_l, which is N f/b: the same at infinity, half of N
 * at magnification 1.
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
 * What is read out of the film, in pixels; of a light field camera's in whole macro pixels. Each
 * pixel of the image sees exactly what the same pixel of the whole film sees. A binned pixel is the
 * union of binning x pixels (of a light field camera: of the pixels at the same place of their
 * macro pixels): radiance and irradiance [W/m²] are the mean over it, the power grows with its
 * area.
 */
#define MCV_READOUT_PARAMS(X) \
    X(number2, principalPoint, MCV_UNSET, -1e6, 1e6, \
      "where the optical axis meets the film, in pixels from its top-left corner; by default its " \
      "centre") \
    X(int4, regionOfInterest, MCV_UNSET, 0, 65536, \
      "column, row, width and height of what is read out, in (macro) pixels; by default all") \
    X(int2, binning, 1, 1, 65536, \
      "(macro) pixels in x and y that are read out as one; must divide what is read out")

/* Film parameters of the sensors whose pixels are one grid. */
#define MCV_FILM_PARAMS(X) \
    X(int2, resolution, MCV_REQUIRED, 1, 65536, "pixels in x and y") \
    X(length2, pixelSize, MCV_REQUIRED, MCV_POSITIVE, 1, "width and height of a pixel [m]") \
    MCV_READOUT_PARAMS(X) \
    X(choice, radiometry, 0, 0, 1, \
      "what a pixel measures: mean radiance [W/(m² sr)] or irradiance [W/m²]")

/* Of the sensors with a lens. */
#define MCV_FALLOFF_PARAMS(X) \
    X(choice, falloff, 0, 0, 1, \
      "whose angles the cos⁴ of irradiance takes: the object's side or the image's")

/* A ray of sight in the optical frame. The direction has z = 1 and is not normalised. */
typedef struct mcv_sensor_ray {
    mcv_vec3 origin, direction;
    float weight; /* 0: the ray does not pass the lens */
} mcv_sensor_ray;

/* Where in the image a ray starts: pixel indices from the top-left corner, position (x, y) inside
 * the pixel in [0, 1). */
typedef struct mcv_film_sample {
    uint column, row;
    float x, y;
} mcv_film_sample;

/* The same as coordinates in the pixels of the image. */
typedef struct mcv_film_point {
    float column, row;
} mcv_film_point;

/*
 * Light paths reach the sensor the other way round. With o the place on the lens and d the
 * direction (z = 1) of a ray of sight, a pixel is the mean of weight x radiance over its area and
 * the aperture samples, that is the integral of W(o, d) L over o and d_x, d_y:
 *
 *     mcv_<name>_invert    the ray's place on the film, and W [1/m²]; 0 where lens or stop end the
 * ray. The inverse of mcv_<name>_sample. mcv_<name>_connect   a ray of sight to a point z > 0 of
 * the optical frame, with o chosen of the aperture; returns the inverse of o's density [m²]
 *     mcv_<name>_footprint the area across the axis that a pixel sees at the depth z, through one
 * place on the lens [m²]
 *
 * A point of intensity J towards o adds J |d|/z² W over that density; light of the flux Φ that goes
 * along the ray of sight, Φ |d|⁴ W.
 */

/* A principal point's coordinate in the pixels of the image, as half of a whole number and what
 * remains, at most 1/4. */
typedef struct mcv_centre {
    int halves;
    float low;
} mcv_centre;

/*
 * centre - (index + offset), the distance from the principal point in pixels; exact but for its
 * last operation where nothing remains, as with the principal point in the middle; else within
 * 2^-25 pixels more.
 */
MCV_FUNCTION float mcv_from_centre(mcv_centre centre, uint index, float offset) {
    return 0.5f * (float)(centre.halves - 2 * (int)index) - (offset - centre.low);
}

#if !MCV_ON_DEVICE || MCV_WITH_LIGHT_TRACING
/* Where what mcv_from_centre gives lies on the film. */
MCV_FUNCTION float mcv_on_film(mcv_centre centre, float from_centre) {
    return 0.5f * (float)centre.halves + (centre.low - from_centre);
}
#endif

/* The radiometric weight: etendue = A/h² for irradiance, 0 for radiance; bend = 1/f for the angles
 * on the image's side, 0 for the object's.
 */
MCV_FUNCTION float mcv_sensor_ray_weight(float etendue, float bend, mcv_vec3 origin,
                                         mcv_vec3 direction) {
    const mcv_vec3 counted = mcv_vec(mcv_fma(bend, origin.x, direction.x),
                                     mcv_fma(bend, origin.y, direction.y), direction.z);
    const float squared = mcv_dot(counted, counted);
    return etendue > 0.0f ? etendue / (squared * squared) : 1.0f;
}

#endif
