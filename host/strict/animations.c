/* SPDX-License-Identifier: Apache-2.0 */
/* Animations: this program does not play them, and a file may be wrong in them. */
#include "strict/strict_parts.h"

#include <string.h>

static void check_sampler(mcv_strict *s, const json_t *sampler, const mcv_json_path *place) {
    const json_t *input = mcv_strict_target(s, sampler, "input", "accessors");
    const mcv_json_path here = mcv_json_path_key(place, "input");
    double value, before = -INFINITY;
    if (!input) return;
    if (!mcv_strict_has_format(input, "SCALAR", "f")) {
        mcv_strict_find(s, "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT", &here,
                        "must be a SCALAR of floats");
        return;
    }
    if (!json_object_get(input, "min") || !json_object_get(input, "max"))
        mcv_strict_find(s, "ANIMATION_SAMPLER_INPUT_ACCESSOR_WITHOUT_BOUNDS", &here,
                        "must have min and max");
    for (uint64_t i = 0; i < mcv_strict_uint(input, "count", 0); ++i, before = value) {
        if (!mcv_strict_value(s, input, i, 0, &value)) break;
        if (value < 0)
            mcv_strict_find(s, "ACCESSOR_ANIMATION_INPUT_NEGATIVE", &here, "a time is negative");
        if (i > 0 && !(value > before))
            mcv_strict_find(s, "ACCESSOR_ANIMATION_INPUT_NON_INCREASING", &here,
                            "the times must increase");
        if (value < 0 || (i > 0 && !(value > before))) break;
    }
}

/* Keyframes of rotations have length 1; of a cubic spline the middle one of three. */
static void check_rotations(mcv_strict *s, const json_t *output, bool is_cubic,
                            const mcv_json_path *place) {
    const bool is_float = mcv_strict_uint(output, "componentType", 0) == 5126;
    for (uint64_t i = is_cubic; i < mcv_strict_uint(output, "count", 0); i += is_cubic ? 3 : 1) {
        double square = 0, value;
        for (unsigned k = 0; k < 4; ++k) {
            if (!is_float || !mcv_strict_value(s, output, i, k, &value)) return;
            square += value * value;
        }
        if (fabs(sqrt(square) - 1) <= 1e-3) continue;
        mcv_strict_find(s, "ACCESSOR_ANIMATION_SAMPLER_OUTPUT_NON_NORMALIZED_QUATERNION", place,
                        "rotation %llu has length %g", (unsigned long long)i, sqrt(square));
        return;
    }
}

static void check_output(mcv_strict *s, const json_t *sampler, const char *path, size_t targets,
                         const mcv_json_path *place) {
    static const struct {
        const char *path, *type, *components;
    } formats[] = {{"translation", "VEC3", "f"},
                   {"scale", "VEC3", "f"},
                   {"rotation", "VEC4", "fbNBNhNHN"},
                   {"weights", "SCALAR", "fbNBNhNHN"}};
    const json_t *output = mcv_strict_target(s, sampler, "output", "accessors"),
                 *input = mcv_strict_target(s, sampler, "input", "accessors");
    const char *mode = json_string_value(json_object_get(sampler, "interpolation"));
    const bool is_cubic = mode && strcmp(mode, "CUBICSPLINE") == 0;
    for (size_t i = 0; output && i < sizeof formats / sizeof formats[0]; ++i) {
        if (strcmp(formats[i].path, path) != 0) continue;
        if (!mcv_strict_has_format(output, formats[i].type, formats[i].components)) {
            mcv_strict_find(s, "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT", place,
                            "its output must be a %s", formats[i].type);
            return;
        }
        const uint64_t wanted =
            mcv_strict_uint(input, "count", 0) * (is_cubic ? 3 : 1) * (i == 3 ? targets : 1);
        if (input && wanted > 0 && mcv_strict_uint(output, "count", 0) != wanted)
            mcv_strict_find(s, "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT", place,
                            "its output must have %llu elements", (unsigned long long)wanted);
        if (i == 2) check_rotations(s, output, is_cubic, place);
    }
}

static size_t targets_of(const mcv_strict *s, const json_t *node) {
    const json_t *mesh = mcv_strict_target(s, node, "mesh", "meshes"),
                 *first = json_array_get(json_object_get(mesh, "primitives"), 0);
    return json_array_size(json_object_get(first, "targets"));
}

static void check_target(mcv_strict *s, const json_t *target, const json_t *node, const char *path,
                         const mcv_json_path *place) {
    const json_t *pointer = mcv_json_extension(target, "KHR_animation_pointer");
    const mcv_json_path all = mcv_json_path_key(place, "extensions"),
                        here = mcv_json_path_key(&all, "KHR_animation_pointer");
    const bool moves = strcmp(path, "translation") == 0 || strcmp(path, "rotation") == 0 ||
                       strcmp(path, "scale") == 0;
    if (node && moves && json_object_get(node, "matrix"))
        mcv_strict_find(s, "ANIMATION_CHANNEL_TARGET_NODE_MATRIX", place, "its node has a matrix");
    if (node && strcmp(path, "weights") == 0 && targets_of(s, node) == 0)
        mcv_strict_find(s, "ANIMATION_CHANNEL_TARGET_NODE_WEIGHTS_NO_MORPHS", place,
                        "its node has no morph targets");
    if (pointer && json_object_get(target, "node"))
        mcv_strict_find(s, "KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_NODE", &here,
                        "the target must have no node");
    if (pointer && strcmp(path, "pointer") != 0)
        mcv_strict_find(s, "KHR_ANIMATION_POINTER_ANIMATION_CHANNEL_TARGET_PATH", &here,
                        "the target's path must be \"pointer\"");
}

static void check_channel(mcv_strict *s, const json_t *channel, const json_t *samplers,
                          const mcv_json_path *place) {
    const json_t *target = json_object_get(channel, "target"),
                 *node = mcv_strict_target(s, target, "node", "nodes");
    const char *given = json_string_value(json_object_get(target, "path")),
               *path = given ? given : "";
    const mcv_json_path target_place = mcv_json_path_key(place, "target"),
                        sampler_place = mcv_json_path_key(place, "sampler");
    const uint64_t index = mcv_strict_uint(channel, "sampler", UINT64_MAX);
    if (json_is_object(target)) check_target(s, target, node, path, &target_place);
    if (index < json_array_size(samplers))
        check_output(s, json_array_get(samplers, index), path, targets_of(s, node), &sampler_place);
    else if (json_object_get(channel, "sampler"))
        mcv_strict_find(s, "UNRESOLVED_REFERENCE", &sampler_place, "there is no such sampler");
}

void mcv_strict_animations(mcv_strict *s) {
    const mcv_json_path place = mcv_json_path_key(&s->file, "animations");
    for (size_t i = 0; i < json_array_size(mcv_strict_list(s, "animations")); ++i) {
        const json_t *animation = mcv_strict_item(s, "animations", i),
                     *samplers = json_object_get(animation, "samplers"),
                     *channels = json_object_get(animation, "channels");
        const mcv_json_path here = mcv_place_index(&place, i),
                            samplers_place = mcv_json_path_key(&here, "samplers"),
                            channels_place = mcv_json_path_key(&here, "channels");
        for (size_t k = 0; k < json_array_size(samplers); ++k) {
            const mcv_json_path there = mcv_place_index(&samplers_place, k);
            check_sampler(s, json_array_get(samplers, k), &there);
        }
        for (size_t k = 0; k < json_array_size(channels); ++k) {
            const mcv_json_path there = mcv_place_index(&channels_place, k);
            check_channel(s, json_array_get(channels, k), samplers, &there);
        }
    }
}
