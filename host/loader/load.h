/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes from files. */
#ifndef MCVISI_HOST_LOADER_LOAD_H
#define MCVISI_HOST_LOADER_LOAD_H

#include "scene/scene.h"

/* "PATH=VALUE" as given to --set: a path into the scene (design: `sensors/cam/focalLength`) and a
 * JSON value or a string with a unit. */
typedef struct mcv_overrides {
    const char *const *items;
    size_t count;
} mcv_overrides;

/* Reads a .gltf or .glb. On failure *scene is NULL and the error names file, JSON path and what
 * would be right. */
mcv_result mcv_scene_load(const char *path, mcv_overrides overrides, mcv_scene **scene,
                          mcv_error *error);

/*
 * For scenes that are loaded many times. The cache holds the files of MCVISI_assets as they were
 * parsed. A file is read again only if it has changed since (by inode, size and times). A scene
 * does not depend on the cache. mcv_asset_cache_reads: how many assets had to be read so far.
 */
typedef struct mcv_asset_cache mcv_asset_cache;
mcv_asset_cache *mcv_asset_cache_new(void); /* NULL without memory */
void mcv_asset_cache_free(mcv_asset_cache *cache);
size_t mcv_asset_cache_reads(const mcv_asset_cache *cache);
mcv_result mcv_scene_load_cached(const char *path, mcv_overrides overrides, mcv_asset_cache *cache,
                                 mcv_scene **scene, mcv_error *error);

/* How to convert a file of another format, for error messages. */
const char *mcv_conversion(const char *path);

#endif
