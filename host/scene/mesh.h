/* SPDX-License-Identifier: Apache-2.0 */
/* Meshes as the loader passes them to a scene. */
#ifndef MCVISI_HOST_SCENE_MESH_H
#define MCVISI_HOST_SCENE_MESH_H

#include "core/json_path.h"
#include "scene/scene.h"

/*
 * Refuses indices without a vertex and values that are not finite; normalises normals. Normals of
 * length 0 are replaced by the area-weighed mean of the adjacent faces' normals; *repaired counts
 * them.
 */
mcv_result mcv_mesh_check(mcv_mesh *mesh, uint32_t *repaired, const mcv_json_path *place,
                          mcv_error *error);
/*
 * Makes tangents in the direction of increasing u of the texture coordinates, from the triangles
 * around each vertex. Without usable coordinates they follow the x axis of the mesh's node.
 */
mcv_result mcv_mesh_make_tangents(mcv_mesh *mesh, const mcv_json_path *place, mcv_error *error);

/* Makes a mesh of separate triangles, without normals. On failure the mesh can only be freed. */
mcv_result mcv_mesh_separate(mcv_mesh *mesh, const mcv_json_path *place, mcv_error *error);

/*
 * Makes vertex normals: continuous where faces meet at crease_angle [rad] or less, sharp elsewhere
 * (normals.c). Replaces existing normals. Afterwards no two triangles share a vertex. The mesh must
 * have passed mcv_mesh_check.
 */
mcv_result mcv_mesh_make_normals(mcv_mesh *mesh, double crease_angle, const mcv_json_path *place,
                                 mcv_error *error);

void mcv_mesh_free(mcv_mesh *mesh);

/* Bytes of its arrays. */
static inline uint64_t mcv_mesh_bytes(const mcv_mesh *m) {
    const uint64_t floats = 3 + (m->normals ? 3 : 0) + (m->texcoords ? 2 : 0) +
                            (m->texcoords1 ? 2 : 0) + (m->tangents ? 4 : 0);
    return 3 * sizeof(uint32_t) * m->triangle_count + floats * sizeof(float) * m->vertex_count;
}

/* Like mcv_scene_add_mesh, but takes ownership of the arrays, which must have passed
 * mcv_mesh_check. On failure they are freed. */
mcv_result mcv_scene_take_mesh(mcv_scene *scene, mcv_mesh *mesh, mcv_error *error);
mcv_result mcv_scene_take_texture(mcv_scene *scene, mcv_texture *texture, mcv_error *error);

/* The area of a triangle of an instance, and of all of them, in the world [m²]. */
double mcv_scene_triangle_area(const mcv_scene *scene, uint32_t instance, uint32_t local);
double mcv_scene_area(const mcv_scene *scene, uint32_t instance);

#endif
