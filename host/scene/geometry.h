/* SPDX-License-Identifier: Apache-2.0 */
/* Triangles of the scene in the world. */
#ifndef MCVISI_HOST_SCENE_GEOMETRY_H
#define MCVISI_HOST_SCENE_GEOMETRY_H

#include "scene/scene.h"

/* World geometry in double. `global` is a triangle's number; `instance` gets its instance. Corners
 * run counter-clockwise from the front. */
uint32_t mcv_scene_instance_of(const mcv_scene *scene, uint32_t global);
void mcv_scene_triangle(const mcv_scene *scene, uint32_t instance, uint32_t local,
                        uint32_t vertices[3]); /* of the mesh, in that order */
void mcv_scene_vertex(const mcv_scene *scene, uint32_t instance, uint32_t vertex, double world[3]);
void mcv_scene_box(const mcv_scene *scene, uint32_t instance, double lower[3],
                   double upper[3]); /* without vertices: lower > upper */
void mcv_scene_corners(const mcv_scene *scene, uint32_t instance, uint32_t local,
                       double corners[3][3]);
void mcv_scene_face_normal(const mcv_scene *scene, uint32_t instance, uint32_t local,
                           double normal[3]); /* twice the area long */
void mcv_scene_vertex_normals(const mcv_scene *scene, uint32_t instance, uint32_t local,
                              double normals[3][3]); /* unit; flat meshes: the face's */
/* A vertex's tangent in the world, not normalised, and the sign of its bitangent: normal x tangent.
 */
void mcv_scene_tangent(const mcv_scene *scene, uint32_t instance, uint32_t vertex,
                       double tangent[4]);

#endif
