/* SPDX-License-Identifier: Apache-2.0 */
/* Views of buffers, accessors and their values. */
#include "strict/strict_parts.h"

#include <string.h>

static const struct {
    const char *name;
    unsigned rows, columns;
} shapes[] = {{"SCALAR", 1, 1}, {"VEC2", 2, 1}, {"VEC3", 3, 1}, {"VEC4", 4, 1},
              {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};
enum { SHAPES = sizeof shapes / sizeof shapes[0] };

static unsigned shape_of(const json_t *accessor) {
    const char *type = json_string_value(json_object_get(accessor, "type"));
    unsigned i = 0;
    while (i < SHAPES && !(type && strcmp(shapes[i].name, type) == 0)) ++i;
    return i;
}

unsigned mcv_strict_components(const json_t *accessor) {
    const unsigned shape = shape_of(accessor);
    return shape < SHAPES ? shapes[shape].rows * shapes[shape].columns : 0;
}

unsigned mcv_strict_component_bytes(uint64_t type) {
    return type == 5120 || type == 5121   ? 1
           : type == 5122 || type == 5123 ? 2
           : type == 5125 || type == 5126 ? 4
                                          : 0;
}

bool mcv_strict_has_format(const json_t *accessor, const char *type, const char *components) {
    static const char letters[] = "bBhH?If"; /* of 5120 … 5126 */
    const char *given = json_string_value(json_object_get(accessor, "type"));
    const uint64_t component = mcv_strict_uint(accessor, "componentType", 0);
    const bool normalized = json_is_true(json_object_get(accessor, "normalized"));
    if (!given || strcmp(given, type) != 0 || component < 5120 || component > 5126) return false;
    for (const char *c = components; *c; ++c)
        if (*c == letters[component - 5120] && (c[1] != 'N' || normalized)) return true;
    return false;
}

/* Bytes of the columns before column c, and of an element with or without the last padding. */
static uint64_t column_bytes(unsigned shape, uint64_t bytes) {
    const uint64_t column = shapes[shape].rows * bytes;
    return shapes[shape].columns == 1 ? column : (column + 3) / 4 * 4;
}

static uint64_t stride_of(const json_t *view, unsigned shape, uint64_t bytes) {
    return mcv_strict_uint(view, "byteStride", shapes[shape].columns * column_bytes(shape, bytes));
}

bool mcv_strict_value(const mcv_strict *s, const json_t *accessor, uint64_t i, unsigned k,
                      double *value) {
    const json_t *view = mcv_strict_target(s, accessor, "bufferView", "bufferViews");
    const uint64_t buffer = mcv_strict_uint(view, "buffer", UINT64_MAX),
                   type = mcv_strict_uint(accessor, "componentType", 0),
                   bytes = mcv_strict_component_bytes(type);
    const unsigned shape = shape_of(accessor);
    if (!view || bytes == 0 || shape == SHAPES ||
        buffer >= json_array_size(mcv_strict_list(s, "buffers")))
        return false;
    const mcv_bytes data = s->buffers[buffer];
    const uint64_t rows = shapes[shape].rows;
    const uint64_t at = mcv_strict_uint(view, "byteOffset", 0) +
                        mcv_strict_uint(accessor, "byteOffset", 0) +
                        i * stride_of(view, shape, bytes) + k / rows * column_bytes(shape, bytes) +
                        k % rows * bytes;
    if (!data.data || at > data.size || bytes > data.size - at) return false;
    union {
        int8_t b;
        uint8_t B;
        int16_t h;
        uint16_t H;
        uint32_t I;
        float f;
    } number;
    memcpy(&number, data.data + at, bytes);
    *value = type == 5120   ? number.b
             : type == 5121 ? number.B
             : type == 5122 ? number.h
             : type == 5123 ? number.H
             : type == 5125 ? number.I
                            : (double)number.f;
    return true;
}

static void check_view(mcv_strict *s, const json_t *view, const mcv_json_path *place) {
    const uint64_t length = mcv_strict_uint(view, "byteLength", 0),
                   offset = mcv_strict_uint(view, "byteOffset", 0),
                   stride = mcv_strict_uint(view, "byteStride", 0);
    const json_t *buffer = mcv_strict_target(s, view, "buffer", "buffers");
    const mcv_json_path here = mcv_json_path_key(place, "byteStride"),
                        there = mcv_json_path_key(place, "byteLength");
    if (stride % 4 != 0)
        mcv_strict_find(s, "VALUE_MULTIPLE_OF", &here, "%llu must be a multiple of 4",
                        (unsigned long long)stride);
    if (length > 0 && stride > length)
        mcv_strict_find(s, "BUFFER_VIEW_TOO_BIG_BYTE_STRIDE", &here, "exceeds the byteLength");
    const uint64_t size = mcv_strict_uint(buffer, "byteLength", UINT64_MAX);
    if (buffer && (offset > size || length > size - offset))
        mcv_strict_find(s, "BUFFER_VIEW_TOO_LONG", &there, "ends behind its buffer");
}

/* `count` elements of an object that names a bufferView. */
static void check_span(mcv_strict *s, const json_t *object, uint64_t count, unsigned shape,
                       uint64_t bytes, const mcv_json_path *place) {
    const json_t *view = mcv_strict_target(s, object, "bufferView", "bufferViews");
    const uint64_t offset = mcv_strict_uint(object, "byteOffset", 0);
    const mcv_json_path here = mcv_json_path_key(place, "byteOffset");
    const bool given = json_object_get(object, "byteOffset");
    if (bytes && offset % bytes != 0)
        mcv_strict_find(s, "ACCESSOR_OFFSET_ALIGNMENT", &here, "must be a multiple of %llu",
                        (unsigned long long)bytes);
    if (!view || bytes == 0 || shape == SHAPES) return;
    const uint64_t column = column_bytes(shape, bytes),
                   element = (shapes[shape].columns - 1) * column + shapes[shape].rows * bytes,
                   stride = stride_of(view, shape, bytes),
                   length = mcv_strict_uint(view, "byteLength", UINT64_MAX);
    if (stride < element)
        mcv_strict_find(s, "ACCESSOR_SMALL_BYTESTRIDE", place,
                        "its elements have %llu bytes, more than the byteStride",
                        (unsigned long long)element);
    if ((offset + mcv_strict_uint(view, "byteOffset", 0)) % bytes != 0)
        mcv_strict_find(s, "ACCESSOR_TOTAL_OFFSET_ALIGNMENT", place,
                        "its byte in the buffer must be a multiple of %llu",
                        (unsigned long long)bytes);
    if (count > 0 && (count - 1 > (UINT64_MAX >> 2) / stride ||
                      offset + stride * (count - 1) + element > length))
        mcv_strict_find(s, "ACCESSOR_TOO_LONG", given ? &here : place,
                        "ends behind its bufferView");
}

static void check_sparse(mcv_strict *s, const json_t *accessor, const mcv_json_path *place) {
    const json_t *sparse = json_object_get(accessor, "sparse");
    static const char *const keys[] = {"indices", "values"};
    if (!sparse) return;
    const mcv_json_path here = mcv_json_path_key(place, "sparse"),
                        there = mcv_json_path_key(&here, "count");
    const uint64_t count = mcv_strict_uint(sparse, "count", 0),
                   type = mcv_strict_uint(accessor, "componentType", 0);
    if (count > mcv_strict_uint(accessor, "count", UINT64_MAX))
        mcv_strict_find(s, "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE", &there,
                        "must not exceed the count of the accessor");
    for (int i = 0; i < 2; ++i) {
        const json_t *part = json_object_get(sparse, keys[i]);
        const mcv_json_path part_place = mcv_json_path_key(&here, keys[i]),
                            view_place = mcv_json_path_key(&part_place, "bufferView");
        const json_t *view = mcv_strict_target(s, part, "bufferView", "bufferViews");
        if (json_object_get(view, "byteStride"))
            mcv_strict_find(s, "BUFFER_VIEW_INVALID_BYTE_STRIDE", &view_place,
                            "only views of vertices may have a byteStride");
        const uint64_t own = i ? type : mcv_strict_uint(part, "componentType", 0);
        check_span(s, part, count, i ? shape_of(accessor) : 0, mcv_strict_component_bytes(own),
                   &part_place);
    }
}

/* A component of all elements against min or max, rounded as its numbers are. */
static void check_bound(mcv_strict *s, const json_t *accessor, unsigned k, bool is_max,
                        const mcv_json_path *place) {
    const json_t *bound = json_array_get(json_object_get(accessor, is_max ? "max" : "min"), k);
    const mcv_json_path all = mcv_json_path_key(place, is_max ? "max" : "min"),
                        here = mcv_place_index(&all, k);
    const uint64_t count = mcv_strict_uint(accessor, "count", 0);
    const bool is_float = mcv_strict_uint(accessor, "componentType", 0) == 5126;
    double limit = json_number_value(bound), extreme = is_max ? -INFINITY : INFINITY, value;
    if (!json_is_number(bound)) return;
    if (is_float) limit = (double)(float)limit;
    for (uint64_t i = 0; i < count; ++i) {
        if (!mcv_strict_value(s, accessor, i, k, &value)) return;
        extreme = is_max ? fmax(extreme, value) : fmin(extreme, value);
    }
    if (count == 0 || extreme == limit) return;
    mcv_strict_find(s, is_max ? "ACCESSOR_MAX_MISMATCH" : "ACCESSOR_MIN_MISMATCH", &here,
                    "%g is not the %s, %g", limit, is_max ? "maximum" : "minimum", extreme);
    if (is_max ? extreme > limit : extreme < limit)
        mcv_strict_find(
            s, is_max ? "ACCESSOR_ELEMENT_OUT_OF_MAX_BOUND" : "ACCESSOR_ELEMENT_OUT_OF_MIN_BOUND",
            &here, "elements lie beyond it");
}

static void check_values(mcv_strict *s, const json_t *accessor, const mcv_json_path *place) {
    const unsigned n = mcv_strict_components(accessor);
    const uint64_t count = mcv_strict_uint(accessor, "count", 0);
    double value;
    if (mcv_strict_uint(accessor, "componentType", 0) == 5126)
        for (uint64_t i = 0; i < count * n; ++i) {
            if (!mcv_strict_value(s, accessor, i / n, (unsigned)(i % n), &value)) break;
            if (isfinite(value)) continue;
            mcv_strict_find(s, "ACCESSOR_INVALID_FLOAT", place, "element %llu is %g",
                            (unsigned long long)(i / n), value);
            break;
        }
    if (json_object_get(accessor, "sparse")) return; /* bounds hold for what replaces, too */
    for (unsigned k = 0; k < n; ++k) {
        check_bound(s, accessor, k, false, place);
        check_bound(s, accessor, k, true, place);
    }
}

static void check_accessor(mcv_strict *s, const json_t *accessor, const mcv_json_path *place) {
    const uint64_t type = mcv_strict_uint(accessor, "componentType", 0);
    const mcv_json_path offset = mcv_json_path_key(place, "byteOffset"),
                        normalized = mcv_json_path_key(place, "normalized");
    if (json_object_get(accessor, "byteOffset") && !json_object_get(accessor, "bufferView"))
        mcv_strict_find(s, "UNSATISFIED_DEPENDENCY", &offset, "needs a bufferView");
    if (json_is_true(json_object_get(accessor, "normalized")) && (type == 5125 || type == 5126))
        mcv_strict_find(s, "ACCESSOR_NORMALIZED_INVALID", &normalized,
                        "is for integers of 8 and 16 bits");
    for (int i = 0; i < 2; ++i) {
        const json_t *bound = json_object_get(accessor, i ? "max" : "min");
        const mcv_json_path here = mcv_json_path_key(place, i ? "max" : "min");
        const unsigned n = mcv_strict_components(accessor);
        if (bound && n && json_array_size(bound) != n)
            mcv_strict_find(s, "ARRAY_LENGTH_NOT_IN_LIST", &here, "must have %u numbers", n);
    }
    check_span(s, accessor, mcv_strict_uint(accessor, "count", 0), shape_of(accessor),
               mcv_strict_component_bytes(type), place);
    check_sparse(s, accessor, place);
    check_values(s, accessor, place);
}

void mcv_strict_accessors(mcv_strict *s) {
    const mcv_json_path views = mcv_json_path_key(&s->file, "bufferViews"),
                        accessors = mcv_json_path_key(&s->file, "accessors");
    for (size_t i = 0; i < json_array_size(mcv_strict_list(s, "bufferViews")); ++i) {
        const json_t *view = mcv_strict_item(s, "bufferViews", i);
        const mcv_json_path here = mcv_place_index(&views, i);
        if (view) check_view(s, view, &here);
    }
    for (size_t i = 0; i < json_array_size(mcv_strict_list(s, "accessors")); ++i) {
        const json_t *accessor = mcv_strict_item(s, "accessors", i);
        const mcv_json_path here = mcv_place_index(&accessors, i);
        if (accessor) check_accessor(s, accessor, &here);
    }
}
