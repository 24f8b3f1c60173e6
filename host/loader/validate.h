/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What glTF 2.0 demands of a document, as far as this program reads it: everything that reading
 * relies on afterwards (indices, bounds, one parent per node, no loops).
 */
#ifndef MCVISI_HOST_LOADER_VALIDATE_H
#define MCVISI_HOST_LOADER_VALIDATE_H

#include "core/input_file.h"
#include "core/json.h"

/* Nodes may lie this deep. */
enum { MCV_NODE_DEPTH = 1000 };

/* `binary` as from mcv_glb_split. `file` is the place of the document. */
mcv_result mcv_gltf_validate(const json_t *root, mcv_bytes binary, const mcv_json_path *file,
                             mcv_error *error);

/* Buffers, bufferViews, images (validate_buffers.c); accessors, meshes (validate_meshes.c). */
mcv_result mcv_validate_buffers(const json_t *root, mcv_bytes binary, const mcv_json_path *file,
                                mcv_error *error);
mcv_result mcv_validate_meshes(const json_t *root, const mcv_json_path *file, mcv_error *error);

/* Calls check for each object of the root array `of`; an absent array has none. */
typedef mcv_result mcv_validate_one(const json_t *root, const json_t *object, mcv_bytes binary,
                                    const mcv_json_path *place, mcv_error *error);
mcv_result mcv_validate_each(const json_t *root, const char *of, mcv_validate_one *check,
                             mcv_bytes binary, const mcv_json_path *file, mcv_error *error);

/* The set of texture coordinates that a textureInfo asks for: KHR_texture_transform's before its
 * own. At most 1000. */
int mcv_texcoord_set(const json_t *info);

/* Is this buffer the binary chunk of the GLB? */
bool mcv_buffer_is_chunk(const json_t *root, const json_t *buffer, mcv_bytes binary);

#endif
