/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MCVISI_pose on a node: where it stands and looks, in the terms in which a rig is set up and
 * swept. It takes the place of translation, rotation, scale and matrix, and counts from the
 * document's root, whatever the node's parents.
 *
 *     {"target": "part", "distance": "110mm", "elevation": "30deg", "azimuth": "-45deg"}
 *
 * The node stands at target + distance (cos el sin az, sin el, cos el cos az) and looks at the
 * target along its -z: azimuth 0 is in front (+z) and turns towards +x, elevation 90° is above
 * (+y). Its x axis is level; at 90° it is the limit of lower elevations. Roll turns it about its
 * own z axis, right-handed. The target is a node (name or index) or a point.
 */
#ifndef MCVISI_POSE_H
#define MCVISI_POSE_H

#include "mcvisi/params.h"

#define MCV_POSE_PARAMS(X) \
    X(length, distance, MCV_REQUIRED, MCV_POSITIVE, 1e6, "distance from the target [m]") \
    X(angle, azimuth, 0, -1e3, 1e3, "angle about the vertical from +z towards +x [rad]") \
    X(angle, elevation, 0, -1e3, 1e3, "angle above the horizontal [rad]") \
    X(angle, roll, 0, -1e3, 1e3, "angle about the viewing axis [rad]")

#endif
