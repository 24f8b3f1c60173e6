/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/white.h"

#include <stdlib.h>
#include <string.h>

#include "device/pack.h"
#include "scene/emitters.h"
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

/* The pixels of a column or row of a group, in the image. */
static uint32_t last_pixel(uint32_t element, uint32_t bin, uint32_t pixels) {
    return (element + 1) * bin < pixels ? (element + 1) * bin : pixels;
}

/* The mean of the pixels of an element. */
static void mean_of_element(const mcv_texture *image, const double decoded[256],
                            const mcv_element_group *group, uint32_t element, double mean[3]) {
    const uint32_t x = element % group->width, y = element / group->width;
    double sum[3] = {0}, rgb[3];
    uint32_t count = 0;
    for (uint32_t row = y * group->binning[1];
         row < last_pixel(y, group->binning[1], image->height); ++row)
        for (uint32_t column = x * group->binning[0];
             column < last_pixel(x, group->binning[0], image->width); ++column, ++count) {
            mcv_texture_value(image, decoded, column, row, rgb);
            for (int k = 0; k < 3; ++k) sum[k] += rgb[k];
        }
    for (int k = 0; k < 3; ++k) mean[k] = sum[k] / count;
}

/* The values of the emitter's image, or ones, in the matrix's pattern. */
static void copy_pattern(const mcv_scene *scene, const mcv_emitter *emitter,
                         const mcv_element_group *group, uint32_t channels, float *pattern) {
    double decoded[256], rgb[3] = {1, 1, 1};
    mcv_srgb_table(decoded);
    for (uint32_t i = 0; i < group->width * group->height; ++i) {
        float *to = pattern + ((size_t)group->first + i) * channels;
        if (emitter->by_pixel)
            mean_of_element(scene->textures + emitter->texture, decoded, group, i, rgb);
        for (uint32_t c = 0; c < channels; ++c)
            // NOLINTNEXTLINE(clang-analyzer-core.uninitialized.Assign): channels are 1 or 3
            to[c] = (float)(channels == 1 ? (rgb[0] + rgb[1] + rgb[2]) / 3 : rgb[c]);
    }
}

/* Where its elements lie. */
static void describe_place(const mcv_scene *scene, const mcv_emitter *e, mcv_element_group *group) {
    const mcv_transform *place =
        e->instance == MCV_NONE ? &e->to_world : &scene->instances[e->instance].to_world;
    memcpy(group->to_world, place->m, sizeof group->to_world);
    mcv_emitter_size(scene, e, group->size);
    for (int i = 0; i < 2; ++i)
        if (!(group->size[i] > 0)) group->size[i] = 0;
    group->mirror = mcv_emitter_mirrors(e);
    if (e->type != MCV_EMITTER_PROJECTOR) return;
    const mcv_projector_params *p = &e->as.projector;
    uint32_t pixels[2];
    mcv_picture_resolution(&p->pattern, scene->textures + e->texture, pixels);
    for (int i = 0; i < 2; ++i)
        group->slope_range[i] = pixels[i] * p->pixelSize[i] / p->imageDistance;
}

static mcv_result describe_pixels(const mcv_scene *scene, const mcv_emitter *e, uint32_t bin,
                                  mcv_element_group *group, mcv_error *error) {
    const mcv_light_field_emitter_params *p = &e->as.light_field_emitter;
    const bool directions = e->type == MCV_EMITTER_LIGHT_FIELD_EMITTER;
    const uint32_t pixels[2] = {scene->textures[e->texture].width,
                                scene->textures[e->texture].height};
    for (int i = 0; i < 2; ++i) {
        const uint32_t most = directions ? p->angularResolution[i] : pixels[i];
        group->binning[i] = bin < most ? bin : most;
        if (directions && most % group->binning[i] > 0)
            return mcv_fail(error, MCV_USAGE,
                            "--bin %u: must divide the %u x %u directions of emitter \"%s\"", bin,
                            p->angularResolution[0], p->angularResolution[1], e->name);
    }
    group->width = (pixels[0] + group->binning[0] - 1) / group->binning[0];
    group->height = (pixels[1] + group->binning[1] - 1) / group->binning[1];
    return MCV_OK;
}

static mcv_result describe(const mcv_scene *scene, uint32_t index, uint32_t first, uint32_t bin,
                           mcv_element_group *group, mcv_error *error) {
    const mcv_emitter *e = scene->emitters + index;
    *group = (mcv_element_group){.emitter = strdup(e->name ? e->name : ""),
                                 .type = strdup(mcv_emitter_types[e->type]),
                                 .first = first,
                                 .width = 1,
                                 .height = 1,
                                 .binning = {1, 1}};
    if (!group->emitter || !group->type)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for its elements", scene->path);
    if (e->by_pixel) MCV_TRY(describe_pixels(scene, e, bin, group, error));
    memcpy(group->radiance, e->radiance, sizeof group->radiance);
    describe_place(scene, e, group);
    if (e->type == MCV_EMITTER_LIGHT_FIELD_EMITTER) {
        const mcv_light_field_emitter_params *p = &e->as.light_field_emitter;
        for (int i = 0; i < 2; ++i) group->angular[i] = p->angularResolution[i] / group->binning[i];
        group->angular_range = p->angularRange;
    }
    return MCV_OK;
}

/* The column of each element of the scene. */
static mcv_result list_columns(const mcv_scene *scene, uint32_t elements, const mcv_matrix *matrix,
                               uint32_t **columns, mcv_error *error) {
    uint32_t *to = *columns = malloc(elements * sizeof *to);
    if (!to) return mcv_fail(error, MCV_FAILED, "%s: no memory for its elements", scene->path);
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_element_group *g = matrix->groups + i;
        const uint32_t count = mcv_emitter_elements(scene, scene->emitters + i),
                       width = count > 1 ? scene->textures[scene->emitters[i].texture].width : 1;
        for (uint32_t k = 0; k < count; ++k)
            *to++ = g->first + k / width / g->binning[1] * g->width + k % width / g->binning[0];
    }
    return MCV_OK;
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

mcv_result mcv_scene_show_white(mcv_scene *scene, bool lamps, uint32_t bin, uint32_t channels,
                                mcv_matrix *matrix, uint32_t **columns, mcv_error *error) {
    uint32_t elements = 0, first = 0;
    *columns = NULL;
    for (uint32_t i = 0; i < scene->emitter_count && !lamps; ++i)
        scene->emitters[i].by_pixel = has_pixels(scene, scene->emitters + i);
    MCV_TRY(mcv_scene_elements(scene, &elements, error));
    matrix->groups = calloc(scene->emitter_count, sizeof *matrix->groups);
    matrix->pattern = malloc((size_t)elements * channels * sizeof *matrix->pattern);
    if (!matrix->groups || !matrix->pattern)
        return mcv_fail(error, MCV_FAILED, "%s: no memory for %u elements", scene->path, elements);
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        mcv_element_group *group = matrix->groups + matrix->group_count++;
        MCV_TRY(describe(scene, i, first, bin, group, error));
        copy_pattern(scene, scene->emitters + i, group, channels, matrix->pattern);
        first += group->width * group->height;
        if (scene->emitters[i].by_pixel) MCV_TRY(whiten(scene, i, error));
    }
    return first < elements ? list_columns(scene, elements, matrix, columns, error) : MCV_OK;
}
