/* SPDX-License-Identifier: Apache-2.0 */
/* Presets: their emitting element and their geometry. */
#include "loader/loader.h"

#include "scene/emitters.h"
#include "scene/params.h"
#include "scene/transform.h"

#include <stdlib.h>

enum { SEGMENTS = 128, DOME_RINGS = 24 };

/* --- the element that shines --- */

static mcv_result check_diameters(double inner, double outer, const char *inner_key,
                                  const char *outer_key, const mcv_json_path *place,
                                  mcv_error *error) {
    const mcv_json_path here = mcv_json_path_key(place, inner_key);
    return inner < outer ? MCV_OK
                         : mcv_fail_at(&here, error, "%g m must be less than %s, %g m", inner,
                                       outer_key, outer);
}

static mcv_result check_shape(const mcv_preset *preset, const mcv_json_path *place,
                              mcv_error *error) {
    const mcv_ring_params *ring = &preset->as.ring;
    const mcv_dome_params *dome = &preset->as.dome;
    if (preset->type == MCV_PRESET_RING)
        return check_diameters(ring->innerDiameter, ring->outerDiameter, "innerDiameter",
                               "outerDiameter", place, error);
    if (preset->type == MCV_PRESET_COAXIAL) {
        const mcv_json_path here = mcv_json_path_key(place, "transmittance");
        const double r = preset->as.coaxial.reflectance, t = preset->as.coaxial.transmittance;
        if (r + t > 1)
            return mcv_fail_at(&here, error, "%g and reflectance %g are more than 1 together", t,
                               r);
    }
    if (preset->type == MCV_PRESET_DOME)
        return check_diameters(dome->holeDiameter, dome->diameter, "holeDiameter", "diameter",
                               place, error);
    return MCV_OK;
}

static const double *parameter(const mcv_preset *preset, const char *key) {
    return mcv_params_find(mcv_emitter_table(preset->type), key, &preset->as);
}

mcv_result mcv_preset_resolve(const mcv_preset *preset, mcv_emitter *emitter,
                              const mcv_json_path *place, mcv_error *error) {
    const double *half_angle = parameter(preset, "halfAngle");
    const bool directed = half_angle && !isnan(*half_angle);
    emitter->type = directed ? MCV_EMITTER_PARALLEL : MCV_EMITTER_AREA;
    mcv_params_set_defaults(mcv_emitter_table(emitter->type), &emitter->as);
    if (directed) {
        emitter->as.parallel.halfAngle = *half_angle;
        MCV_TRY(mcv_emitter_check(emitter, place, error)); /* refuses a half-angle of 0 */
    }
    MCV_TRY(mcv_params_check(mcv_emitter_table(preset->type), &preset->as, place, error));
    memcpy(mcv_emitter_parameter(emitter, "radiance"), parameter(preset, "radiance"),
           3 * sizeof(double));
    memcpy(mcv_emitter_parameter(emitter, "power"), parameter(preset, "power"), 3 * sizeof(double));
    return check_shape(preset, place, error);
}

/* --- surfaces of revolution --- */

typedef struct profile_point {
    double r, z;
    double normal_r, normal_z; /* unit */
} profile_point;

/* A point at the distance r from the axis, on the polygon with the area of its circle. */
static void turn(const profile_point *p, uint32_t segment, float *position, float *normal) {
    const double step = 2 * M_PI / SEGMENTS, angle = segment * step,
                 r = p->r * sqrt(step / sin(step));
    const double c = cos(angle), s = sin(angle);
    position[0] = (float)(r * c), position[1] = (float)(r * s), position[2] = (float)p->z;
    normal[0] = (float)(p->normal_r * c), normal[1] = (float)(p->normal_r * s),
    normal[2] = (float)p->normal_z;
}

/* The profile, turned about the node's z axis. With r to the right and z up, the front lies to the
 * right of the direction of the profile. */
static mcv_result add_turned(mcv_loader *loader, const char *name, const profile_point *profile,
                             uint32_t count, const mcv_transform *to_world,
                             const mcv_json_path *place, mcv_error *error) {
    mcv_mesh mesh = {.name = (char *)name, .vertex_count = count * SEGMENTS};
    mcv_instance instance = {.name = (char *)name, .mesh = loader->scene->mesh_count};
    if (!mcv_transform_rigid(to_world, &instance.to_world))
        return mcv_fail_at(place, error, "its scale must not be 0");
    MCV_TRY(mcv_load_absorber(loader, &instance.material, error));
    mesh.positions = malloc(3 * sizeof(float) * mesh.vertex_count);
    mesh.normals = malloc(3 * sizeof(float) * mesh.vertex_count);
    mesh.indices = malloc(6 * sizeof(uint32_t) * mesh.vertex_count);
    const bool memory = mesh.positions && mesh.normals && mesh.indices;
    mcv_result result = memory ? MCV_OK : mcv_fail_memory(place, error);
    for (uint32_t i = 0; i < mesh.vertex_count && memory; ++i) {
        const uint32_t row = i / SEGMENTS, next = row * SEGMENTS + (i + 1) % SEGMENTS;
        turn(profile + row, i % SEGMENTS, mesh.positions + 3 * (size_t)i,
             mesh.normals + 3 * (size_t)i);
        if (row + 1 == count) continue;
        memcpy(mesh.indices + 3 * (size_t)mesh.triangle_count,
               (uint32_t[6]){i, next, i + SEGMENTS, next, next + SEGMENTS, i + SEGMENTS},
               6 * sizeof(uint32_t));
        mesh.triangle_count += 2;
    }
    if (result == MCV_OK) result = mcv_scene_add_mesh(loader->scene, &mesh, error);
    free(mesh.positions);
    free(mesh.normals);
    free(mesh.indices);
    MCV_TRY(result);
    return mcv_scene_add_instance(loader->scene, &instance, error);
}

static mcv_result add_ring(mcv_loader *loader, const mcv_ring_params *p, const char *name,
                           const mcv_transform *to_world, const mcv_json_path *place,
                           mcv_error *error) {
    const double middle = (p->innerDiameter + p->outerDiameter) / 4,
                 half = (p->outerDiameter - p->innerDiameter) / 4;
    const double c = cos(p->tilt), s = sin(p->tilt);
    const profile_point profile[] = {{middle - half * c, half * s, -s, -c},
                                     {middle + half * c, -half * s, -s, -c}};
    return add_turned(loader, name, profile, 2, to_world, place, error);
}

static mcv_result add_dome(mcv_loader *loader, const mcv_dome_params *p, const char *name,
                           const mcv_transform *to_world, const mcv_json_path *place,
                           mcv_error *error) {
    const double hole = asin(p->holeDiameter / p->diameter);
    profile_point profile[DOME_RINGS + 1];
    for (int i = 0; i <= DOME_RINGS; ++i) {
        const double angle = hole + (M_PI / 2 - hole) * i / DOME_RINGS, s = sin(angle),
                     c = i < DOME_RINGS ? cos(angle) : 0;
        profile[i] = (profile_point){p->diameter / 2 * s, p->diameter / 2 * c, -s, -c};
    }
    return add_turned(loader, name, profile, DOME_RINGS + 1, to_world, place, error);
}

static mcv_result add_bar(mcv_loader *loader, const mcv_bar_params *p, const char *name,
                          const mcv_transform *to_world, const mcv_json_path *place,
                          mcv_error *error) {
    return mcv_load_rectangle(loader, name, (const double[2]){p->length, p->width}, false, to_world,
                              place, error);
}

static mcv_result add_half_mirror(mcv_loader *loader, const mcv_coaxial_params *p, const char *name,
                                  const mcv_transform *to_world, const mcv_json_path *place,
                                  mcv_error *error) {
    mcv_material material = {
        .name = (char *)name, .type = MCV_MATERIAL_BEAM_SPLITTER, .texture = MCV_NONE};
    for (int k = 0; k < 3; ++k) {
        material.as.beam_splitter.reflectance[k] = p->reflectance;
        material.as.beam_splitter.transmittance[k] = p->transmittance;
    }
    MCV_TRY(mcv_load_rectangle(loader, name, (const double[2]){p->size[0], M_SQRT2 * p->size[1]},
                               false, to_world, place, error));
    loader->scene->instances[loader->scene->instance_count - 1].material =
        loader->scene->material_count;
    return mcv_scene_add_material(loader->scene, &material, error);
}

/* The panel comes first, because the first instance emits. */
static mcv_result add_coaxial(mcv_loader *loader, const mcv_coaxial_params *p, const char *name,
                              const mcv_transform *to_world, const mcv_json_path *place,
                              mcv_error *error) {
    const double y = 0.55 * p->size[1], s = M_SQRT1_2;
    mcv_transform frame;
    if (!mcv_transform_rigid(to_world, &frame))
        return mcv_fail_at(place, error, "its scale must not be 0");
    /* By columns: each rectangle's x, y and z, and its centre; it faces its -z. */
    const mcv_transform panel = {{1, 0, 0, 0, 0, 1, 0, -1, 0, 0, y, 0}},
                        wall = {{1, 0, 0, 0, 0, -1, 0, 1, 0, 0, -y, 0}};
    const mcv_transform mirror = {{1, 0, 0, 0, s, -s, 0, s, s, 0, 0, 0}};
    const mcv_transform parts[] = {mcv_transform_compose(&frame, &panel),
                                   mcv_transform_compose(&frame, &wall),
                                   mcv_transform_compose(&frame, &mirror)};
    MCV_TRY(mcv_load_rectangle(loader, name, p->size, false, parts, place, error));
    MCV_TRY(mcv_load_rectangle(loader, name, p->size, false, parts + 1, place, error));
    return add_half_mirror(loader, p, name, parts + 2, place, error);
}

mcv_result mcv_load_preset(mcv_loader *loader, const mcv_preset *preset, const char *name,
                           const mcv_transform *to_world, const mcv_json_path *place,
                           mcv_error *error) {
    switch (preset->type) {
#define MCV_X(type, key, NAME) \
    case MCV_PRESET_##NAME: \
        return add_##type(loader, &preset->as.type, name, to_world, place, error);
        MCV_PRESETS(MCV_X)
#undef MCV_X
    default:
        return MCV_OK;
    }
}
