/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MCVISI_misalignment on a node: by how much it stands and looks otherwise than it should, as
 * tolerances of assembly need it. The node, with what is on and below it, is turned about its own
 * origin and then shifted, both in the axes of its parent; in those of the document where it has
 * MCVISI_pose.
 *
 *     {"shiftX": "0.1mm", "turnZ": "0.2deg"}
 *
 * The three turns are one rotation vector: its direction is the axis, its length the angle. So the
 * axes are fixed and there is no order. Poses that have the node as their target aim at where it
 * should be.
 */
#ifndef MCVISI_MISALIGNMENT_H
#define MCVISI_MISALIGNMENT_H

#include "mcvisi/params.h"

#define MCV_MISALIGNMENT_PARAMS(X) \
    X(length, shiftX, 0, -1e6, 1e6, "shift along x [m]") \
    X(length, shiftY, 0, -1e6, 1e6, "shift along y [m]") \
    X(length, shiftZ, 0, -1e6, 1e6, "shift along z [m]") \
    X(angle, turnX, 0, -1e3, 1e3, "x component of the rotation vector [rad]") \
    X(angle, turnY, 0, -1e3, 1e3, "y component of the rotation vector [rad]") \
    X(angle, turnZ, 0, -1e3, 1e3, "z component of the rotation vector [rad]")

#endif
