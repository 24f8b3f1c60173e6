/* SPDX-License-Identifier: Apache-2.0 */
/* A scene as a whole: its memory. */
#include "scene/scene.h"

#include "scene/mesh.h"

#include <stdlib.h>
#include <string.h>

mcv_scene *mcv_scene_new(const char *path) {
    mcv_scene *scene = calloc(1, sizeof *scene);
    if (scene && !(scene->path = strdup(path))) {
        free(scene);
        return NULL;
    }
    return scene;
}

void mcv_scene_free(mcv_scene *scene) {
    if (!scene) return;
    for (uint32_t i = 0; i < scene->texture_count; ++i) {
        free(scene->textures[i].name);
        if (scene->textures[i].shares_pixels) continue;
        free(scene->textures[i].rgba);
        free(scene->textures[i].linear);
    }
    for (uint32_t i = 0; i < scene->material_count; ++i) free(scene->materials[i].name);
    for (uint32_t i = 0; i < scene->mesh_count; ++i) mcv_mesh_free(scene->meshes + i);
    for (uint32_t i = 0; i < scene->instance_count; ++i) free(scene->instances[i].name);
    for (uint32_t i = 0; i < scene->emitter_count; ++i) free(scene->emitters[i].name);
    for (uint32_t i = 0; i < scene->sensor_count; ++i) free(scene->sensors[i].name);
    for (uint32_t i = 0; i < scene->warning_count; ++i) free(scene->warnings[i]);
    free(scene->textures);
    free(scene->materials);
    free(scene->meshes);
    free(scene->instances);
    free(scene->emitters);
    free(scene->sensors);
    for (uint32_t i = 0; i < scene->frame_count; ++i) free(scene->frames[i].name);
    for (uint32_t i = 0; i < scene->defect_count; ++i) free(scene->defects[i].name);
    free(scene->defects);
    free(scene->solids);
    free(scene->frames);
    free(scene->warnings);
    free(scene->path);
    free(scene);
}
