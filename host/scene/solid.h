/* SPDX-License-Identifier: Apache-2.0 */
/* Bodies with exact surfaces (mcvisi/surfaces/) on the host. */
#ifndef MCVISI_HOST_SCENE_SOLID_H
#define MCVISI_HOST_SCENE_SOLID_H

#include "mcvisi/surfaces/solid.h"
#include "core/json_path.h"
#include "scene/scene.h"

/* As many as a kernel's loop over all of them is meant for. */
#define MCV_MAX_SOLIDS 1024

/* The height of a cap's surface at (x, y), from the frame's origin; NaN beyond where it is defined.
 */
double mcv_cap_height(const mcv_cap *cap, double x, double y);

/* Has it a coefficient above those of a conic? */
bool mcv_cap_is_asphere(const mcv_cap *cap);

/* Is the surface defined up to this radius? */
mcv_result mcv_cap_check(const mcv_cap *cap, double radius, const mcv_json_path *place,
                         mcv_error *error);

/* Has it an inside: sizes above 0, caps that do not cross within the side? */
mcv_result mcv_solid_check(const mcv_solid *solid, const mcv_json_path *place, mcv_error *error);

/* May exact surfaces be of these materials, and the rim of another than the body? */
mcv_result mcv_solid_check_materials(const mcv_solid *solid, const mcv_scene *scene, uint32_t body,
                                     uint32_t rim, const mcv_json_path *place, mcv_error *error);

/* The corners of its box in its frame, rounded outwards. */
void mcv_solid_box(const mcv_solid *solid, float corners[24]);

/* Is the world point inside? Never in an open surface. */
bool mcv_solid_holds(const mcv_solid *solid, const double point[3]);

/* Largest |d²z/dr²| and |dz/dr|/r of a cap up to the radius [1/m]. */
double mcv_cap_bend(const mcv_cap *cap, double radius);

/*
 * tessellate.c: makes the solids of these instances meshes, with the exact normals in their
 * vertices. Chords lie within 50 nm of the surface, or as near as 500 000 triangles for a face
 * come. The meshes are closed; a rim of another material is an instance behind that of the caps, as
 * before. Fails for cemented solids of different radii, whose faces would not meet.
 */
mcv_result mcv_scene_mesh_solids(mcv_scene *scene, const uint32_t instances[2],
                                 const mcv_json_path *place, mcv_error *error);

/* At most so many triangles does it make of them. */
uint64_t mcv_scene_solid_triangles(const mcv_scene *scene, const uint32_t instances[2]);

#endif
