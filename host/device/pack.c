/* SPDX-License-Identifier: Apache-2.0 */
#include "device/pack.h"

#include <stdlib.h>
#include <string.h>

#include "device/features.h"
#include "device/pack_glossy.h"
#include "device/light.h"
#include "device/pack_steps.h"
#include "scene/emitters.h"
#include "scene/mesh.h"
#include "scene/geometry.h"
#include "scene/materials.h"
#include "scene/spectra.h"

void *mcv_pack_allocate(size_t count, size_t size, bool *failed) {
    void *memory = calloc(count > 0 ? count : 1, size);
    if (!memory) *failed = true;
    return memory;
}

void mcv_packed_free(mcv_packed *packed) {
    free(packed->boxes);
    free(packed->positions);
    free(packed->normals);
    free(packed->texcoords);
    free(packed->tangents);
    free(packed->indices);
    free(packed->triangles);
    free(packed->instances);
    free(packed->materials);
    free(packed->glossy);
    free(packed->albedos);
    free(packed->albedo_sources);
    free(packed->contact_grid);
    free(packed->emitters);
    free(packed->emitter_cdf);
    free(packed->light_tree);
    free(packed->textures);
    free(packed->texels);
    free(packed->solids);
    free(packed->position_lows);
    free(packed->normal_lows);
    free(packed->precise_solids);
    memset(packed, 0, sizeof *packed);
}

/* The boxes of the instances, and how many vertices they have. */
static mcv_result place_boxes(const mcv_scene *scene, mcv_packed *packed, mcv_error *error) {
    uint64_t vertices = 0;
    bool failed = false;
    packed->boxes = mcv_pack_allocate(scene->instance_count, sizeof *packed->boxes, &failed);
    if (failed) return mcv_fail(error, MCV_FAILED, "%s: no memory to place the scene", scene->path);
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        vertices += scene->meshes[scene->instances[i].mesh].vertex_count;
        mcv_scene_box(scene, i, packed->boxes[i].lower, packed->boxes[i].upper);
    }
    /* The kernels count the coordinates of the vertices in 32 bits. */
    if (vertices > UINT32_MAX / 3) {
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "%s: nodes: %llu vertices after placing all meshes, at most %u can be rendered",
            scene->path, (unsigned long long)vertices, UINT32_MAX / 3);
    }
    packed->vertex_count = (uint32_t)vertices;
    mcv_find_centre(packed->boxes, scene->instance_count, packed->centre);
    return MCV_OK;
}

static void count_textures(const mcv_scene *scene, mcv_packed *packed) {
    packed->texture_count = scene->texture_count;
    packed->texel_count = 256;
    packed->texcoord_sets = 1;
    for (uint32_t i = 0; i < scene->texture_count; ++i) {
        const mcv_texture *texture = &scene->textures[i];
        if (!texture->shares_pixels)
            packed->texel_count += mcv_texel_words(texture) * texture->width * texture->height;
        if (packed->features >> MCV_FEATURE_TEXTURE & 1 && texture->texcoord_set > 0)
            packed->texcoord_sets = 2;
    }
}

/* The emitters that are sampled, and the entries of their tables. */
static void count_emitters(const mcv_scene *scene, mcv_packed *packed) {
    packed->cdf_count = 2;
    for (uint32_t i = 0; i < scene->emitter_count; ++i) {
        const mcv_emitter *emitter = &scene->emitters[i];
        if (!mcv_is_sampled(emitter)) {
            for (int k = 0; k < 3; ++k) packed->environment[k] = (float)emitter->radiance[k];
            continue;
        }
        ++packed->emitter_count;
        packed->cdf_count += 2;
        if (emitter->type == MCV_EMITTER_ENVIRONMENT)
            packed->cdf_count += mcv_environment_entries(scene->textures + emitter->texture);
        packed->cdf_count += mcv_laser_entries(scene, emitter);
        if (mcv_emitter_has_surface(emitter->type))
            packed->cdf_count +=
                1 + scene->meshes[scene->instances[emitter->instance].mesh].triangle_count;
    }
}

static mcv_result allocate_arrays(const mcv_scene *scene, mcv_packed *p, mcv_error *error) {
    const size_t vertices = p->vertex_count, triangles = scene->triangle_count;
    bool failed = false;
    p->positions = mcv_pack_allocate(3 * vertices, sizeof(float), &failed);
    if (p->features >> MCV_FEATURE_NORMALS & 1)
        p->normals = mcv_pack_allocate(3 * vertices, sizeof(float), &failed);
    if (p->features >> MCV_FEATURE_TEXTURE & 1)
        p->texcoords = mcv_pack_allocate(2 * p->texcoord_sets * vertices, sizeof(float), &failed);
    if (p->features >> MCV_FEATURE_GLOSSY & 1)
        p->glossy = mcv_pack_allocate(scene->material_count, sizeof *p->glossy, &failed);
    if (mcv_scene_has_directions(scene))
        p->tangents = mcv_pack_allocate(4 * vertices, sizeof(float), &failed);
    p->indices = mcv_pack_allocate(3 * triangles, sizeof(uint32_t), &failed);
    p->triangles = mcv_pack_allocate(4 * triangles, sizeof(uint32_t), &failed);
    p->instances = mcv_pack_allocate(scene->instance_count, sizeof *p->instances, &failed);
    p->materials = mcv_pack_allocate(scene->material_count, sizeof *p->materials, &failed);
    p->emitters = mcv_pack_allocate(p->emitter_count, sizeof *p->emitters, &failed);
    p->emitter_cdf = mcv_pack_allocate(p->cdf_count, sizeof(uint32_t), &failed);
    p->textures = mcv_pack_allocate(scene->texture_count, sizeof *p->textures, &failed);
    if (scene->solid_count > 0)
        p->solids = mcv_pack_allocate(scene->solid_count, sizeof *p->solids, &failed);
    p->texels = mcv_pack_allocate(p->texel_count, sizeof(uint32_t), &failed);
    if (failed)
        return mcv_fail(error, MCV_FAILED, "%s: no memory to place %u triangles with %u vertices",
                        scene->path, scene->triangle_count, p->vertex_count);
    return MCV_OK;
}

static void pack_instances(const mcv_scene *scene, mcv_packed *packed) {
    uint32_t first_vertex = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const mcv_instance *instance = &scene->instances[i];
        packed->instances[i] = (mcv_device_instance){.material = instance->material,
                                                     .emitter = MCV_NONE,
                                                     .first_triangle = instance->first_triangle,
                                                     .moves = instance->moves};
        packed->moves = packed->moves || instance->moves;
        mcv_pack_instance(scene, packed, i, first_vertex);
        first_vertex += scene->meshes[instance->mesh].vertex_count;
    }
}

static mcv_result pack_all(const mcv_scene *scene, const mcv_packed *earlier, mcv_packed *packed,
                           mcv_error *error) {
    const mcv_feature_options usual = {0};
    MCV_TRY(place_boxes(scene, packed, error));
    /* Which arrays there are depends on materials and emitters alone. */
    packed->features = mcv_decide_features(scene, packed, NULL, usual, NULL);
    packed->channels = mcv_scene_channels(scene);
    packed->triangle_count = scene->triangle_count;
    packed->instance_count = scene->instance_count;
    packed->material_count = scene->material_count;
    packed->solid_count = scene->solid_count;
    count_textures(scene, packed);
    count_emitters(scene, packed);
    MCV_TRY(allocate_arrays(scene, packed, error));

    pack_instances(scene, packed);
    for (uint32_t i = 0; i < scene->material_count; ++i)
        packed->materials[i] = mcv_pack_material(&scene->materials[i]);
    mcv_pack_textures(scene, packed);
    if (packed->glossy) MCV_TRY(mcv_pack_glossy(scene, earlier, packed, error));
    if (packed->solids) mcv_pack_solids(scene, packed);
    MCV_TRY(mcv_pack_media(scene, earlier, packed, error));
    MCV_TRY(mcv_pack_contacts(scene, packed, error));
    MCV_TRY(mcv_pack_emitters(scene, packed, error));
    packed->features = mcv_decide_features(scene, packed, NULL, usual, NULL);
    MCV_TRY(mcv_pack_light(scene, packed, packed->emitter_cdf + packed->light_cdf, error));
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        packed->instances[i].shading = mcv_instance_shading(packed, &packed->instances[i]);
    return MCV_OK;
}

static mcv_result pack_or_free(const mcv_scene *scene, const mcv_packed *earlier,
                               mcv_packed *packed, mcv_error *error) {
    const mcv_result result = pack_all(scene, earlier, packed, error);
    if (result != MCV_OK) mcv_packed_free(packed);
    return result;
}

mcv_result mcv_pack(const mcv_scene *scene, const mcv_packed *earlier, mcv_packed *packed,
                    mcv_error *error) {
    *packed = (mcv_packed){.for_features_alone = false};
    return pack_or_free(scene, earlier, packed, error);
}

mcv_result mcv_pack_for_features(const mcv_scene *scene, mcv_packed *packed, mcv_error *error) {
    *packed = (mcv_packed){.for_features_alone = true};
    return pack_or_free(scene, NULL, packed, error);
}
