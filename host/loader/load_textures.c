/* SPDX-License-Identifier: Apache-2.0 */
/* Textures of materials: the images that they need, and the transform of an image on a mesh. */
#include "loader/loader.h"

#include "loader/validate.h"
#include "scene/memory.h"
#include "scene/mesh.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

mcv_result mcv_load_texture_source(const mcv_loader *loader, const json_t *part, const char *key,
                                   uint32_t *texture, uint32_t *source, const mcv_json_path *place,
                                   mcv_error *error) {
    const json_t *textures = json_object_get(loader->root, "textures");
    json_t *info;
    *texture = *source = MCV_NONE;
    MCV_TRY(mcv_json_object(part, key, &info, place, error));
    if (!info) return MCV_OK;
    const mcv_json_path here = mcv_json_path_key(place, key);
    MCV_TRY(mcv_json_index(info, "index", json_array_size(textures), "textures", texture, &here,
                           error));
    if (*texture == MCV_NONE) return mcv_fail_at(&here, error, "must have an index");
    return mcv_json_index(json_array_get(textures, *texture), "source", SIZE_MAX, "images", source,
                          &here, error);
}

/* Bytes that are not colours, divided by 255. */
static mcv_result decode_data(mcv_memory *memory, mcv_texture *texture, const mcv_json_path *place,
                              mcv_error *error) {
    const size_t pixels = (size_t)texture->width * texture->height;
    MCV_TRY(mcv_memory_take(memory, &memory->images, 3 * sizeof(float) * pixels, place, error));
    texture->linear = malloc(3 * sizeof(float) * pixels);
    if (!texture->linear) return mcv_fail_memory(place, error);
    for (size_t i = 0; i < pixels; ++i)
        for (size_t c = 0; c < 3; ++c)
            texture->linear[3 * i + c] = (float)(texture->rgba[4 * i + c] / 255.0);
    texture->rgba = NULL;
    texture->is_data = true;
    return MCV_OK;
}

/* KHR_texture_transform: the image's coordinates are offset + R(rotation) (scale u); positive
 * angles turn v towards u. */
static mcv_result read_transform(const json_t *info, mcv_texture *texture,
                                 const mcv_json_path *place, mcv_error *error) {
    enum { LARGEST = 65536 }; /* the largest coordinate of kernels/geometry/texture.h */
    double offset[2] = {0, 0}, rotation = 0, scale[2] = {1, 1};
    uint64_t set = 0;
    json_t *extensions, *object;
    const mcv_json_path all = mcv_json_path_key(place, "extensions"),
                        here = mcv_json_path_key(&all, "KHR_texture_transform");
    texture->texcoord_set = (uint32_t)mcv_texcoord_set(info);
    MCV_TRY(mcv_json_uint(info, "texCoord", 0, UINT32_MAX, &set, place, error));
    MCV_TRY(mcv_json_object(info, "extensions", &extensions, place, error));
    MCV_TRY(mcv_json_object(extensions, "KHR_texture_transform", &object, &all, error));
    if (!object) return MCV_OK;
    MCV_TRY(mcv_json_numbers(object, "offset", 2, -LARGEST, LARGEST, offset, &here, error));
    MCV_TRY(mcv_json_number(object, "rotation", -LARGEST, LARGEST, &rotation, &here, error));
    MCV_TRY(mcv_json_numbers(object, "scale", 2, -LARGEST, LARGEST, scale, &here, error));
    MCV_TRY(mcv_json_uint(object, "texCoord", 0, UINT32_MAX, &set, &here, error));
    const double c = cos(rotation), s = sin(rotation);
    const double transform[6] = {c * scale[0],  s * scale[1], offset[0],
                                 -s * scale[0], c * scale[1], offset[1]};
    memcpy(texture->transform, transform, sizeof transform);
    texture->is_transformed = true;
    return MCV_OK;
}

/* The scene's index of a texture with the pixels of texture `like` and the transform of
 * `placed`. */
static mcv_result place_texture(mcv_scene *scene, uint32_t like, const mcv_texture *placed,
                                uint32_t *number, const mcv_json_path *place, mcv_error *error) {
    mcv_texture own = scene->textures[like];
    for (uint32_t i = like; i < scene->texture_count; ++i) {
        const mcv_texture *t = &scene->textures[i];
        *number = i;
        if (t->rgba == own.rgba && t->linear == own.linear && t->wrap_s == own.wrap_s &&
            t->wrap_t == own.wrap_t && t->nearest == own.nearest &&
            t->texcoord_set == placed->texcoord_set &&
            t->is_transformed == placed->is_transformed &&
            memcmp(t->transform, placed->transform, sizeof t->transform) == 0)
            return MCV_OK;
    }
    own.shares_pixels = true;
    own.texcoord_set = placed->texcoord_set;
    own.is_transformed = placed->is_transformed;
    memcpy(own.transform, placed->transform, sizeof own.transform);
    own.name = strdup(own.name);
    if (!own.name) return mcv_fail_memory(place, error);
    *number = scene->texture_count;
    return mcv_scene_take_texture(scene, &own, error);
}

/* Adds a texture with the picture of images[source]; pixels that an earlier texture has are shared
 * with it. */
static mcv_result add_picture(mcv_loader *loader, uint32_t source, mcv_texture *texture,
                              bool is_data, const mcv_json_path *place, mcv_error *error) {
    const uint32_t number = loader->images[source];
    uint32_t *const first = (is_data ? loader->data_pixels : loader->pixels) + number;
    const mcv_gltf_picture *picture = &loader->gltf->pictures[number];
    mcv_scene *scene = loader->scene;
    if (*first != MCV_NONE) {
        mcv_texture own = scene->textures[*first];
        own.wrap_s = texture->wrap_s;
        own.wrap_t = texture->wrap_t;
        own.nearest = texture->nearest;
        own.is_transformed = false;
        own.texcoord_set = 0;
        memset(own.transform, 0, sizeof own.transform);
        own.shares_pixels = true;
        own.name = strdup(texture->name);
        return own.name ? mcv_scene_take_texture(scene, &own, error)
                        : mcv_fail_memory(place, error);
    }
    texture->width = picture->width;
    texture->height = picture->height;
    texture->rgba = picture->rgba;
    if (is_data) MCV_TRY(decode_data(loader->memory, texture, place, error));
    const mcv_result result = mcv_scene_add_texture(scene, texture, error);
    free(texture->linear);
    *first = scene->texture_count - 1;
    return result;
}

mcv_result mcv_load_texture(mcv_loader *loader, const json_t *part, const char *key, bool is_data,
                            uint32_t *scene_texture, const mcv_json_path *place, mcv_error *error) {
    uint32_t *const loaded = is_data ? loader->data_textures : loader->textures;
    uint32_t index, source, sampler_index;
    *scene_texture = MCV_NONE;
    MCV_TRY(mcv_load_texture_source(loader, part, key, &index, &source, place, error));
    if (source == MCV_NONE) return MCV_OK;
    const json_t *info = json_object_get(part, key);
    const mcv_json_path here = mcv_json_path_key(place, key);
    mcv_texture placed = {0};
    MCV_TRY(read_transform(info, &placed, &here, error));
    if (placed.texcoord_set > 1)
        return mcv_scene_warn(
            loader->scene, error,
            "a use of texture %u is ignored: only the sets TEXCOORD_0 and TEXCOORD_1 are "
            "supported",
            index);
    if (loaded[index] == MCV_NONE) {
        const json_t *texture = json_array_get(json_object_get(loader->root, "textures"), index);
        const json_t *samplers = json_object_get(loader->root, "samplers");
        MCV_TRY(mcv_json_index(texture, "sampler", json_array_size(samplers), "samplers",
                               &sampler_index, place, error));
        const json_t *sampler =
            sampler_index == MCV_NONE ? NULL : json_array_get(samplers, sampler_index);
        uint64_t wrap_s = 10497, wrap_t = 10497, filter = 9729;
        MCV_TRY(mcv_json_uint(sampler, "wrapS", 0, UINT32_MAX, &wrap_s, place, error));
        MCV_TRY(mcv_json_uint(sampler, "wrapT", 0, UINT32_MAX, &wrap_t, place, error));
        MCV_TRY(mcv_json_uint(sampler, "magFilter", 0, UINT32_MAX, &filter, place, error));
        mcv_texture own = {
            .wrap_s = (uint32_t)wrap_s, .wrap_t = (uint32_t)wrap_t, .nearest = filter == 9728};
        own.name = (char *)mcv_json_name(texture);
        MCV_TRY(add_picture(loader, source, &own, is_data, place, error));
        loaded[index] = loader->scene->texture_count - 1;
    }
    return place_texture(loader->scene, loaded[index], &placed, scene_texture, place, error);
}
