/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the loader share while a document becomes a scene. */
#ifndef MCVISI_HOST_LOADER_LOADER_H
#define MCVISI_HOST_LOADER_LOADER_H

#include "loader/accessor.h"
#include "loader/load.h"
#include "scene/presets.h"
#include "mcvisi/asset.h"
#include "mcvisi/pose.h"

/* A glTF mesh: its primitives are the scene's meshes first … first + count - 1 with these
 * materials. */
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

/* A definition of MCVISI_surfaces: its solids in the body's frame, and their materials. */
typedef struct mcv_body {
    const char *name;
    uint32_t count;
    mcv_solid *solids;
    uint32_t *materials; /* 2 per solid: scene's materials of the caps and of the side; MCV_NONE:
                            the node's */
} mcv_body;

/* The state of a file before it was read. */
typedef struct mcv_stamp {
    char *path;
    uint64_t device, inode, size;
    struct timespec modified, changed;
} mcv_stamp;

/* An asset that is already parsed. */
typedef struct mcv_cached_asset {
    mcv_stamp *stamps; /* of all files that were read for it, its own first */
    size_t stamp_count;
    uint64_t fingerprint;
    json_t *root; /* of a glTF file, without its .glb's binary chunk */
    mcv_gltf *gltf;
    mcv_scene *solid; /* an STL file's mesh, or NULL */
    double size[3];   /* and its box */
} mcv_cached_asset;

typedef struct mcv_loader {
    mcv_scene *scene;
    mcv_memory *memory; /* the scene's, or that of a document without scene */
    mcv_json_path file;
    bool is_asset; /* placed by another document: its cameras, sensors and non-emissive emitters are
                      ignored */
    bool moves;    /* parts of the node that is being placed do */
    double unit;   /* of an asset's lengths [m] */
    uint32_t solid;      /* the scene's mesh of an asset that is an STL file; MCV_NONE for glTF */
    double crease_angle; /* of an asset's vertex normals [rad], or NaN: normals are the file's */
    uint32_t asset_material; /* the scene's index of the material that replaces all of an asset's,
                                or MCV_NONE */
    const struct mcv_loader *placer;  /* of an asset: the document that places it, */
    const json_t *entry;              /* its entry there and */
    const mcv_json_path *entry_place; /* where that stands; valid until it is open */
    json_t *root;
    mcv_bytes bytes, binary; /* the file; the binary chunk inside of it */
    mcv_gltf *gltf;
    mcv_asset_cache *cache; /* or NULL */
    bool is_cached;         /* root and gltf are those of a cached asset */
    mcv_stamp *stamps;      /* of the files that were read, for an asset that will be cached */
    size_t stamp_count;
    uint64_t fingerprint;    /* of this document's files and its assets */
    uint32_t *images;        /* the picture in gltf of images[i]; MCV_NONE: nothing needs it */
    uint32_t *textures;      /* the scene's index of textures[i], or MCV_NONE while no material has
                                needed it */
    uint32_t *data_textures; /* the same for textures that are not colours */
    uint32_t *pixels, *data_pixels; /* the scene's first texture with picture i; or MCV_NONE */
    uint32_t *materials;            /* the scene's index of materials[i], or of its replacement */
    uint32_t *node_materials; /* of an asset: the scene's material of nodes[i] and the nodes below,
                                 or MCV_NONE */
    mcv_emission *emission;   /* of materials[i] */
    mcv_loaded_mesh *meshes;
    uint32_t plain, absorber; /* the scene's indices of the default material and of that of
                                 rectangles; or MCV_NONE */
    mcv_sensor *sensors;      /* the definitions in MCVISI_sensors and MCVISI_emitters */
    mcv_emitter *emitters;
    mcv_preset *presets;                  /* of the emitters */
    uint32_t *sensor_uses, *emitter_uses; /* nodes that refer to them */
    size_t sensor_count, emitter_count;
    mcv_emitter *lights; /* of KHR_lights_punctual */
    size_t light_count;
    mcv_body *bodies; /* the definitions in MCVISI_surfaces */
    size_t body_count;
    struct mcv_frames *frames; /* of nodes that poses refer to; NULL before the first */
    struct mcv_loader *assets; /* MCVISI_assets */
    char **asset_paths;
    size_t asset_count;
} mcv_loader;

/* What the files below need of each other. Each calls only those before it, with two exceptions: to
 * open a document is to open those of its assets, and a pose has targets that are posed. */

/* asset_cache.c: the asset at a path, or NULL; adds what an asset's loader has parsed. Assets that
 * have changed on disk are dropped at the begin of a load: until its end, its loaders share the
 * cache. */
mcv_result mcv_stamp_add(mcv_loader *loader, const char *path, const mcv_json_path *place,
                         mcv_error *error);
void mcv_stamps_free(mcv_stamp *stamps, size_t count);
const mcv_cached_asset *mcv_asset_cache_find(const mcv_asset_cache *cache, const char *path);
mcv_result mcv_asset_cache_add(mcv_loader *asset, const double size[3], const mcv_json_path *place,
                               mcv_error *error);
void mcv_asset_cache_drop_changed(mcv_asset_cache *cache);

/* load_extensions.c: whether all required extensions are read; one line about what is ignored. */
mcv_result mcv_check_extensions(const json_t *root, const mcv_json_path *file, mcv_error *error);
mcv_result mcv_load_warn_ignored(mcv_loader *loader, mcv_error *error);

/* load_reference.c: the array extensions/EXTENSION/KEY of the document, and a node's index {"KEY":
 * i} into it. */
mcv_result mcv_load_array(const mcv_loader *loader, const char *extension, const char *key,
                          json_t **array, mcv_error *error);
mcv_result mcv_load_reference(const json_t *node, const char *extension, const char *key,
                              size_t count, const char *of, uint32_t *index,
                              const mcv_json_path *place, mcv_error *error);

/* load_data.c: gives images[source] a picture in gltf, one for each file; there are *count. Then
 * reads what is needed of buffers, and all these pictures. */
void mcv_load_need_image(mcv_loader *loader, uint32_t source, uint32_t *count);
mcv_result mcv_load_data(mcv_loader *loader, uint32_t picture_count, mcv_error *error);

/* load_textures.c: the member `key` of a material (or its part) as numbers of a texture and its
 * image; MCV_NONE where absent. */
mcv_result mcv_load_texture_source(const mcv_loader *loader, const json_t *part, const char *key,
                                   uint32_t *texture, uint32_t *source, const mcv_json_path *place,
                                   mcv_error *error);

/* load_textures.c: the same as the scene's number of a texture; data where it holds no colour. */
mcv_result mcv_load_texture(mcv_loader *loader, const json_t *part, const char *key, bool data,
                            uint32_t *scene_texture, const mcv_json_path *place, mcv_error *error);

/* load_materials.c: which images textures need; then materials with their textures. */
mcv_result mcv_load_needed_images(mcv_loader *loader, uint32_t *count, mcv_error *error);
mcv_result mcv_load_materials(mcv_loader *loader, mcv_error *error);

/* load_materials.c: the scene's number of a shared material, made when first asked for. */
mcv_result mcv_load_plain(mcv_loader *loader, uint32_t *material, mcv_error *error);
mcv_result mcv_load_absorber(mcv_loader *loader, uint32_t *material, mcv_error *error);

/* load_images.c: marks the images that emitters project as needed; then makes textures of them and
 * sets `image` in loader->emitters. */
mcv_result mcv_load_needed_emitter_images(mcv_loader *loader, uint32_t *count, mcv_error *error);
mcv_result mcv_load_emitter_images(mcv_loader *loader, mcv_error *error);

/* load_replaced.c: which of an asset's materials and nodes get materials of the scene, by its entry
 * (mcvisi/asset.h). */
mcv_result mcv_load_replaced(mcv_loader *asset, mcv_error *error);

/* load_replaced.c: the scene's number of the material object[key] (index or name in the document);
 * MCV_NONE where absent. */
mcv_result mcv_load_find_material(const mcv_loader *loader, const json_t *object, const char *key,
                                  uint32_t *material, const mcv_json_path *place, mcv_error *error);

/* load_meshes.c: the primitives of meshes[index], read when first asked for. */
mcv_result mcv_load_mesh(mcv_loader *loader, uint32_t index, mcv_error *error);

/* load_rectangle.c: adds a screen of this size as a new instance, a mesh where it is not flat. */
mcv_result mcv_load_screen(mcv_loader *loader, const char *name, const mcv_screen_params *p,
                           const double size[2], const mcv_transform *to_world,
                           const mcv_json_path *place, mcv_error *error);

/* load_rectangle.c: adds a rectangle in the node's xy plane as a new instance. Its front faces -z.
 * `mirror` swaps left and right of its image. */
mcv_result mcv_load_rectangle(mcv_loader *loader, const char *name, const double size[2],
                              bool mirror, const mcv_transform *to_world,
                              const mcv_json_path *place, mcv_error *error);

/* load_presets.c: adds the preset's instances; the first emits. */
mcv_result mcv_load_preset(mcv_loader *loader, const mcv_preset *preset, const char *name,
                           const mcv_transform *to_world, const mcv_json_path *place,
                           mcv_error *error);

/* load_motion.c: MCVISI_motion of a node; all 0 without. On a node without a sensor it moves the
 * parts on it and below it: sets loader->moves, and the scene's part_motion. */
mcv_result mcv_load_motion(const json_t *node, mcv_node_motion *motion, const mcv_json_path *place,
                           mcv_error *error);
mcv_result mcv_load_part_motion(mcv_loader *loader, const json_t *node, const mcv_json_path *place,
                                mcv_error *error);

/* load_elements.c: definitions, and what a node places. Instances first … last - 1 are those of the
 * node's mesh. */
mcv_result mcv_load_definitions(mcv_loader *loader, mcv_error *error);
mcv_result mcv_load_emitter(mcv_loader *loader, const json_t *node, const mcv_transform *to_world,
                            uint32_t first, uint32_t last, const mcv_json_path *place,
                            mcv_error *error);

/* load_sensors.c: members of each sensor and emitter beside its parameters, NULL at the end; the
 * first exposure of an object of MCVISI_sensors (all are checked); and what a node places. */
extern const char *const mcv_element_keys[];

mcv_result mcv_define_sensor(const json_t *object, mcv_sensor *sensor, const mcv_json_path *place,
                             mcv_error *error);

mcv_result mcv_load_sensors(mcv_loader *loader, const json_t *node, const mcv_transform *to_world,
                            const mcv_json_path *place, mcv_error *error);

/* load_lights.c: the lights of KHR_lights_punctual, and the one that a node places. */
mcv_result mcv_load_lights(mcv_loader *loader, mcv_error *error);
mcv_result mcv_load_light(mcv_loader *loader, const json_t *node, const mcv_transform *to_world,
                          const mcv_json_path *place, mcv_error *error);

/* load_surfaces.c: definitions of MCVISI_surfaces, and the body that a node places. */
mcv_result mcv_load_bodies(mcv_loader *loader, mcv_error *error);
mcv_result mcv_load_body(mcv_loader *loader, const json_t *node, const mcv_transform *to_world,
                         const mcv_json_path *place, mcv_error *error);
void mcv_load_free_bodies(mcv_loader *loader);

/* load_defects.c: the defects of MCVISI_defects, when all nodes are placed. */
mcv_result mcv_load_defects(mcv_loader *loader, mcv_error *error);

/* load_pose.c: a node's transform below its parent; or, by its MCVISI_pose, if it has one, in the
 * document's frame. depth counts targets and parents followed so far. */
mcv_result mcv_load_local(const json_t *node, mcv_transform *transform, const mcv_json_path *place,
                          mcv_error *error);
mcv_result mcv_load_pose(mcv_loader *loader, const json_t *node, int depth, bool *posed,
                         mcv_transform *transform, const mcv_json_path *place, mcv_error *error);

/* load_frames.c: the node of a name; a node's transform in the document's frame, by its pose or by
 * way of all parents. load_pose.c calls these, and is called by them. */
mcv_result mcv_load_find_node(mcv_loader *loader, const char *name, uint32_t *index,
                              const mcv_json_path *place, mcv_error *error);
mcv_result mcv_load_transform(mcv_loader *loader, uint32_t index, int depth,
                              mcv_transform *transform, mcv_error *error);
void mcv_load_free_frames(mcv_loader *loader);

/* load_misalignment.c: changes a node's transform, in the frame that it is in, by its
 * MCVISI_misalignment, if it has one. Targets of poses do not follow. */
mcv_result mcv_load_misalignment(const json_t *node, mcv_transform *local,
                                 const mcv_json_path *place, mcv_error *error);

/* load_document.c: reads a file and counts it in the fingerprint; counts what else is part of it.
 */
mcv_result mcv_load_file(mcv_loader *loader, const char *path, mcv_bytes *bytes,
                         const mcv_json_path *place, mcv_error *error);
void mcv_load_count(mcv_loader *loader, const void *data, size_t size);

/* load_document.c: the tree of loader->bytes, and its binary chunk. */
mcv_result mcv_load_json(mcv_loader *loader, mcv_error *error);

/* load_document.c: parses loader->bytes (or continues with a root, or with a root and buffers from
 * the cache) up to the materials; frees what a loader holds. */
mcv_result mcv_load_open(mcv_loader *loader, mcv_overrides overrides, mcv_error *error);
void mcv_load_finish(mcv_loader *loader);

/* load_assets.c: opens the documents of MCVISI_assets; the one that a node places (its extension
 * object's "asset"), or NULL. */
mcv_result mcv_load_assets(mcv_loader *loader, mcv_error *error);
mcv_result mcv_load_asset_of(const mcv_loader *loader, const json_t *node,
                             struct mcv_loader **asset, const mcv_json_path *place,
                             mcv_error *error);

/* load_nodes.c: places the nodes of the document's scene. `document` is the frame of its root in
 * the world. */
mcv_result mcv_load_nodes(mcv_loader *loader, const mcv_transform *document, mcv_error *error);

#endif
