/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/memory.h"

uint64_t mcv_memory_total(const mcv_memory *memory) {
    return memory->files + memory->images + memory->geometry;
}

uint64_t mcv_memory_left(const mcv_memory *memory) {
    const uint64_t total = mcv_memory_total(memory);
    if (memory->limit == 0) return UINT64_MAX;
    return total < memory->limit ? memory->limit - total : 0;
}

mcv_result mcv_memory_take(mcv_memory *memory, uint64_t *part, uint64_t bytes,
                           const mcv_json_path *place, mcv_error *error) {
    const uint64_t total = mcv_memory_total(memory), left = mcv_memory_left(memory);
    *part += bytes;
    if (bytes <= left) return MCV_OK;
    return mcv_fail_at(place, error,
                       "with it the scene takes %.4g MB (files %.4g, images %.4g, geometry %.4g), "
                       "more than the limit of %.4g MB: raise it by --memory",
                       1e-6 * ((double)total + (double)bytes), 1e-6 * (double)memory->files,
                       1e-6 * (double)memory->images, 1e-6 * (double)memory->geometry,
                       1e-6 * (double)memory->limit);
}

/* jansson's nodes with their share of malloc: an object has a hash table of 8 buckets, an array
 * room for 8 values; a member has its pair and bucket, a value its node. */
uint64_t mcv_memory_of_json(const char *text, size_t size) {
    enum { OBJECT = 304, ARRAY = 144, VALUE = 48, MEMBER = 64 };
    uint64_t bytes = size;
    bool quoted = false;
    for (size_t i = 0; i < size; ++i) {
        const char c = text[i];
        if (c == '"') quoted = !quoted;
        if (quoted && c == '\\') ++i;
        if (quoted) continue;
        bytes += c == '{' ? OBJECT : c == '[' ? ARRAY : c == ',' ? VALUE : c == ':' ? MEMBER : 0;
    }
    return bytes;
}
