/* SPDX-License-Identifier: Apache-2.0 */
/* PNG and JPEG images, decoded by tinygltf's stb_image behind a C interface. No exception leaves
 * it. */
#ifndef MCVISI_HOST_LOADER_IMAGE_H
#define MCVISI_HOST_LOADER_IMAGE_H

#include "loader/gltf.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The size of an image by its header alone; an error where it is neither PNG nor JPEG, or has more
 * than 2^27 pixels. */
mcv_result mcv_image_size(mcv_bytes file, uint32_t *width, uint32_t *height,
                          const mcv_json_path *place, mcv_error *error);

/* 8-bit RGBA; picture->rgba is malloc'ed. */
mcv_result mcv_image_decode(mcv_bytes file, mcv_gltf_picture *picture, const mcv_json_path *place,
                            mcv_error *error);

#ifdef __cplusplus
}
#endif
#endif
