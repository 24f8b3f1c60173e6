/* SPDX-License-Identifier: Apache-2.0 */
#include "scene/pattern.h"

#include <stdlib.h>

#define MCV_TYPE(name, key, NAME) key,
const char *const mcv_pattern_types[] = {MCV_PATTERNS(MCV_TYPE)};
#undef MCV_TYPE

mcv_param_table mcv_pattern_table(uint32_t type) {
    typedef mcv_pattern element_params;
#define MCV_X(name, key, NAME) \
    static const mcv_param name##_rows[] = {MCV_##NAME##_PARAMS(MCV_PARAM_ROW)};
    MCV_PATTERNS(MCV_X)
#undef MCV_X
    static const mcv_param_table tables[] = {
#define MCV_X(name, key, NAME) \
    {name##_rows, sizeof name##_rows / sizeof name##_rows[0], sizeof(mcv_pattern)},
        MCV_PATTERNS(MCV_X)
#undef MCV_X
    };
    return tables[type];
}

mcv_result mcv_pattern_parse(const json_t *value, mcv_pattern *pattern, const mcv_json_path *place,
                             mcv_error *error) {
    static const char *const others[] = {"type", "extras", NULL};
    uint32_t type;
    if (!json_is_object(value))
        return mcv_fail_at(place, error,
                           "must be an object with a \"type\", such as \"phaseShift\"");
    MCV_TRY(mcv_element_type(value, mcv_pattern_types, MCV_PATTERN_COUNT, &type, place, error));
    const mcv_param_table table = mcv_pattern_table(type);
    mcv_params_set_defaults(table, pattern);
    pattern->type = type;
    MCV_TRY(mcv_params_parse(table, value, others, pattern, place, error));
    return mcv_params_check(table, pattern, place, error);
}

/* The pixels across the stripes. */
static uint32_t length_of(const mcv_pattern *pattern) {
    return pattern->resolution[pattern->orientation == MCV_ORIENTATION_VERTICAL ? 0 : 1];
}

/* The bits of a Gray code of so many values; at least one. */
static uint32_t bits_of(uint32_t values) {
    uint32_t bits = 1;
    while ((values - 1) >> bits > 0) ++bits;
    return bits;
}

uint32_t mcv_pattern_count(const mcv_pattern *pattern) {
    return pattern->type == MCV_PATTERN_PHASE_SHIFT ? pattern->steps
                                                    : 2 * bits_of(length_of(pattern));
}

double mcv_pattern_value(const mcv_pattern *pattern, uint32_t index, uint32_t at) {
    if (pattern->type == MCV_PATTERN_PHASE_SHIFT)
        return 0.5 + 0.5 * cos(2 * M_PI *
                               (pattern->periods * (at + 0.5) / length_of(pattern) -
                                (double)index / pattern->steps));
    const uint32_t bits = bits_of(length_of(pattern)), gray = at ^ (at >> 1);
    return ((gray >> (bits - 1 - index % bits) & 1) == 1) != (index >= bits);
}

mcv_result mcv_pattern_image(const mcv_pattern *pattern, uint32_t index, mcv_texture *texture,
                             const mcv_json_path *place, mcv_error *error) {
    const uint32_t count = mcv_pattern_count(pattern), length = length_of(pattern);
    const bool vertical = pattern->orientation == MCV_ORIENTATION_VERTICAL;
    const mcv_json_path here = mcv_json_path_key(place, "index");
    if (index >= count)
        return mcv_fail_at(&here, error, "%u is outside the sequence, whose %u images are 0 to %u",
                           index, count, count - 1);
    texture->name = (char *)mcv_pattern_types[pattern->type];
    texture->width = vertical ? length : 1;
    texture->height = vertical ? 1 : length;
    texture->linear = malloc(3 * sizeof(float) * length);
    if (!texture->linear) return mcv_fail_memory(place, error);
    for (uint32_t at = 0; at < length; ++at)
        for (uint32_t k = 0; k < 3; ++k)
            texture->linear[3 * (size_t)at + k] = (float)mcv_pattern_value(pattern, index, at);
    return MCV_OK;
}
