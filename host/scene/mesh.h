/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes as the loader hands them to a scene. */
#ifndef MCVISI_HOST_SCENE_MESH_H
#define MCVISI_HOST_SCENE_MESH_H

#include "core/json_path.h"
#include "scene/scene.h"

/*
 * Refuses indices beyond the vertices and values that are not finite; makes normals unit. Normals
 * of length 0 become the mean of the adjacent faces' (weighed by area), and are counted in
 * *repaired.
 */
mcv_result mcv_mesh_check(mcv_mesh *mesh, uint32_t *repaired, const mcv_json_path *place,
                          mcv_error *error);
/*
 * Tangents along increasing u of the texture coordinates, from the triangles around each vertex;
 * where there are none, or they say nothing, along the x axis of the mesh's node.
 */
mcv_result mcv_mesh_make_tangents(mcv_mesh *mesh, const mcv_json_path *place, mcv_error *error);

/*
 * Vertex normals for a mesh whose every three positions are a triangle, as an STL file's are:
 * continuous where faces meet at crease_angle [rad] or less, sharp elsewhere (normals.c). Takes the
 * place of normals that it has.
 */
mcv_result mcv_mesh_make_normals(mcv_mesh *mesh, double crease_angle, const mcv_json_path *place,
                                 mcv_error *error);

void mcv_mesh_free(mcv_mesh *mesh);

/* Like mcv_scene_add_mesh, but takes over the arrays, which have passed mcv_mesh_check. On failure
 * they are freed. */
mcv_result mcv_scene_take_mesh(mcv_scene *scene, mcv_mesh *mesh, mcv_error *error);
mcv_result mcv_scene_take_texture(mcv_scene *scene, mcv_texture *texture, mcv_error *error);

/* The area of a triangle of an instance, and of all of them, in the world [m²]. */
double mcv_scene_triangle_area(const mcv_scene *scene, uint32_t instance, uint32_t local);
double mcv_scene_area(const mcv_scene *scene, uint32_t instance);

#endif
