/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Collimated beam (type "collimatedBeam"): light that leaves a rectangle exactly along its normal,
 * like a parallel emitter with half-angle 0. Its radiance is infinite in that one direction. It is
 * therefore given by the irradiance E on a plane across the beam, or by the power Φ = E A (per
 * channel). With "aperture": "circle" the beam leaves only the central disk whose diameter is the
 * shorter side.
 *
 * An `image` modulates it: E then belongs to the value 1, and Φ contains the image's mean over the
 * aperture. The image lies as the telecentric projector's does (row 0 at +y, column 0 at -x,
 * "mirror" flips the columns) and is projected without blur.
 *
 * A camera ray hits the beam with probability 0. Next-event estimation therefore follows it back
 * along its axis. Behind glass and mirrors, and where the beam enters a camera's lens, light paths
 * carry it. The rectangle absorbs what falls on it.
 *
 *     {"type": "collimatedBeam", "size": ["20mm", "20mm"], "aperture": "circle", "power": 0.005}
 *
 * Emission: a point uniform by area on the rectangle (density 1/A), the direction of the normal.
 * Each path carries the flux E A, or 0 outside the aperture.
 */
#ifndef MCVISI_EMITTERS_COLLIMATED_BEAM_H
#define MCVISI_EMITTERS_COLLIMATED_BEAM_H

#include "mcvisi/emitters/emitter.h"

#define MCV_COLLIMATED_BEAM_PARAMS(X) \
    X(spectrum, irradiance, MCV_UNSET, 0, 1e30, \
      "irradiance E across the beam, of the image's value 1 [W/m²]") \
    X(spectrum, power, MCV_UNSET, 0, 1e30, "power of the whole beam, in place of irradiance [W]") \
    X(length2, size, MCV_REQUIRED, MCV_POSITIVE, 1e6, "width and height of the rectangle [m]") \
    X(choice, aperture, 0, 0, 1, "\"square\" is the whole rectangle, \"circle\" the disk in it") \
    X(image, image, MCV_UNSET, 0, 4294967294.0, \
      "index or name of one of the file's images, or {\"uri\": FILE.exr}") \
    X(flag, mirror, 0, 0, 1, "column 0 at +x instead of -x")

typedef struct mcv_collimated_beam {
    float axis[3];                 /* unit; direction of the beam in the world */
    float x[3], y[3];              /* the node's axes in the world */
    float half_width, half_height; /* [m] */
    float radius_squared;          /* of the disk [m²]; infinite for a rectangle */
} mcv_collimated_beam;
MCV_ASSERT_SIZE(mcv_collimated_beam, 48);

/* 1 if a point, relative to the centre of the emitter, lies in the beam. */
MCV_LOOP_FUNCTION int mcv_collimated_beam_covers(MCV_GLOBAL const mcv_collimated_beam *beam,
                                                 mcv_vec3 from_middle) {
    const float across = mcv_dot(from_middle, mcv_vec(beam->x[0], beam->x[1], beam->x[2]));
    const float up = mcv_dot(from_middle, mcv_vec(beam->y[0], beam->y[1], beam->y[2]));
    return (mcv_abs(across) <= beam->half_width) & (mcv_abs(up) <= beam->half_height) &
           (mcv_fma(across, across, up * up) <= beam->radius_squared);
}

#endif
