/* SPDX-License-Identifier: Apache-2.0 */
/* glTF accessors: their descriptions, checked against their bufferViews, and their elements. */
#ifndef MCVISI_HOST_LOADER_ACCESSOR_H
#define MCVISI_HOST_LOADER_ACCESSOR_H

#include "loader/gltf.h"
#include "core/json.h"

enum {
    MCV_GLTF_BYTE = 5120,
    MCV_GLTF_UNSIGNED_BYTE = 5121,
    MCV_GLTF_SHORT = 5122,
    MCV_GLTF_UNSIGNED_SHORT = 5123,
    MCV_GLTF_UNSIGNED_INT = 5125,
    MCV_GLTF_FLOAT = 5126
};

/* Elements in a buffer. */
typedef struct mcv_buffer_span {
    uint32_t view, buffer; /* view: MCV_NONE if there is none; all elements are then 0 */
    uint64_t offset, stride,
        end;         /* bytes from the start of the buffer; end: behind the last element */
    bool has_stride; /* byteStride is given */
} mcv_buffer_span;

typedef struct mcv_accessor {
    uint32_t component_type;
    uint32_t components; /* 0: a type that glTF does not know */
    bool normalized;
    uint64_t count;
    mcv_buffer_span elements;
    uint64_t sparse_count;
    uint32_t sparse_type; /* of the indices */
    mcv_buffer_span sparse_indices, sparse_values;
} mcv_accessor;

/* Reads the member `key` of `object` as the index of an accessor. *given is false if it is
 * absent. */
mcv_result mcv_accessor_get(const json_t *root, const json_t *object, const char *key, bool *given,
                            mcv_accessor *accessor, const mcv_json_path *place, mcv_error *error);

/* Checks accessors[i] against its bufferViews: types, alignment, bounds without overflow.
 * bufferViews must be checked before. */
mcv_result mcv_accessor_check(const json_t *root, const json_t *object, mcv_accessor *accessor,
                              const mcv_json_path *place, mcv_error *error);

/* All elements as floats (normalized integers scaled as glTF says) or as integers; malloc'ed. */
mcv_result mcv_accessor_floats(const mcv_gltf *gltf, const mcv_accessor *accessor, float **values,
                               const mcv_json_path *place, mcv_error *error);
mcv_result mcv_accessor_indices(const mcv_gltf *gltf, const mcv_accessor *accessor,
                                uint32_t **values, const mcv_json_path *place, mcv_error *error);

#endif
