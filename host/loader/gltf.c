/* SPDX-License-Identifier: Apache-2.0 */
#include "loader/gltf.h"

#include <stdlib.h>

mcv_gltf *mcv_gltf_new(size_t buffer_count, size_t picture_count) {
    mcv_gltf *gltf = calloc(1, sizeof *gltf);
    if (!gltf) return NULL;
    gltf->buffers = calloc(buffer_count + 1, sizeof *gltf->buffers);
    gltf->pictures = calloc(picture_count + 1, sizeof *gltf->pictures);
    if (gltf->buffers && gltf->pictures) {
        gltf->buffer_count = buffer_count;
        gltf->picture_count = picture_count;
        return gltf;
    }
    mcv_gltf_free(gltf);
    return NULL;
}

void mcv_gltf_free(mcv_gltf *gltf) {
    if (!gltf) return;
    for (size_t i = 0; i < gltf->buffer_count; ++i) free(gltf->buffers[i].data);
    for (size_t i = 0; i < gltf->picture_count; ++i) free(gltf->pictures[i].rgba);
    free(gltf->buffers);
    free(gltf->pictures);
    free(gltf);
}

const uint8_t *mcv_gltf_bytes(const mcv_gltf *gltf, size_t buffer, uint64_t offset, uint64_t size) {
    const mcv_gltf_part *part = &gltf->buffers[buffer];
    if (!part->data || offset < part->first || offset - part->first > part->size ||
        size > part->size - (offset - part->first))
        return NULL;
    return part->data + (offset - part->first);
}
