/* SPDX-License-Identifier: Apache-2.0 */
/* Adds elements to a scene. Each is copied, checked and resolved. */
#include "scene/scene.h"

#include "core/basics.h"
#include "scene/emitters.h"
#include "scene/mesh.h"
#include "scene/params.h"
#include "scene/sensors.h"
#include "scene/solid.h"
#include "scene/spectra.h"
#include "scene/transform.h"
#include "scene/materials.h"

#include <float.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/*
 * Appends a copy of `element` to *array. The capacity is the power of two at or above count, so it
 * need not be stored. The sizes are those of an element.
 */
static bool append(void *array, uint32_t *count, const void *element, size_t size) {
    void *elements;
    memcpy(&elements, array, sizeof elements);
    if ((*count & (*count - 1)) == 0) {
        void *larger = realloc(elements, (*count ? 2 * (size_t)*count : 1) * size);
        if (!larger) return false;
        elements = larger;
        memcpy(array, &elements, sizeof elements);
    }
    memcpy((char *)elements + *count * size, element, size);
    ++*count;
    return true;
}

/* A copy of an optional array; sets *failed without memory. */
static void *copy(const void *from, size_t size, bool *failed) {
    if (!from) return NULL;
    void *to = malloc(size ? size : 1);
    if (to)
        memcpy(to, from, size);
    else
        *failed = true;
    return to;
}

static char *copy_name(const char *name, bool *failed) {
    return copy(name ? name : "", name ? strlen(name) + 1 : 1, failed);
}

/* FILE: KIND/NAME, for the messages of the add functions. */
typedef struct element_place {
    mcv_json_path file, kind, element;
} element_place;

static const mcv_json_path *place_element(element_place *place, const mcv_scene *scene,
                                          const char *kind, const char *name, uint32_t index) {
    place->file = mcv_place_file(scene->path);
    place->kind = mcv_json_path_key(&place->file, kind);
    place->element = mcv_json_path_element(&place->kind, name, index);
    return &place->element;
}

mcv_result mcv_scene_take_texture(mcv_scene *scene, mcv_texture *texture, mcv_error *error) {
    const mcv_json_path file = mcv_place_file(scene->path);
    if (append(&scene->textures, &scene->texture_count, texture, sizeof *texture)) return MCV_OK;
    free(texture->name);
    if (!texture->shares_pixels) {
        free(texture->rgba);
        free(texture->linear);
    }
    return mcv_fail_memory(&file, error);
}

mcv_result mcv_scene_add_texture(mcv_scene *scene, const mcv_texture *texture, mcv_error *error) {
    element_place place;
    const mcv_json_path *here =
        place_element(&place, scene, "textures", texture->name, scene->texture_count);
    if (texture->width == 0 || texture->height == 0 || !texture->rgba == !texture->linear)
        return mcv_fail_at(here, error, "must have pixels");
    bool failed = false;
    mcv_texture own = *texture;
    own.shares_pixels = false;
    own.name = copy_name(texture->name, &failed);
    own.rgba = copy(texture->rgba, 4 * (size_t)texture->width * texture->height, &failed);
    own.linear =
        copy(texture->linear, 3 * sizeof(float) * texture->width * texture->height, &failed);
    if (!failed) return mcv_scene_take_texture(scene, &own, error);
    free(own.name);
    free(own.rgba);
    free(own.linear);
    return mcv_fail_memory(here, error);
}

static mcv_result check_shares(const double reflectance[3], const char *key, const double other[3],
                               const mcv_json_path *here, mcv_error *error) {
    for (int k = 0; k < 3; ++k)
        if (reflectance[k] + other[k] > 1)
            return mcv_fail_at(here, error,
                               "reflectance %g and %s %g must not be more than 1 together",
                               reflectance[k], key, other[k]);
    return MCV_OK;
}

/* Rules that concern several parameters. */
static mcv_result check_material(const mcv_material *material, const mcv_json_path *here,
                                 mcv_error *error) {
    if (mcv_material_has_medium(material->type) &&
        material->as.medium.priority != floor(material->as.medium.priority))
        return mcv_fail_at(here, error, "priority %g must be an integer",
                           material->as.medium.priority);
    if (material->type == MCV_MATERIAL_DIFFUSE)
        return check_shares(material->as.diffuse.reflectance, "transmittance",
                            material->as.diffuse.transmittance, here, error);
    if (material->type == MCV_MATERIAL_BEAM_SPLITTER)
        return check_shares(material->as.beam_splitter.reflectance, "transmittance",
                            material->as.beam_splitter.transmittance, here, error);
    if (material->type == MCV_MATERIAL_RETROREFLECTOR)
        return check_shares(material->as.retroreflector.reflectance, "diffuseReflectance",
                            material->as.retroreflector.diffuseReflectance, here, error);
    return MCV_OK;
}

mcv_result mcv_scene_add_material(mcv_scene *scene, const mcv_material *material,
                                  mcv_error *error) {
    element_place place;
    const mcv_json_path *here =
        place_element(&place, scene, "materials", material->name, scene->material_count);
    if (material->type >= MCV_MATERIAL_COUNT)
        return mcv_fail_at(here, error, "%u is not a type of material", material->type);
    if (material->texture != MCV_NONE && material->texture >= scene->texture_count)
        return mcv_fail_at(here, error, "texture %u does not exist", material->texture);
    const uint32_t surface_texture = mcv_material_surface_texture(material);
    if (surface_texture != MCV_NONE &&
        (surface_texture >= scene->texture_count || !scene->textures[surface_texture].linear))
        return mcv_fail_at(here, error, "texture %u does not exist or is not linear",
                           surface_texture);
    MCV_TRY(mcv_params_check(mcv_material_table(material->type), &material->as, here, error));
    MCV_TRY(check_material(material, here, error));
    bool failed = false;
    mcv_material own = *material;
    mcv_conductor_params *metal = own.type == MCV_MATERIAL_CONDUCTOR ? &own.as.conductor : NULL;
    if (metal && isnan(metal->n[0]) != isnan(metal->k[0]))
        return mcv_fail_at(here, error, "n and k must be given together");
    own.by_name = metal && isnan(metal->n[0]);
    const mcv_medium_params *glass = mcv_material_has_medium(own.type) ? &own.as.medium : NULL;
    if (glass && glass->glass > 0) {
        if (!mcv_is_grey(glass->ior) || glass->ior[0] != 1.5) /* 1.5: none is given */
            return mcv_fail_at(here, error, "has both glass and ior: give one of them");
        if (glass->abbeNumber > 0)
            return mcv_fail_at(here, error, "has both glass and abbeNumber: give one of them");
    }
    if (glass && glass->abbeNumber > 0 && !mcv_is_grey(glass->ior))
        return mcv_fail_at(
            here, error,
            "has an abbeNumber and ior for each channel: give one number, n_d, as ior");
    own.ior_d = glass ? glass->ior[0] : 0;
    mcv_material_settle_spectra(scene, &own, own.by_name || scene->wavelengths[0] > 0);
    own.name = copy_name(material->name, &failed);
    if (!failed && append(&scene->materials, &scene->material_count, &own, sizeof own))
        return MCV_OK;
    free(own.name);
    return mcv_fail_memory(here, error);
}

mcv_result mcv_scene_take_mesh(mcv_scene *scene, mcv_mesh *mesh, mcv_error *error) {
    const mcv_json_path file = mcv_place_file(scene->path);
    for (size_t i = 0; i < 3; ++i) mesh->reach[i] = 0;
    for (size_t i = 0; i < mesh->vertex_count; ++i)
        for (size_t k = 0; k < 3; ++k) {
            const double far = fabs((double)mesh->positions[3 * i + k]);
            if (far > mesh->reach[k]) mesh->reach[k] = far;
        }
    if (append(&scene->meshes, &scene->mesh_count, mesh, sizeof *mesh)) return MCV_OK;
    mcv_mesh_free(mesh);
    return mcv_fail_memory(&file, error);
}

mcv_result mcv_scene_add_mesh(mcv_scene *scene, const mcv_mesh *mesh, mcv_error *error) {
    element_place place;
    const mcv_json_path *here =
        place_element(&place, scene, "meshes", mesh->name, scene->mesh_count);
    if (!mesh->positions || !mesh->indices || mesh->vertex_count == 0)
        return mcv_fail_at(here, error, "must have positions and indices");
    const size_t vertices = mesh->vertex_count;
    bool failed = false;
    mcv_mesh own = *mesh;
    own.name = copy_name(mesh->name, &failed);
    own.positions = copy(mesh->positions, 3 * vertices * sizeof(float), &failed);
    own.normals = copy(mesh->normals, 3 * vertices * sizeof(float), &failed);
    own.texcoords = copy(mesh->texcoords, 2 * vertices * sizeof(float), &failed);
    own.texcoords1 = copy(mesh->texcoords1, 2 * vertices * sizeof(float), &failed);
    own.tangents = copy(mesh->tangents, 4 * vertices * sizeof(float), &failed);
    own.indices = copy(mesh->indices, 3 * (size_t)mesh->triangle_count * sizeof(uint32_t), &failed);
    uint32_t repaired;
    const mcv_result result =
        failed ? mcv_fail_memory(here, error) : mcv_mesh_check(&own, &repaired, here, error);
    if (result == MCV_OK) return mcv_scene_take_mesh(scene, &own, error);
    mcv_mesh_free(&own);
    return result;
}

mcv_result mcv_scene_add_instance(mcv_scene *scene, const mcv_instance *instance,
                                  mcv_error *error) {
    element_place place;
    const mcv_json_path *here =
        place_element(&place, scene, "nodes", instance->name, scene->instance_count);
    if (instance->mesh >= scene->mesh_count)
        return mcv_fail_at(here, error, "mesh %u does not exist", instance->mesh);
    if (instance->material >= scene->material_count)
        return mcv_fail_at(here, error, "material %u does not exist", instance->material);
    for (int i = 0; i < 12; ++i)
        if (!isfinite(instance->to_world.m[i]))
            return mcv_fail_at(here, error, "its transform must be finite");
    MCV_TRY(mcv_scene_check_extent(&instance->to_world, scene->meshes[instance->mesh].reach, here,
                                   error));
    const uint32_t triangles = scene->meshes[instance->mesh].triangle_count;
    if (triangles > INT32_MAX - scene->triangle_count)
        return mcv_fail_at(here, error, "%u triangles and these %u are more than %d",
                           scene->triangle_count, triangles, INT32_MAX);
    mcv_mesh *mesh = &scene->meshes[instance->mesh];
    if (mcv_material_roughness(&scene->materials[instance->material]).anisotropy > 0 &&
        !mesh->tangents)
        MCV_TRY(mcv_mesh_make_tangents(mesh, here, error));
    bool failed = false;
    mcv_instance own = *instance;
    own.name = copy_name(instance->name, &failed);
    own.emitter = MCV_NONE;
    own.first_triangle = scene->triangle_count;
    if (!failed && append(&scene->instances, &scene->instance_count, &own, sizeof own)) {
        scene->triangle_count += triangles;
        return MCV_OK;
    }
    free(own.name);
    return mcv_fail_memory(here, error);
}

static mcv_result check_emitter_instance(const mcv_scene *scene, mcv_emitter *emitter,
                                         const mcv_json_path *place, mcv_error *error) {
    if (!mcv_emitter_has_surface(emitter->type)) {
        emitter->instance = MCV_NONE;
        emitter->area = 0;
        for (uint32_t i = 0; i < scene->emitter_count && emitter->type == MCV_EMITTER_ENVIRONMENT;
             ++i)
            if (scene->emitters[i].type == MCV_EMITTER_ENVIRONMENT)
                return mcv_fail_at(place, error,
                                   "\"%s\" is an environment already: a scene has at most one",
                                   scene->emitters[i].name);
        return MCV_OK;
    }
    if (emitter->instance >= scene->instance_count)
        return mcv_fail_at(place, error, "instance %u does not exist", emitter->instance);
    const mcv_instance *instance = scene->instances + emitter->instance;
    if (instance->emitter != MCV_NONE)
        return mcv_fail_at(place, error, "node \"%s\" has an emitter already", instance->name);
    emitter->area = mcv_scene_area(scene, emitter->instance);
    if (emitter->area > 0 && isfinite(emitter->area)) return MCV_OK;
    return mcv_fail_at(place, error,
                       "node \"%s\" has an area of %g m², but must have one to emit from",
                       instance->name, emitter->area);
}

mcv_result mcv_scene_add_emitter(mcv_scene *scene, const mcv_emitter *emitter, mcv_error *error) {
    element_place place;
    const mcv_json_path *here =
        place_element(&place, scene, "emitters", emitter->name, scene->emitter_count);
    if (emitter->type >= MCV_EMITTER_COUNT)
        return mcv_fail_at(here, error, "%u is not a type of emitter", emitter->type);
    if (emitter->texture != MCV_NONE && emitter->texture >= scene->texture_count)
        return mcv_fail_at(here, error, "texture %u does not exist", emitter->texture);
    mcv_emitter own = *emitter;
    MCV_TRY(mcv_emitter_check(&own, here, error));
    MCV_TRY(check_emitter_instance(scene, &own, here, error));
    MCV_TRY(mcv_emitter_check_image(scene, &own, here, error));
    if (mcv_emitter_image(&own)) own.texture = *mcv_emitter_image(&own);
    MCV_TRY(mcv_emitter_resolve(scene, &own, here, error));
    bool failed = false;
    own.name = copy_name(emitter->name, &failed);
    if (!failed && append(&scene->emitters, &scene->emitter_count, &own, sizeof own)) {
        if (own.instance != MCV_NONE)
            scene->instances[own.instance].emitter = scene->emitter_count - 1;
        return MCV_OK;
    }
    free(own.name);
    return mcv_fail_memory(here, error);
}

/* The tolerance is the rounding of floats, in which the transform may have been stored. */
static bool is_rigid(const mcv_transform *t) {
    const double *m = t->m, rounding = 6 * FLT_EPSILON; /* three products of two rounded numbers */
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j <= i; ++j)
            if (!(fabs(m[i] * m[j] + m[3 + i] * m[3 + j] + m[6 + i] * m[6 + j] - (i == j)) <=
                  rounding))
                return false;
    return mcv_transform_determinant(t) > 0;
}

mcv_result mcv_scene_add_sensor(mcv_scene *scene, const mcv_sensor *sensor, mcv_error *error) {
    element_place place;
    const mcv_json_path *here =
        place_element(&place, scene, "sensors", sensor->name, scene->sensor_count);
    if (sensor->type >= MCV_SENSOR_COUNT)
        return mcv_fail_at(here, error, "%u is not a type of sensor", sensor->type);
    mcv_sensor own = *sensor;
    MCV_TRY(mcv_sensor_resolve(&own, here, error));
    if (!is_rigid(&sensor->to_world))
        return mcv_fail_at(
            here, error,
            "its frame must be a rotation and a translation, without scale, shear or mirroring");
    bool failed = false;
    own.name = copy_name(sensor->name, &failed);
    if (!failed && append(&scene->sensors, &scene->sensor_count, &own, sizeof own)) return MCV_OK;
    free(own.name);
    return mcv_fail_memory(here, error);
}

mcv_result mcv_scene_add_frame(mcv_scene *scene, const char *name, bool of_asset,
                               const mcv_transform *to_world, mcv_error *error) {
    mcv_placement frame = {.of_asset = of_asset, .to_world = *to_world};
    const mcv_json_path file = mcv_place_file(scene->path);
    if (!*name) return MCV_OK;
    for (int j = 0; j < 3; ++j) {
        const double column[3] = {to_world->m[j], to_world->m[3 + j], to_world->m[6 + j]};
        double axis[3];
        if (!mcv_normalize3(column, axis)) return MCV_OK;
        for (int i = 0; i < 3; ++i) frame.to_world.m[3 * i + j] = axis[i];
    }
    if ((frame.name = strdup(name)) &&
        append(&scene->frames, &scene->frame_count, &frame, sizeof frame))
        return MCV_OK;
    free(frame.name);
    return mcv_fail_memory(&file, error);
}

mcv_result mcv_scene_add_solid(mcv_scene *scene, const mcv_solid *solid, const char *name,
                               uint32_t body, uint32_t rim, mcv_error *error) {
    element_place place;
    const mcv_json_path *here = place_element(&place, scene, "nodes", name, scene->instance_count);
    float positions[24];
    uint32_t no_indices;
    MCV_TRY(mcv_solid_check(solid, here, error));
    MCV_TRY(mcv_solid_check_materials(solid, scene, body, rim, here, error));
    if (scene->solid_count == MCV_MAX_SOLIDS)
        return mcv_fail_at(here, error, "more than %d bodies with exact surfaces", MCV_MAX_SOLIDS);
    mcv_solid own = *solid;
    const uint32_t first = scene->instance_count, materials[2] = {body, rim};
    mcv_solid_box(solid, positions);
    const mcv_mesh mesh = {
        .name = (char *)name, .vertex_count = 8, .positions = positions, .indices = &no_indices};
    const mcv_instance instance = {
        .name = (char *)name, .mesh = scene->mesh_count, .to_world = solid->to_world};
    MCV_TRY(mcv_scene_add_mesh(scene, &mesh, error));
    for (int i = 0; i < (body == rim ? 1 : 2); ++i) {
        mcv_instance part = instance;
        part.material = materials[i];
        MCV_TRY(mcv_scene_add_instance(scene, &part, error));
    }
    for (int piece = 0; piece < 3; ++piece)
        own.instances[piece] = piece == MCV_PIECE_SIDE ? scene->instance_count - 1 : first;
    return append(&scene->solids, &scene->solid_count, &own, sizeof own)
               ? MCV_OK
               : mcv_fail_memory(here, error);
}

mcv_result mcv_scene_add_defect(mcv_scene *scene, const mcv_defect *defect, mcv_error *error) {
    const mcv_json_path file = mcv_place_file(scene->path);
    mcv_defect own = *defect;
    if ((own.name = strdup(defect->name)) &&
        append(&scene->defects, &scene->defect_count, &own, sizeof own))
        return MCV_OK;
    free(own.name);
    return mcv_fail_memory(&file, error);
}

mcv_result mcv_scene_warn(mcv_scene *scene, mcv_error *error, const char *format, ...) {
    const mcv_json_path file = mcv_place_file(scene->path);
    char *text = NULL;
    va_list arguments;
    va_start(arguments, format);
    const int length = vasprintf(&text, format, arguments);
    va_end(arguments);
    for (char *c = text; length >= 0 && *c; ++c) /* a name may not begin a line of its own */
        if (*c == '\n' || *c == '\r') *c = ' ';
    if (length >= 0 && append(&scene->warnings, &scene->warning_count, &text, sizeof text))
        return MCV_OK;
    if (length >= 0) free(text);
    return mcv_fail_memory(&file, error);
}
