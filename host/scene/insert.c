/* SPDX-License-Identifier: Apache-2.0 */
/* Instances that join those of a node: the numbers of the others move on. */
#include "scene/scene.h"

#include <string.h>

/* The number of an instance, or of the end of a range, once one more stands behind `after`. */
static void move_on(uint32_t *number, uint32_t after) {
    if (*number != MCV_NONE && *number > after) ++*number;
}

static void renumber(mcv_scene *scene, uint32_t after) {
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        move_on(&scene->emitters[i].instance, after);
    for (uint32_t i = 0; i < scene->solid_count; ++i)
        for (int piece = 0; piece < 3; ++piece) move_on(&scene->solids[i].instances[piece], after);
    for (int end = 0; end < 2; ++end) {
        for (uint32_t i = 0; i < scene->frame_count; ++i)
            move_on(&scene->frames[i].instances[end], after);
        for (uint32_t i = 0; i < scene->defect_count; ++i)
            move_on(&scene->defects[i].instances[end], after);
    }
}

mcv_result mcv_scene_number_triangles(mcv_scene *scene, const mcv_json_path *place,
                                      mcv_error *error) {
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        scene->instances[i].first_triangle = (uint32_t)triangles;
        triangles += scene->meshes[scene->instances[i].mesh].triangle_count;
        if (triangles > INT32_MAX)
            return mcv_fail_at(place, error, "with it the scene has more than %d triangles",
                               INT32_MAX);
    }
    scene->triangle_count = (uint32_t)triangles;
    return MCV_OK;
}

mcv_result mcv_scene_insert_instance(mcv_scene *scene, uint32_t after, const mcv_instance *instance,
                                     mcv_error *error) {
    MCV_TRY(mcv_scene_add_instance(scene, instance, error));
    mcv_instance *all = scene->instances;
    const uint32_t last = scene->instance_count - 1, place = after + 1;
    const mcv_instance own = all[last];
    memmove(all + place + 1, all + place, (last - place) * sizeof *all);
    all[place] = own;
    renumber(scene, after);
    uint32_t first = 0;
    for (uint32_t i = 0; i <= last; ++i) {
        all[i].first_triangle = first;
        first += scene->meshes[all[i].mesh].triangle_count;
    }
    return MCV_OK;
}
