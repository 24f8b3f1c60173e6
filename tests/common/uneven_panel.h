/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A panel whose normals differ by 1 µrad: it has no common normal, so that nothing is sampled in
 * its cone, and shines as an even one does. What the tests of cone sampling compare with.
 */
#ifndef MCVISI_TESTS_UNEVEN_PANEL_H
#define MCVISI_TESTS_UNEVEN_PANEL_H

#include "scene_builder.h"

/* As add_rectangle. */
static inline uint32_t add_panel(mcv_scene *scene, double width, double height, bool even,
                                 mcv_transform to_world) {
    const float x = (float)(width / 2);
    const float y = (float)(height / 2);
    float positions[] = {-x, -y, 0, x, -y, 0, x, y, 0, -x, y, 0};
    float normals[] = {even ? 0 : 1e-6f, 0, -1, 0, 0, -1, 0, 0, -1, 0, 0, -1};
    uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    return add_instance(scene,
                        &(mcv_mesh){.vertex_count = 4,
                                    .triangle_count = 2,
                                    .positions = positions,
                                    .normals = normals,
                                    .indices = indices},
                        add_absorber(scene), to_world);
}

#endif
