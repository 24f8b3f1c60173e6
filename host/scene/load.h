/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the loader share while one document is turned into a scene. */
#ifndef MCVISI_HOST_SCENE_LOAD_H
#define MCVISI_HOST_SCENE_LOAD_H

#include "scene/accessor.h"
#include "scene/scene.h"

/* A glTF mesh: its primitives are the scene's meshes first … first + count - 1 with these glTF materials. */
typedef struct mcv_loaded_mesh {
    bool loaded;
    uint32_t first, count;
    uint32_t *materials; /* of the scene */
} mcv_loaded_mesh;

/* Light that a glTF material emits; texture MCV_NONE, radiance 0 for most. */
typedef struct mcv_emission {
    double radiance[3];
    uint32_t texture;
} mcv_emission;

typedef struct mcv_loader {
    mcv_scene *scene;
    mcv_place file;
    json_t *root;
    mcv_bytes bytes, binary; /* the file; the binary chunk inside of it */
    mcv_gltf *gltf;
    uint32_t *images;       /* number in gltf of images[i], or MCV_NONE where no material needs it */
    uint32_t *textures;     /* the scene's number of textures[i], or MCV_NONE as long as no material has asked for it */
    mcv_emission *emission; /* of the scene's materials, which begin with all of the glTF */
    mcv_loaded_mesh *meshes;
    uint32_t plain, absorber; /* the scene's number of the material where none is given, of rectangles; or MCV_NONE */
    mcv_sensor *sensors;      /* the definitions in MCVISI_sensors and MCVISI_emitters */
    mcv_emitter *emitters;
    uint32_t *sensor_uses, *emitter_uses; /* nodes that refer to them */
    size_t sensor_count, emitter_count;
} mcv_loader;

/* load_materials.c: which images textures need; then materials with their textures. */
mcv_result mcv_load_needed_images(mcv_loader *loader, uint32_t *count, mcv_error *error);
mcv_result mcv_load_materials(mcv_loader *loader, mcv_error *error);

/* The scene's number of a shared material, made when first asked for. */
mcv_result mcv_load_plain(mcv_loader *loader, uint32_t *material, mcv_error *error);
mcv_result mcv_load_absorber(mcv_loader *loader, uint32_t *material, mcv_error *error);

/* load_meshes.c: the primitives of meshes[index], read when first asked for. */
mcv_result mcv_load_mesh(mcv_loader *loader, uint32_t index, mcv_error *error);

/* load_elements.c: definitions, and what a node places. Instances first … last - 1 are those of the node's mesh. */
mcv_result mcv_load_definitions(mcv_loader *loader, mcv_error *error);
mcv_result mcv_load_emitter(mcv_loader *loader, const json_t *node, const mcv_transform *to_world, uint32_t first, uint32_t last,
                            const mcv_place *place, mcv_error *error);
mcv_result mcv_load_sensors(mcv_loader *loader, const json_t *node, const mcv_transform *to_world, const mcv_place *place,
                            mcv_error *error);

#endif
