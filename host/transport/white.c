/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/white.h"

#include <stdlib.h>
#include <string.h>

#include "device/pack.h"
#include "scene/params.h"
#include "scene/texture.h"

enum { MOST_ELEMENTS = 1 << 30 };

/* Whether the pixels of its image send light of their own: nothing is interpolated between them. */
static bool has_pixels(const mcv_scene *scene, const mcv_emitter *emitter) {
    if (emitter->texture == MCV_NONE || emitter->type == MCV_EMITTER_ENVIRONMENT) return false;
    return emitter->type == MCV_EMITTER_LIGHT_FIELD_EMITTER ||
           emitter->type == MCV_EMITTER_PROJECTOR || scene->textures[emitter->texture].nearest;
}

/* Replaces the emitter's image by one of ones. */
static mcv_result whiten(mcv_scene *scene, uint32_t index, mcv_error *error) {
    mcv_texture white = scene->textures[scene->emitters[index].texture];
    const size_t values = 3 * (size_t)white.width * white.height;
    white.rgba = NULL;
    white.linear = malloc(values * sizeof *white.linear);
    if (!white.linear)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for a white image", scene->path);
    for (size_t i = 0; i < values; ++i) white.linear[i] = 1;
    const mcv_result result = mcv_scene_add_texture(scene, &white, error);
    free(white.linear);
    scene->emitters[index].texture = scene->texture_count - 1;
    return result;
}

/* The values of the emitter's image, or ones, in the matrix's pattern. */
static void copy_pattern(const mcv_scene *scene, const mcv_emitter *emitter,
                         const mcv_element_group *group, uint32_t channels, float *pattern) {
    double decoded[256], rgb[3] = {1, 1, 1};
    mcv_srgb_table(decoded);
    for (uint32_t i = 0; i < group->width * group->height; ++i) {
        float *to = pattern + ((size_t)group->first + i) * channels;
        if (emitter->by_pixel)
            mcv_texture_value(scene->textures + emitter->texture, decoded, i % group->width,
                              i / group->width, rgb);
        for (uint32_t c = 0; c < channels; ++c)
            // NOLINTNEXTLINE(clang-analyzer-core.uninitialized.Assign): channels are 1 or 3
            to[c] = (float)(channels == 1 ? (rgb[0] + rgb[1] + rgb[2]) / 3 : rgb[c]);
    }
}

static mcv_result describe(const mcv_scene *scene, uint32_t index, uint32_t first,
                           mcv_element_group *group, mcv_error *error) {
    const mcv_emitter *e = scene->emitters + index;
    const mcv_transform *place =
        e->instance == MCV_NONE ? &e->to_world : &scene->instances[e->instance].to_world;
    *group = (mcv_element_group){.emitter = strdup(e->name ? e->name : ""),
                                 .type = strdup(mcv_emitter_types[e->type]),
                                 .first = first,
                                 .width = 1,
                                 .height = 1};
    if (e->by_pixel) {
        group->width = scene->textures[e->texture].width;
        group->height = scene->textures[e->texture].height;
    }
    memcpy(group->radiance, e->radiance, sizeof group->radiance);
    memcpy(group->to_world, place->m, sizeof group->to_world);
    if (e->type == MCV_EMITTER_LIGHT_FIELD_EMITTER) {
        const mcv_light_field_emitter_params *p = &e->as.light_field_emitter;
        memcpy(group->angular, p->angularResolution, sizeof group->angular);
        group->angular_range = p->angularRange;
    }
    return group->emitter && group->type
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "%s: no memory for its elements", scene->path);
}

mcv_result mcv_scene_elements(const mcv_scene *scene, uint32_t *count, mcv_error *error) {
    uint64_t all = 0;
    for (uint32_t i = 0; i < scene->emitter_count; ++i)
        all += mcv_emitter_elements(scene, scene->emitters + i);
    if (all == 0)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: the scene has no emitter: a matrix has a column for each",
                        scene->path);
    if (all > MOST_ELEMENTS)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "%s: its emitters have %llu pixels, of which a matrix holds at most 2^30: "
                        "give --elements lamps",
                        scene->path, (unsigned long long)all);
    *count = (uint32_t)all;
    return MCV_OK;
}

mcv_result mcv_scene_show_white(mcv_scene *scene, bool lamps, uint32_t channels, mcv_matrix *matrix,
                                mcv_error *error) {
    uint32_t elements = 0, first = 0;
    for (uint32_t i = 0; i < scene->emitter_count && !lamps; ++i)
        scene->emitters[i].by_pixel = has_pixels(scene, scene->emitters + i);
    MCV_TRY(mcv_scene_elements(scene, &elements, error));
    matrix->groups = calloc(scene->emitter_count, sizeof *matrix->groups);
    matrix->pattern = malloc((size_t)elements * channels * sizeof *matrix->pattern);
    if (!matrix->groups || !matrix->pattern)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for %u elements", scene->path, elements);
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        mcv_element_group *group = matrix->groups + matrix->group_count++;
        MCV_TRY(describe(scene, i, first, group, error));
        copy_pattern(scene, scene->emitters + i, group, channels, matrix->pattern);
        first += group->width * group->height;
        if (scene->emitters[i].by_pixel) MCV_TRY(whiten(scene, i, error));
    }
    return MCV_OK;
}
