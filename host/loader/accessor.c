/* SPDX-License-Identifier: Apache-2.0 */
#include "loader/accessor.h"

#include "mcvisi/dialect.h"

#include <stdlib.h>

/* The largest count of an accessor without a bufferView, which no bytes bound. Real files have
 * small counts there. */
static const uint64_t unbacked_limit = 1 << 24;

static uint64_t component_size(uint32_t type) {
    return type == MCV_GLTF_BYTE || type == MCV_GLTF_UNSIGNED_BYTE     ? 1
           : type == MCV_GLTF_SHORT || type == MCV_GLTF_UNSIGNED_SHORT ? 2
                                                                       : 4;
}

static bool is_component_type(uint64_t type) {
    return (type >= MCV_GLTF_BYTE && type <= MCV_GLTF_UNSIGNED_SHORT) ||
           type == MCV_GLTF_UNSIGNED_INT || type == MCV_GLTF_FLOAT;
}

/* Bytes of an element; columns of matrices start at multiples of four bytes. *least: those that its
 * components take, without what pads the last column. */
static uint64_t element_size(const char *type, uint32_t component_type, uint32_t *components,
                             uint64_t *least) {
    static const struct {
        const char *name;
        uint32_t rows, columns;
    } types[] = {{"SCALAR", 1, 1}, {"VEC2", 2, 1}, {"VEC3", 3, 1}, {"VEC4", 4, 1},
                 {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i)
        if (strcmp(types[i].name, type) == 0) {
            const uint64_t column = types[i].rows * component_size(component_type);
            *components = types[i].rows * types[i].columns;
            const uint64_t padded = types[i].columns == 1 ? column : (column + 3) / 4 * 4;
            *least = (types[i].columns - 1) * padded + column;
            return types[i].columns * padded;
        }
    *components = 0;
    *least = 0;
    return 0;
}

/* Checks `count` elements of `size` bytes, the last of at least `least`, with components of
 * `component` bytes, in the bufferView that `object` names. */
static mcv_result check_span(const json_t *root, const json_t *object, uint64_t count,
                             uint64_t size, uint64_t least, uint64_t component,
                             mcv_buffer_span *span, const mcv_json_path *place, mcv_error *error) {
    const json_t *views = json_object_get(root, "bufferViews");
    uint64_t offset = 0, view_offset = 0, length = 0, stride = 0, buffer = 0;
    const mcv_json_path here = mcv_json_path_key(place, "byteOffset");
    *span = (mcv_buffer_span){.view = MCV_NONE, .stride = size};
    MCV_TRY(mcv_json_index(object, "bufferView", json_array_size(views), "bufferViews", &span->view,
                           place, error));
    MCV_TRY(mcv_json_uint(object, "byteOffset", 0, 1ull << 53, &offset, place, error));
    if (span->view == MCV_NONE)
        return json_object_get(object, "byteOffset")
                   ? mcv_fail_at(&here, error, "needs a bufferView, from which it counts")
                   : MCV_OK;
    const json_t *view = json_array_get(views, span->view);
    MCV_TRY(mcv_json_uint(view, "byteOffset", 0, 1ull << 53, &view_offset, place, error));
    MCV_TRY(mcv_json_uint(view, "byteLength", 1, 1ull << 53, &length, place, error));
    MCV_TRY(mcv_json_uint(view, "byteStride", 4, 252, &stride, place, error));
    MCV_TRY(mcv_json_uint(view, "buffer", 0, UINT32_MAX, &buffer, place, error));
    span->buffer = (uint32_t)buffer;
    span->offset = view_offset + offset;
    span->has_stride = stride != 0;
    if (stride) span->stride = stride;
    if (span->stride < least)
        return mcv_fail_at(
            place, error,
            "elements of %llu bytes overlap in bufferView %u with its byteStride of %llu",
            (unsigned long long)size, span->view, (unsigned long long)span->stride);
    if (offset % component != 0 || span->offset % component != 0)
        return mcv_fail_at(
            &here, error,
            "%llu, %llu in the buffer, must be a multiple of the component's %llu bytes",
            (unsigned long long)offset, (unsigned long long)span->offset,
            (unsigned long long)component);
    if (count - 1 > (UINT64_MAX >> 1) / span->stride ||
        offset + span->stride * (count - 1) + least > length)
        return mcv_fail_at(
            place, error,
            "%llu elements of %llu bytes from byte %llu on exceed the %llu bytes of bufferView %u",
            (unsigned long long)count, (unsigned long long)span->stride, (unsigned long long)offset,
            (unsigned long long)length, span->view);
    span->end = span->offset + span->stride * (count - 1) + least;
    return MCV_OK;
}

static mcv_result check_sparse(const json_t *root, json_t *sparse, uint64_t size, uint64_t least,
                               mcv_accessor *accessor, const mcv_json_path *place,
                               mcv_error *error) {
    json_t *indices, *values;
    uint64_t type = 0;
    MCV_TRY(
        mcv_json_uint(sparse, "count", 1, accessor->count, &accessor->sparse_count, place, error));
    MCV_TRY(mcv_json_object(sparse, "indices", &indices, place, error));
    MCV_TRY(mcv_json_object(sparse, "values", &values, place, error));
    if (!indices || !values || accessor->sparse_count == 0)
        return mcv_fail_at(place, error, "must have count, indices and values");
    const mcv_json_path indices_place = mcv_json_path_key(place, "indices"),
                        values_place = mcv_json_path_key(place, "values");
    MCV_TRY(mcv_json_uint(indices, "componentType", 0, UINT32_MAX, &type, &indices_place, error));
    if (type != MCV_GLTF_UNSIGNED_BYTE && type != MCV_GLTF_UNSIGNED_SHORT &&
        type != MCV_GLTF_UNSIGNED_INT)
        return mcv_fail_at(&indices_place, error,
                           "componentType %u must be 5121, 5123 or 5125 (unsigned)",
                           (unsigned)type);
    accessor->sparse_type = (uint32_t)type;
    const uint64_t index_size = component_size(accessor->sparse_type);
    MCV_TRY(check_span(root, indices, accessor->sparse_count, index_size, index_size, index_size,
                       &accessor->sparse_indices, &indices_place, error));
    MCV_TRY(check_span(root, values, accessor->sparse_count, size, least,
                       component_size(accessor->component_type), &accessor->sparse_values,
                       &values_place, error));
    if (accessor->sparse_indices.view == MCV_NONE || accessor->sparse_values.view == MCV_NONE)
        return mcv_fail_at(place, error, "indices and values must have a bufferView");
    if (accessor->sparse_indices.has_stride || accessor->sparse_values.has_stride)
        return mcv_fail_at(place, error,
                           "bufferViews of sparse indices and values must be without byteStride");
    return MCV_OK;
}

mcv_result mcv_accessor_check(const json_t *root, const json_t *object, mcv_accessor *accessor,
                              const mcv_json_path *place, mcv_error *error) {
    *accessor = (mcv_accessor){.elements = {.view = MCV_NONE}};
    uint64_t type = 0;
    const char *shape = NULL;
    json_t *sparse;
    MCV_TRY(mcv_json_uint(object, "componentType", 0, UINT32_MAX, &type, place, error));
    MCV_TRY(mcv_json_uint(object, "count", 1, UINT32_MAX, &accessor->count, place, error));
    MCV_TRY(mcv_json_string(object, "type", &shape, place, error));
    MCV_TRY(mcv_json_bool(object, "normalized", &accessor->normalized, place, error));
    MCV_TRY(mcv_json_object(object, "sparse", &sparse, place, error));
    if (!shape || accessor->count == 0 || !json_object_get(object, "componentType"))
        return mcv_fail_at(place, error, "must have componentType, count and type");
    if (!is_component_type(type))
        return mcv_fail_at(place, error,
                           "componentType %u must be 5120, 5121, 5122, 5123, 5125 or 5126",
                           (unsigned)type);
    accessor->component_type = (uint32_t)type;
    if (accessor->normalized && type >= MCV_GLTF_UNSIGNED_INT)
        return mcv_fail_at(place, error, "normalized is for integers of 8 and 16 bits only");
    uint64_t least;
    const uint64_t size =
        element_size(shape, accessor->component_type, &accessor->components, &least);
    if (accessor->components == 0) return MCV_OK; /* whatever uses the accessor reports the type */
    MCV_TRY(check_span(root, object, accessor->count, size, least,
                       component_size(accessor->component_type), &accessor->elements, place,
                       error));
    if (accessor->elements.view == MCV_NONE && accessor->count > unbacked_limit)
        return mcv_fail_at(place, error, "%llu elements without a bufferView are more than 2^24",
                           (unsigned long long)accessor->count);
    if (!sparse) return MCV_OK;
    const mcv_json_path here = mcv_json_path_key(place, "sparse");
    return check_sparse(root, sparse, size, least, accessor, &here, error);
}

mcv_result mcv_accessor_get(const json_t *root, const json_t *object, const char *key, bool *given,
                            mcv_accessor *accessor, const mcv_json_path *place, mcv_error *error) {
    const json_t *accessors = json_object_get(root, "accessors");
    uint32_t index;
    MCV_TRY(
        mcv_json_index(object, key, json_array_size(accessors), "accessors", &index, place, error));
    *given = index != MCV_NONE;
    if (!*given) return MCV_OK;
    const mcv_json_path here = mcv_json_path_key(place, key);
    return mcv_accessor_check(root, json_array_get(accessors, index), accessor, &here, error);
}

/* --- reading --- */

static double component(const uint8_t *p, uint32_t type) {
    uint16_t u16;
    int16_t i16;
    uint32_t u32;
    float f32;
    switch (type) {
    case MCV_GLTF_BYTE:
        return (int8_t)*p;
    case MCV_GLTF_UNSIGNED_BYTE:
        return *p;
    case MCV_GLTF_SHORT:
        memcpy(&i16, p, sizeof i16);
        return i16;
    case MCV_GLTF_UNSIGNED_SHORT:
        memcpy(&u16, p, sizeof u16);
        return u16;
    case MCV_GLTF_UNSIGNED_INT:
        memcpy(&u32, p, sizeof u32);
        return u32;
    default:
        memcpy(&f32, p, sizeof f32);
        return (double)f32;
    }
}

/* Normalized integers: the largest is 1; the two most negative values are both -1. */
static float scaled(double value, const mcv_accessor *accessor) {
    static const double largest[] = {127, 255, 32767, 65535};
    if (!accessor->normalized) return (float)value;
    /* Validation lets only integers be normalized. */
    // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult)
    return (float)fmax(value / largest[accessor->component_type - MCV_GLTF_BYTE], -1);
}

static const uint8_t *element(const mcv_gltf *gltf, const mcv_buffer_span *span, uint64_t i) {
    return mcv_gltf_bytes(gltf, span->buffer, span->offset + i * span->stride, 1);
}

/* A buffer may be declared without data. */
static mcv_result check_data(const mcv_gltf *gltf, const mcv_buffer_span *span,
                             const mcv_json_path *place, mcv_error *error) {
    if (span->view == MCV_NONE ||
        mcv_gltf_bytes(gltf, span->buffer, span->offset, span->end - span->offset))
        return MCV_OK;
    return mcv_fail_at(place, error, "buffer %u has no data: give it a uri", span->buffer);
}

static mcv_result check_all_data(const mcv_gltf *gltf, const mcv_accessor *accessor,
                                 const mcv_json_path *place, mcv_error *error) {
    MCV_TRY(check_data(gltf, &accessor->elements, place, error));
    if (accessor->sparse_count == 0) return MCV_OK;
    MCV_TRY(check_data(gltf, &accessor->sparse_indices, place, error));
    return check_data(gltf, &accessor->sparse_values, place, error);
}

/* The index of the element that the k-th sparse value replaces; indices must increase. */
static mcv_result sparse_target(const mcv_gltf *gltf, const mcv_accessor *accessor, uint64_t k,
                                uint64_t *target, const mcv_json_path *place, mcv_error *error) {
    const uint64_t index =
        (uint64_t)component(element(gltf, &accessor->sparse_indices, k), accessor->sparse_type);
    if (index >= accessor->count || (k > 0 && index <= *target))
        return mcv_fail_at(
            place, error,
            "sparse index %llu must lie below the count of %llu and above the one before it",
            (unsigned long long)index, (unsigned long long)accessor->count);
    *target = index;
    return MCV_OK;
}

mcv_result mcv_accessor_floats(const mcv_gltf *gltf, const mcv_accessor *accessor, float **values,
                               const mcv_json_path *place, mcv_error *error) {
    MCV_TRY(check_all_data(gltf, accessor, place, error));
    const uint32_t n = accessor->components, type = accessor->component_type;
    const uint64_t size = component_size(type);
    float *out = *values = calloc(accessor->count, n * sizeof *out);
    if (!out) return mcv_fail_memory(place, error);
    for (uint64_t i = 0; accessor->elements.view != MCV_NONE && i < accessor->count; ++i) {
        const uint8_t *p = element(gltf, &accessor->elements, i);
        if (type == MCV_GLTF_FLOAT)
            memcpy(out + i * n, p, n * sizeof *out);
        else
            for (uint32_t j = 0; j < n; ++j)
                out[i * n + j] = scaled(component(p + j * size, type), accessor);
    }
    uint64_t target = 0;
    for (uint64_t k = 0; k < accessor->sparse_count; ++k) {
        MCV_TRY(sparse_target(gltf, accessor, k, &target, place, error));
        const uint8_t *p = element(gltf, &accessor->sparse_values, k);
        for (uint32_t j = 0; j < n; ++j)
            out[target * n + j] = scaled(component(p + j * size, type), accessor);
    }
    return MCV_OK;
}

mcv_result mcv_accessor_indices(const mcv_gltf *gltf, const mcv_accessor *accessor,
                                uint32_t **values, const mcv_json_path *place, mcv_error *error) {
    MCV_TRY(check_all_data(gltf, accessor, place, error));
    uint32_t *out = *values = calloc(accessor->count, sizeof *out);
    if (!out) return mcv_fail_memory(place, error);
    for (uint64_t i = 0; accessor->elements.view != MCV_NONE && i < accessor->count; ++i)
        out[i] =
            (uint32_t)component(element(gltf, &accessor->elements, i), accessor->component_type);
    uint64_t target = 0;
    for (uint64_t k = 0; k < accessor->sparse_count; ++k) {
        MCV_TRY(sparse_target(gltf, accessor, k, &target, place, error));
        out[target] = (uint32_t)component(element(gltf, &accessor->sparse_values, k),
                                          accessor->component_type);
    }
    return MCV_OK;
}
