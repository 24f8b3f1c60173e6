/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Collimated beam (type "collimatedBeam"): light that leaves a rectangle exactly along its normal,
 * as the parallel emitter's would with a half-angle of 0. Its radiance is infinite in that one
 * direction, so it is given by the irradiance E on a plane across the beam, or by the power Φ = E A
 * (per channel). With "aperture": "circle" it leaves only the disk in the middle whose diameter is
 * the smaller side.
 *
 * An `image` modulates it: E is then that of the value 1, and Φ counts the image's mean over the
 * aperture. It lies as the telecentric projector's does (row 0 at +y, column 0 at -x, "mirror"
 * flips the columns), and is thrown without any blur.
 *
 * No ray of sight meets the beam by chance: surfaces find it by looking back along it; behind glass
 * and mirrors, and where it shines into a camera's lens, light paths find them. The rectangle
 * absorbs what falls on it.
 *
 *     {"type": "collimatedBeam", "size": ["20mm", "20mm"], "aperture": "circle", "power": 0.005}
 *
 * From the emitter's side: a place uniform by area on the rectangle (density 1/A), the direction
 * the normal (no density), each carrying the flux E A, or nothing where it is not on the aperture.
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
    float axis[3];                 /* unit; of the beam in the world */
    float x[3], y[3];              /* the node's axes in the world */
    float half_width, half_height; /* [m] */
    float radius_squared;          /* of the disk [m²]; infinite where there is none */
} mcv_collimated_beam;
MCV_ASSERT_SIZE(mcv_collimated_beam, 48);

/* 1 if the beam goes through a place, given from the middle of the emitter. */
MCV_LOOP_FUNCTION int mcv_collimated_beam_covers(MCV_GLOBAL const mcv_collimated_beam *beam,
                                                 mcv_vec3 from_middle) {
    const float across = mcv_dot(from_middle, mcv_vec(beam->x[0], beam->x[1], beam->x[2]));
    const float up = mcv_dot(from_middle, mcv_vec(beam->y[0], beam->y[1], beam->y[2]));
    return (mcv_abs(across) <= beam->half_width) & (mcv_abs(up) <= beam->half_height) &
           (mcv_fma(across, across, up * up) <= beam->radius_squared);
}

#endif
