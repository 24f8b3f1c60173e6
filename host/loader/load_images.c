/* SPDX-License-Identifier: Apache-2.0 */
/* The images that emitters project: glTF images (PNG, JPEG) and OpenEXR files. */
#include "loader/loader.h"

#include "io/exr.h"
#include "scene/emitters.h"
#include "scene/memory.h"
#include "scene/params.h"
#include "scene/pattern.h"
#include "scene/texture.h"

#include <stdlib.h>
#include <string.h>

enum { NEAREST = 9728, CLAMP_TO_EDGE = 33071 };

/* The image with this name; an error lists the names. */
static mcv_result find_name(const json_t *images, const char *name, uint32_t *source,
                            const mcv_json_path *place, mcv_error *error) {
    const size_t count = json_array_size(images);
    const char *words[64];
    *source = MCV_NONE;
    for (size_t i = 0; i < count; ++i) {
        const char *other = mcv_json_name(json_array_get(images, i));
        if (i < 64) words[i] = other;
        if (strcmp(other, name) != 0) continue;
        if (*source != MCV_NONE)
            return mcv_fail_at(place, error,
                               "\"%s\" is the name of images %u and %zu: give the index", name,
                               *source, i);
        *source = (uint32_t)i;
    }
    if (*source != MCV_NONE) return MCV_OK;
    const char *nearest = mcv_nearest_word(name, words, count < 64 ? count : 64);
    if (nearest)
        return mcv_fail_at(place, error, "there is no image \"%s\": did you mean \"%s\"?", name,
                           nearest);
    return mcv_fail_at(place, error, "there is no image \"%s\" among the file's %zu images", name,
                       count);
}

/* The index of the emitter's `image` among the file's images, or *uri of an OpenEXR file. */
static mcv_result find_image(const mcv_loader *loader, const json_t *emitter, uint32_t *source,
                             const char **uri, const mcv_json_path *place, mcv_error *error) {
    static const char *const members[] = {"uri", "extras", "extensions", NULL};
    const json_t *images = json_object_get(loader->root, "images"),
                 *value = json_object_get(emitter, "image");
    const mcv_json_path here = mcv_json_path_key(place, "image");
    *source = MCV_NONE;
    *uri = NULL;
    if (json_is_string(value))
        return find_name(images, json_string_value(value), source, &here, error);
    if (!json_is_object(value))
        return mcv_json_index(emitter, "image", json_array_size(images), "images", source, place,
                              error);
    MCV_TRY(mcv_params_parse((mcv_param_table){0}, value, members, NULL, &here, error));
    MCV_TRY(mcv_json_string(value, "uri", uri, &here, error));
    return *uri ? MCV_OK : mcv_fail_at(&here, error, "must have the \"uri\" of an OpenEXR file");
}

static bool shows_pattern(mcv_emitter *emitter) {
    const mcv_pattern *pattern = mcv_emitter_pattern(emitter);
    return pattern && pattern->type != MCV_NONE;
}

/* Once it is made, a pattern's texture counts as its image. */
static bool shows_image(mcv_emitter *emitter) {
    const uint32_t *image = mcv_emitter_image(emitter);
    return image && *image != MCV_NONE && !shows_pattern(emitter);
}

/* The exponent from its image's values to what it sends. */
static double gamma_of(const mcv_emitter *emitter) {
    return emitter->type == MCV_EMITTER_SCREEN ? emitter->as.screen.gamma : 1;
}

/* Raises the values of a texture to a power; its pixels are then its own. */
static mcv_result apply_gamma(mcv_texture *texture, double gamma, const mcv_json_path *place,
                              mcv_error *error) {
    const uint32_t width = texture->width;
    double decoded[256], rgb[3];
    float *to = malloc(3 * sizeof *to * width * texture->height);
    if (!to) return mcv_fail_memory(place, error);
    mcv_srgb_table(decoded);
    for (size_t i = 0; i < (size_t)width * texture->height; ++i) {
        mcv_texture_value(texture, decoded, (uint32_t)(i % width), (uint32_t)(i / width), rgb);
        for (size_t k = 0; k < 3; ++k) to[3 * i + k] = (float)pow(rgb[k], gamma);
    }
    free(texture->linear);
    texture->linear = to;
    texture->rgba = NULL;
    return MCV_OK;
}

/* The picture that emitters[index] shows, as an earlier emitter's texture; MCV_NONE if it is the
 * first. */
static mcv_result find_earlier(mcv_loader *loader, const json_t *emitters, size_t index,
                               uint32_t source, const char *uri, uint32_t *texture,
                               const mcv_json_path *place, mcv_error *error) {
    *texture = MCV_NONE;
    for (size_t i = 0; i < index; ++i) {
        uint32_t other;
        const char *other_uri;
        if (!shows_image(loader->emitters + i) ||
            gamma_of(loader->emitters + i) != gamma_of(loader->emitters + index))
            continue;
        MCV_TRY(find_image(loader, json_array_get(emitters, i), &other, &other_uri, place, error));
        const bool same = uri ? other_uri && mcv_file_is_same(loader->file.key, uri, other_uri)
                              : !other_uri && loader->images[source] == loader->images[other];
        if (!same) continue;
        *texture = *mcv_emitter_image(loader->emitters + i);
        return MCV_OK;
    }
    return MCV_OK;
}

/* Counts the pixels of an OpenEXR file that no emitter before has: all its parts, and twice the
 * texture. */
static mcv_result count_exr(mcv_loader *loader, size_t index, const char *uri,
                            const mcv_json_path *place, mcv_error *error) {
    const json_t *array =
        json_object_get(mcv_json_extension(loader->root, "MCVISI_emitters"), "emitters");
    const mcv_json_path here = mcv_json_path_key(place, "image");
    uint32_t earlier;
    uint64_t file, pixels, reading;
    char *path;
    mcv_error cause = {""};
    mcv_memory *memory = loader->memory;
    MCV_TRY(find_earlier(loader, array, index, MCV_NONE, uri, &earlier, place, error));
    if (earlier != MCV_NONE) return MCV_OK;
    MCV_TRY(mcv_file_resolve(loader->file.key, uri, &path, &here, error));
    mcv_result result = mcv_file_size(path, &file, &here, &cause);
    if (result != MCV_OK) {
        /* The file is named as the scene names it. */
        const char *named = strstr(cause.text, path);
        result = mcv_fail_at(&here, error, "\"%s%s", uri, named ? named + strlen(path) : "\"");
    }
    if (result == MCV_OK) result = mcv_memory_take(memory, &memory->files, file, &here, error);
    if (result == MCV_OK && mcv_exr_size(path, &pixels, &reading, &cause) != MCV_OK)
        result =
            mcv_fail_at(&here, error, "\"%s\" cannot be read as an image: %s", uri, cause.text);
    free(path);
    MCV_TRY(result);
    return mcv_memory_take(memory, &memory->images, reading + 6 * sizeof(float) * pixels, &here,
                           error);
}

mcv_result mcv_load_needed_emitter_images(mcv_loader *loader, uint32_t *count, mcv_error *error) {
    const mcv_json_path place = mcv_json_path_key(&loader->file, "emitters");
    json_t *emitters;
    MCV_TRY(mcv_load_array(loader, "MCVISI_emitters", "emitters", &emitters, error));
    for (size_t i = 0; i < loader->emitter_count; ++i) {
        const mcv_json_path here = mcv_json_path_element(&place, loader->emitters[i].name, i);
        uint32_t source;
        const char *uri;
        if (!shows_image(loader->emitters + i)) continue;
        MCV_TRY(find_image(loader, json_array_get(emitters, i), &source, &uri, &here, error));
        if (source != MCV_NONE) mcv_load_need_image(loader, source, count);
        if (uri) MCV_TRY(count_exr(loader, i, uri, &here, error));
    }
    return MCV_OK;
}

/* Part 0 of an OpenEXR file, grey or R, G, B. */
static mcv_result copy_linear(const mcv_exr *exr, mcv_texture *texture, const char *uri,
                              const mcv_json_path *place, mcv_error *error) {
    const mcv_image *image = &exr->parts[0].image;
    const bool colour = image->channels >= 3;
    texture->width = image->width;
    texture->height = image->height;
    const size_t pixels = (size_t)image->width * image->height;
    texture->linear = malloc(3 * sizeof(float) * (pixels ? pixels : 1));
    if (!texture->linear) return mcv_fail_memory(place, error);
    for (size_t i = 0; i < pixels; ++i)
        for (size_t k = 0; k < 3; ++k) {
            const float value = image->pixels[(colour ? k : 0) * pixels + i];
            if (!(value >= 0) || !isfinite(value))
                return mcv_fail_at(place, error,
                                   "\"%s\" has the value %g in column %zu, row %zu: radiance must "
                                   "be finite and not negative",
                                   uri, value, i % image->width, i / image->width);
            texture->linear[3 * i + k] = value;
        }
    return MCV_OK;
}

static mcv_result load_exr(mcv_loader *loader, const char *uri, mcv_texture *texture,
                           const mcv_json_path *place, mcv_error *error) {
    char *path;
    mcv_exr exr;
    mcv_error cause = {""};
    MCV_TRY(mcv_file_resolve(loader->file.key, uri, &path, place, error));
    mcv_result result = mcv_exr_read_counted(path, &exr, &cause);
    free(path);
    if (result != MCV_OK)
        return mcv_fail_at(place, error, "\"%s\" cannot be read as an image: %s", uri, cause.text);
    result = copy_linear(&exr, texture, uri, place, error);
    if (result == MCV_OK)
        mcv_load_count(loader, texture->linear,
                       3 * sizeof *texture->linear * (size_t)texture->width * texture->height);
    mcv_exr_free(&exr);
    return result;
}

static void show_picture(const mcv_gltf_picture *picture, mcv_texture *texture) {
    texture->width = picture->width;
    texture->height = picture->height;
    texture->rgba = picture->rgba;
}

/* Makes the picture that the emitter shows a texture of the scene. */
static mcv_result load_picture(mcv_loader *loader, const json_t *emitters, size_t index,
                               const mcv_json_path *place, mcv_error *error) {
    mcv_emitter *emitter = loader->emitters + index;
    mcv_texture texture = {.wrap_s = CLAMP_TO_EDGE, .wrap_t = CLAMP_TO_EDGE, .nearest = true};
    const mcv_json_path here = mcv_json_path_key(place, "image");
    uint32_t source, earlier;
    const char *uri;
    mcv_result result = MCV_OK;
    if (shows_pattern(emitter)) {
        MCV_TRY(mcv_pattern_image(mcv_emitter_pattern(emitter), *mcv_emitter_index(emitter),
                                  &texture, place, error));
    } else {
        MCV_TRY(find_image(loader, json_array_get(emitters, index), &source, &uri, place, error));
        MCV_TRY(find_earlier(loader, emitters, index, source, uri, &earlier, place, error));
        if (earlier != MCV_NONE) {
            *mcv_emitter_image(emitter) = earlier;
            return MCV_OK;
        }
        if (uri)
            result = load_exr(loader, uri, &texture, &here, error);
        else
            show_picture(&loader->gltf->pictures[loader->images[source]], &texture);
        texture.name = (char *)(uri ? uri
                                    : mcv_json_name(json_array_get(
                                          json_object_get(loader->root, "images"), source)));
    }
    if (result == MCV_OK && gamma_of(emitter) != 1)
        result = apply_gamma(&texture, gamma_of(emitter), &here, error);
    if (result == MCV_OK) result = mcv_scene_add_texture(loader->scene, &texture, error);
    free(texture.linear);
    if (result == MCV_OK) *mcv_emitter_image(emitter) = loader->scene->texture_count - 1;
    return result;
}

mcv_result mcv_load_emitter_images(mcv_loader *loader, mcv_error *error) {
    const mcv_json_path place = mcv_json_path_key(&loader->file, "emitters");
    json_t *emitters;
    if (loader->is_asset) return MCV_OK;
    MCV_TRY(mcv_load_array(loader, "MCVISI_emitters", "emitters", &emitters, error));
    for (size_t i = 0; i < loader->emitter_count; ++i) {
        const mcv_json_path here = mcv_json_path_element(&place, loader->emitters[i].name, i);
        if (shows_image(loader->emitters + i) || shows_pattern(loader->emitters + i))
            MCV_TRY(load_picture(loader, emitters, i, &here, error));
    }
    return MCV_OK;
}
