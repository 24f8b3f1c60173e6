/* SPDX-License-Identifier: Apache-2.0 */
/* What `--precision mixed` needs of a scene beside the floats: their rounding errors, exact
 * surfaces and refractive indices in double. */
#include "device/pack.h"
#include "scene/geometry.h"
#include "scene/materials.h"

#include <stdlib.h>

static void pack_lows(const mcv_scene *scene, mcv_packed *packed, uint32_t instance, size_t first) {
    const mcv_mesh *mesh = &scene->meshes[scene->instances[instance].mesh];
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        const size_t at = 3 * (first + v);
        double p[3], n[3] = {0};
        mcv_scene_vertex(scene, instance, v, p);
        if (packed->normals && mesh->normals) mcv_pack_normal(scene, instance, v, n);
        for (int k = 0; k < 3; ++k) {
            packed->position_lows[at + k] =
                (float)(p[k] - packed->centre[k] - packed->positions[at + k]);
            if (packed->normals)
                packed->normal_lows[at + k] = (float)(n[k] - packed->normals[at + k]);
        }
    }
}

mcv_result mcv_pack_precise(const mcv_scene *scene, mcv_packed *packed, mcv_error *error) {
    const size_t floats = 3 * (size_t)packed->vertex_count + 1;
    packed->position_lows = calloc(floats, sizeof(float));
    if (packed->normals) packed->normal_lows = calloc(floats, sizeof(float));
    if (packed->solids)
        packed->precise_solids = calloc(packed->solid_count, sizeof *packed->precise_solids);
    if (!packed->position_lows || (packed->normals && !packed->normal_lows) ||
        (packed->solids && !packed->precise_solids))
        return mcv_fail(error, MCV_FAILED, "%s: no memory for --precision mixed", scene->path);
    size_t first = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        pack_lows(scene, packed, i, first);
        first += scene->meshes[scene->instances[i].mesh].vertex_count;
    }
    if (packed->solids) mcv_pack_precise_solids(scene, packed);
    for (int channel = 0; channel < 3; ++channel) {
        packed->refractive_indices[channel][0] = 1;
        for (uint32_t i = 0; i < packed->instance_count; ++i) {
            const uint32_t medium = packed->instances[i].medium;
            const mcv_material *material = &scene->materials[scene->instances[i].material];
            if (medium > 0)
                packed->refractive_indices[channel][medium] = material->as.medium.ior[channel];
        }
    }
    return MCV_OK;
}
