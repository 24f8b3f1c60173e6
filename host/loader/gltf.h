/* SPDX-License-Identifier: Apache-2.0 */
/*
 * tinygltf behind a C interface: buffers, data URIs and images of a glTF document. The document
 * must be validated before, because tinygltf 2.7.0 does not check offsets. No exception leaves this
 * interface.
 */
#ifndef MCVISI_HOST_LOADER_GLTF_H
#define MCVISI_HOST_LOADER_GLTF_H

#include "core/input_file.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mcv_gltf mcv_gltf;

/* Reads the contents of a URI other than data:, malloc'ed: the binary chunk or a file. */
typedef mcv_result mcv_gltf_read(void *user, const char *uri, mcv_bytes *bytes, mcv_error *error);

/* `json` contains only buffers, bufferViews and images; the names of images are those for
 * messages. */
mcv_result mcv_gltf_open(const char *json, size_t length, mcv_gltf_read *read, void *user,
                         mcv_gltf **gltf, const mcv_json_path *place, mcv_error *error);
void mcv_gltf_close(mcv_gltf *gltf);

/* The contents of buffers[index]: at least byteLength bytes. */
mcv_bytes mcv_gltf_buffer(const mcv_gltf *gltf, size_t index);

/* The pixels of images[index], 8-bit RGBA, row 0 on top; valid until closed. */
const uint8_t *mcv_gltf_image(const mcv_gltf *gltf, size_t index, uint32_t *width,
                              uint32_t *height);

#ifdef __cplusplus
}
#endif
#endif
