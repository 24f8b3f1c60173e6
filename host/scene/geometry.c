/* SPDX-License-Identifier: Apache-2.0 */
/* The scene's triangles in the world. */
#include "scene/mesh.h"
#include "scene/transform.h"
#include "scene/geometry.h"

#include <math.h>

uint32_t mcv_scene_instance_of(const mcv_scene *scene, uint32_t global) {
    if (global >= scene->triangle_count) {
        const uint32_t piece = global - scene->triangle_count;
        return scene->solids[piece / 3].instances[piece % 3];
    }
    /* The last instance that starts at or before the triangle; instances without triangles are
     * skipped. */
    uint32_t low = 0, high = scene->instance_count;
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (scene->instances[middle].first_triangle <= global)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void mcv_scene_triangle(const mcv_scene *scene, uint32_t instance, uint32_t local,
                        uint32_t vertices[3]) {
    const mcv_instance *placed = scene->instances + instance;
    const uint32_t *indices = scene->meshes[placed->mesh].indices + 3 * (size_t)local;
    const bool mirrored = mcv_transform_determinant(&placed->to_world) < 0;
    vertices[0] = indices[0];
    vertices[1] = indices[mirrored ? 2 : 1];
    vertices[2] = indices[mirrored ? 1 : 2];
}

void mcv_scene_vertex(const mcv_scene *scene, uint32_t instance, uint32_t vertex, double world[3]) {
    const mcv_instance *placed = scene->instances + instance;
    const float *p = scene->meshes[placed->mesh].positions + 3 * (size_t)vertex;
    mcv_transform_point(&placed->to_world, (const double[3]){p[0], p[1], p[2]}, world);
}

void mcv_scene_box(const mcv_scene *scene, uint32_t instance, double lower[3], double upper[3]) {
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    for (int k = 0; k < 3; ++k) lower[k] = INFINITY, upper[k] = -INFINITY;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        double world[3];
        mcv_scene_vertex(scene, instance, v, world);
        for (int k = 0; k < 3; ++k) {
            if (world[k] < lower[k]) lower[k] = world[k];
            if (world[k] > upper[k]) upper[k] = world[k];
        }
    }
}

void mcv_scene_corners(const mcv_scene *scene, uint32_t instance, uint32_t local,
                       double corners[3][3]) {
    uint32_t vertices[3];
    mcv_scene_triangle(scene, instance, local, vertices);
    for (int i = 0; i < 3; ++i) mcv_scene_vertex(scene, instance, vertices[i], corners[i]);
}

void mcv_scene_face_normal(const mcv_scene *scene, uint32_t instance, uint32_t local,
                           double normal[3]) {
    double corners[3][3], edge[2][3];
    mcv_scene_corners(scene, instance, local, corners);
    for (int i = 0; i < 3; ++i) {
        edge[0][i] = corners[1][i] - corners[0][i];
        edge[1][i] = corners[2][i] - corners[0][i];
    }
    mcv_cross3(edge[0], edge[1], normal);
}

void mcv_scene_vertex_normals(const mcv_scene *scene, uint32_t instance, uint32_t local,
                              double normals[3][3]) {
    const mcv_instance *placed = scene->instances + instance;
    const float *stored = scene->meshes[placed->mesh].normals;
    double face[3];
    mcv_scene_face_normal(scene, instance, local, face);
    if (!mcv_normalize3(face, face))
        memcpy(face, (double[3]){0, 0, 1}, sizeof face); /* a triangle without area is never hit */
    uint32_t vertices[3];
    mcv_scene_triangle(scene, instance, local, vertices);
    for (int i = 0; i < 3; ++i) {
        memcpy(normals[i], face, sizeof face);
        if (!stored) continue;
        const float *n = stored + 3 * (size_t)vertices[i];
        const double normal[3] = {n[0], n[1], n[2]};
        double world[3];
        mcv_transform_normal(&placed->to_world, normal, world);
        mcv_normalize3(world, normals[i]);
    }
}

void mcv_scene_tangent(const mcv_scene *scene, uint32_t instance, uint32_t vertex,
                       double tangent[4]) {
    const mcv_instance *placed = scene->instances + instance;
    const float *t = scene->meshes[placed->mesh].tangents + 4 * (size_t)vertex;
    mcv_transform_vector(&placed->to_world, (const double[3]){t[0], t[1], t[2]}, tangent);
    tangent[3] = mcv_transform_determinant(&placed->to_world) < 0 ? -t[3] : t[3];
}

double mcv_scene_triangle_area(const mcv_scene *scene, uint32_t instance, uint32_t local) {
    double normal[3];
    mcv_scene_face_normal(scene, instance, local, normal);
    return 0.5 * hypot(hypot(normal[0], normal[1]), normal[2]);
}

double mcv_scene_area(const mcv_scene *scene, uint32_t instance) {
    double sum = 0;
    const uint32_t count = scene->meshes[scene->instances[instance].mesh].triangle_count;
    for (uint32_t t = 0; t < count; ++t) sum += mcv_scene_triangle_area(scene, instance, t);
    return sum;
}

/* Kernels multiply three lengths in float32, whose largest number is 3e38. */
static const double largest_scene = 1e12;

mcv_result mcv_scene_check_extent(const mcv_transform *to_world, const double reach[3],
                                  const mcv_json_path *place, mcv_error *error) {
    for (size_t i = 0; i < 3; ++i) {
        double far = fabs(to_world->m[9 + i]);
        for (size_t k = 0; k < 3; ++k) far += fabs(to_world->m[3 * i + k]) * reach[k];
        if (!(far <= largest_scene))
            return mcv_fail_at(place, error,
                               "it reaches to %.3g m, but a scene may reach to %g m: is a scale or "
                               "a length wrong?",
                               far, largest_scene);
    }
    return MCV_OK;
}
