/* SPDX-License-Identifier: Apache-2.0 */
/*
 * MCVISI_pose on a node: its place and direction, in the terms in which a rig is set up and swept.
 * It replaces translation, rotation, scale and matrix. It is relative to the document's root, not
 * to the node's parents.
 *
 *     {"target": "part", "distance": "110mm", "elevation": "30deg", "azimuth": "-45deg"}
 *
 * The node stands at target + distance (cos el sin az, sin el, cos el cos az) and looks at the
 * target along its -z. Azimuth 0 is in front (+z) and turns towards +x; elevation 90° is above
 * (+y). The node's x axis is level; at 90° it is the limit of lower elevations. Roll turns the node
 * about its own z axis, right-handed. The target is a node (name or index) or a point.
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
