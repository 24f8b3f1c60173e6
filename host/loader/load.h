/* SPDX-License-Identifier: Apache-2.0 */
/* Scenes from files. */
#ifndef MCVISI_HOST_LOADER_LOAD_H
#define MCVISI_HOST_LOADER_LOAD_H

#include "core/input_file.h"
#include "scene/scene.h"

#include <jansson.h>

/* "PATH=VALUE" as given to --set: a path into the scene (design: `sensors/cam/focalLength`) and a
 * JSON value or a string with a unit. */
typedef struct mcv_overrides {
    const char *const *items;
    size_t count;
} mcv_overrides;

/*
 * Reads a .gltf or .glb. On failure *scene is NULL and the error names file, JSON path and what
 * would be right. What it takes in memory is told before it is taken, and refused above a limit:
 * `memory` bytes in the functions below, 0 and here half of the machine's.
 */
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
mcv_result mcv_scene_load_cached(const char *path, mcv_overrides overrides, uint64_t memory,
                                 mcv_asset_cache *cache, mcv_scene **scene, mcv_error *error);

/* A scene's document in memory, to be changed and loaded again and again. */
typedef struct mcv_document {
    char *path; /* what file names in it are relative to, and messages begin with */
    json_t *root;
    mcv_bytes file, binary; /* of a .glb: its bytes, and the binary chunk inside of them */
    uint64_t fingerprint;   /* of what was read */
    uint64_t memory;        /* bytes that it takes */
} mcv_document;

/* Reads a .gltf or .glb, or takes `size` bytes of JSON as if they stood in the file `path`. After
 * failure nothing is owned. */
mcv_result mcv_document_read(const char *path, mcv_document *document, mcv_error *error);
mcv_result mcv_document_parse(const char *path, const char *json, size_t size,
                              mcv_document *document, mcv_error *error);
mcv_result mcv_document_copy(const mcv_document *document, mcv_document *copy, mcv_error *error);
void mcv_document_free(mcv_document *document);

/* As mcv_scene_load_cached, of a document as it stands. cache may be NULL. */
mcv_result mcv_scene_load_document(const mcv_document *document, mcv_overrides overrides,
                                   uint64_t memory, mcv_asset_cache *cache, mcv_scene **scene,
                                   mcv_error *error);

/* How to convert a file of another format, for error messages. */
const char *mcv_conversion(const char *path);

#endif
