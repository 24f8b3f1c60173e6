/* SPDX-License-Identifier: Apache-2.0 */
/* Rectangles that emit or reflect: instances of a mesh of two triangles. */
#include "loader/loader.h"

#include "scene/mesh.h"
#include "scene/transform.h"

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
    mcv_instance instance = {.name = (char *)name, .mesh = loader->scene->mesh_count};
    if (!mcv_transform_rigid(to_world, &instance.to_world))
        return mcv_fail_at(place, error, "its scale must not be 0");
    MCV_TRY(mcv_load_absorber(loader, &instance.material, error));
    MCV_TRY(mcv_scene_add_mesh(loader->scene, &mesh, error));
    return mcv_scene_add_instance(loader->scene, &instance, error);
}
