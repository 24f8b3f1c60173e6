/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What in a scene cannot work, or hardly is what was meant: sentences for the user. Each rule is simple and sure in what it says; a
 * scene without a finding may still be wrong.
 */
#ifndef MCVISI_HOST_ANALYSIS_SETUP_H
#define MCVISI_HOST_ANALYSIS_SETUP_H

#include "scene/scene.h"

/*
 * Adds a warning to the scene for each
 * - emitter that lights nothing: flat (its mesh has no thickness along one axis of its node), and neither the ball about any other mesh
 *   nor a sensor's lens reaches into the beam of its cone (projectors, light fields: of all their directions). Emitters of other shapes
 *   are not judged;
 * - sensor that sees nothing: there is no environment, and the ball about no mesh reaches into the beam of what its lens takes in;
 * - node with an open dielectric: its triangles of all materials, welded where positions are equal, have edges that are not run as
 *   often in one direction as in the other, so that a ray may enter the body and never leave it;
 * - part (no emitter) more than 100 times as wide as the field in focus of a sensor, or all parts together smaller than its pixel
 *   there: their unit is likely another. Sensors without such a field (pinhole, focus at infinity) do not judge.
 * Fails only without memory.
 */
mcv_result mcv_setup_warn(mcv_scene *scene, mcv_error *error);

/* Counts the edges of instances [first, last), taken together, that have no partner. Fails only without memory. */
mcv_result mcv_open_edges(const mcv_scene *scene, uint32_t first, uint32_t last, uint32_t *edges, mcv_error *error);

#endif
