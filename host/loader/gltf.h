/* SPDX-License-Identifier: Apache-2.0 */
/* The data of a glTF document: the parts of its buffers that accessors and images need, and decoded
 * images. */
#ifndef MCVISI_HOST_LOADER_GLTF_H
#define MCVISI_HOST_LOADER_GLTF_H

#include "core/input_file.h"

/* Bytes first … first + size - 1 of a buffer. */
typedef struct mcv_gltf_part {
    uint64_t first, size;
    uint8_t *data; /* NULL where nothing of it is needed, or where it has no data */
} mcv_gltf_part;

/* 8-bit RGBA, row 0 on top. */
typedef struct mcv_gltf_picture {
    uint32_t width, height;
    uint8_t *rgba;
} mcv_gltf_picture;

typedef struct mcv_gltf {
    size_t buffer_count, picture_count;
    mcv_gltf_part *buffers;     /* as in the document */
    mcv_gltf_picture *pictures; /* by the numbers that mcv_load_need_image gives */
} mcv_gltf;

/* Room for them, all empty; NULL without memory. */
mcv_gltf *mcv_gltf_new(size_t buffer_count, size_t picture_count);
void mcv_gltf_free(mcv_gltf *gltf);

/* `size` bytes of a buffer from byte `offset` on; NULL if they were not read. */
const uint8_t *mcv_gltf_bytes(const mcv_gltf *gltf, size_t buffer, uint64_t offset, uint64_t size);

#endif
