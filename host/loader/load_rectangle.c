/* SPDX-License-Identifier: Apache-2.0 */
/* Rectangles that emit or reflect: instances of a mesh of two triangles. */
#include "loader/loader.h"

#include <stdlib.h>

#include "scene/emitters.h"
#include "scene/mesh.h"
#include "scene/transform.h"

/* An instance of a mesh that absorbs what falls on it, whatever the node's scale. */
static mcv_result add_surface(mcv_loader *loader, const char *name, const mcv_mesh *mesh,
                              const mcv_transform *to_world, const mcv_json_path *place,
                              mcv_error *error) {
    mcv_instance instance = {.name = (char *)name, .mesh = loader->scene->mesh_count};
    if (!mcv_transform_rigid(to_world, &instance.to_world))
        return mcv_fail_at(place, error, "its scale must not be 0");
    MCV_TRY(mcv_load_absorber(loader, &instance.material, error));
    MCV_TRY(mcv_scene_add_mesh(loader->scene, mesh, error));
    return mcv_scene_add_instance(loader->scene, &instance, error);
}

/*
 * Two triangles in the node's xy plane that face -z, the direction of emission. `size` is their
 * size, independent of the node's scale. An image's upper left corner lies at -x, +y; mirrored at
 * +x, +y.
 */
mcv_result mcv_load_rectangle(mcv_loader *loader, const char *name, const double size[2],
                              bool mirror, const mcv_transform *to_world,
                              const mcv_json_path *place, mcv_error *error) {
    const float x = (float)(size[0] / 2), y = (float)(size[1] / 2);
    float positions[] = {-x, -y, 0, x, -y, 0, x, y, 0, -x, y, 0};
    const float left = mirror ? 1 : 0;
    float texcoords[] = {left, 1, 1 - left, 1, 1 - left, 0, left, 0};
    uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    const mcv_mesh mesh = {.name = (char *)name,
                           .vertex_count = 4,
                           .triangle_count = 2,
                           .positions = positions,
                           .texcoords = texcoords,
                           .indices = indices};
    return add_surface(loader, name, &mesh, to_world, place, error);
}

/* --- a screen that is not flat --- */

enum { CELLS = 64, SIDE = CELLS + 1 };

static void bend(const mcv_screen_params *p, const double size[2], float *positions,
                 float *texcoords, uint32_t *indices) {
    for (uint32_t j = 0; j < SIDE; ++j)
        for (uint32_t i = 0; i < SIDE; ++i) {
            const double xi = 2.0 * i / CELLS - 1, eta = 2.0 * j / CELLS - 1;
            float *at = positions + 3 * (size_t)(j * SIDE + i),
                  *place = texcoords + 2 * (size_t)(j * SIDE + i);
            at[0] = (float)(xi * size[0] / 2);
            at[1] = (float)(eta * size[1] / 2);
            at[2] = (float)-mcv_screen_rise(p, xi, eta);
            place[0] = (float)((1 - xi) / 2);
            place[1] = (float)((1 - eta) / 2);
        }
    for (uint32_t j = 0; j < CELLS; ++j)
        for (uint32_t i = 0; i < CELLS; ++i) {
            const uint32_t a = j * SIDE + i,
                           corners[6] = {a, a + SIDE + 1, a + 1, a, a + SIDE, a + SIDE + 1};
            memcpy(indices + 6 * (size_t)(j * CELLS + i), corners, sizeof corners);
        }
}

mcv_result mcv_load_screen(mcv_loader *loader, const char *name, const mcv_screen_params *p,
                           const double size[2], const mcv_transform *to_world,
                           const mcv_json_path *place, mcv_error *error) {
    const double bends[] = {p->sag[0], p->sag[1], p->twist, p->fourth[0], p->fourth[1]};
    bool flat = true;
    for (int i = 0; i < 5; ++i) flat = flat && bends[i] == 0;
    if (flat) return mcv_load_rectangle(loader, name, size, true, to_world, place, error);
    mcv_mesh mesh = {.name = (char *)name,
                     .vertex_count = SIDE * SIDE,
                     .triangle_count = 2 * CELLS * CELLS,
                     .positions = malloc(3 * sizeof(float) * SIDE * SIDE),
                     .texcoords = malloc(2 * sizeof(float) * SIDE * SIDE),
                     .indices = malloc(6 * sizeof(uint32_t) * CELLS * CELLS)};
    mcv_result result = MCV_OK;
    if (mesh.positions && mesh.texcoords && mesh.indices) {
        bend(p, size, mesh.positions, mesh.texcoords, mesh.indices);
        result = add_surface(loader, name, &mesh, to_world, place, error);
    } else {
        result = mcv_fail_memory(place, error);
    }
    free(mesh.positions);
    free(mesh.texcoords);
    free(mesh.indices);
    return result;
}
