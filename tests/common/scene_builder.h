/* SPDX-License-Identifier: Apache-2.0 */
/* Small scenes made by hand, for tests. Each function fails the test where the scene refuses what
 * it adds. */
#ifndef MCVISI_TESTS_SCENE_BUILDER_H
#define MCVISI_TESTS_SCENE_BUILDER_H

#include <math.h>
#include "test.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene.h"

static mcv_error builder_error;

#define BUILD(call) \
    do { \
        if ((call) != MCV_OK) fail_msg("%s: %s", #call, builder_error.text); \
    } while (0)

/* The node's axes: it looks along `forward` (its -z), `up` is its +y; both unit and orthogonal. */
static inline mcv_transform looking(const double at[3], const double forward[3],
                                    const double up[3]) {
    const double right[3] = {forward[1] * up[2] - forward[2] * up[1],
                             forward[2] * up[0] - forward[0] * up[2],
                             forward[0] * up[1] - forward[1] * up[0]};
    return (mcv_transform){{right[0], up[0], -forward[0], right[1], up[1], -forward[1], right[2],
                            up[2], -forward[2], at[0], at[1], at[2]}};
}

static inline mcv_transform looking_down_z(double x, double y, double z) {
    return looking((const double[3]){x, y, z}, (const double[3]){0, 0, -1},
                   (const double[3]){0, 1, 0});
}

static inline mcv_transform looking_up_z(double x, double y, double z) {
    return looking((const double[3]){x, y, z}, (const double[3]){0, 0, 1},
                   (const double[3]){0, 1, 0});
}

static inline uint32_t add_material(mcv_scene *scene, uint32_t type, const mcv_material *values) {
    mcv_material material = values ? *values : (mcv_material){.texture = MCV_NONE};
    if (!values) mcv_params_set_defaults(mcv_material_table(type), &material.as);
    material.name = (char *)"material";
    material.type = type;
    material.texture = MCV_NONE;
    BUILD(mcv_scene_add_material(scene, &material, &builder_error));
    return scene->material_count - 1;
}

static inline uint32_t add_diffuse(mcv_scene *scene, double reflectance) {
    return add_material(
        scene, MCV_MATERIAL_DIFFUSE,
        &(mcv_material){.as.diffuse.reflectance = {reflectance, reflectance, reflectance}});
}

static inline uint32_t add_glass(mcv_scene *scene, double ior, double absorption, double priority) {
    return add_material(
        scene, MCV_MATERIAL_DIELECTRIC,
        &(mcv_material){
            .as.dielectric = {{ior, ior, ior}, {absorption, absorption, absorption}, priority}});
}

static inline uint32_t add_absorber(mcv_scene *scene) {
    return add_material(scene, MCV_MATERIAL_ABSORBER, NULL);
}

static inline uint32_t add_instance(mcv_scene *scene, const mcv_mesh *mesh, uint32_t material,
                                    mcv_transform to_world) {
    mcv_mesh named = *mesh;
    named.name = (char *)"mesh";
    BUILD(mcv_scene_add_mesh(scene, &named, &builder_error));
    const mcv_instance instance = {.name = (char *)"node",
                                   .mesh = scene->mesh_count - 1,
                                   .material = material,
                                   .emitter = MCV_NONE,
                                   .to_world = to_world};
    BUILD(mcv_scene_add_instance(scene, &instance, &builder_error));
    return scene->instance_count - 1;
}

/* A rectangle of the node's xy plane whose front looks along -z. */
static inline uint32_t add_rectangle(mcv_scene *scene, double width, double height,
                                     uint32_t material, mcv_transform to_world) {
    const float x = (float)(width / 2);
    const float y = (float)(height / 2);
    float positions[] = {-x, -y, 0, x, -y, 0, x, y, 0, -x, y, 0};
    uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    return add_instance(
        scene,
        &(mcv_mesh){
            .vertex_count = 4, .triangle_count = 2, .positions = positions, .indices = indices},
        material, to_world);
}

/* A closed box from -half to +half, outward faces, flat. */
static inline uint32_t add_box(mcv_scene *scene, const double half[3], uint32_t material,
                               mcv_transform to_world) {
    float positions[24];
    for (int i = 0; i < 8; ++i) {
        for (int k = 0; k < 3; ++k)
            positions[3 * i + k] = (float)((i >> k & 1) ? half[k] : -half[k]);
    }
    uint32_t indices[] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                          2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    return add_instance(
        scene,
        &(mcv_mesh){
            .vertex_count = 8, .triangle_count = 12, .positions = positions, .indices = indices},
        material, to_world);
}

/* A sphere of `rings` rings and twice as many segments with interpolated normals, outward. */
static inline uint32_t add_sphere(mcv_scene *scene, double radius, uint32_t rings,
                                  uint32_t material, mcv_transform to_world) {
    const uint32_t segments = 2 * rings;
    const uint32_t vertices = (rings + 1) * segments;
    float *positions = malloc(3 * sizeof(float) * vertices);
    float *normals = malloc(3 * sizeof(float) * vertices);
    uint32_t *indices = malloc(6 * sizeof(uint32_t) * rings * segments);
    uint32_t triangles = 0;
    assert_non_null(positions);
    assert_non_null(normals);
    assert_non_null(indices);
    for (uint32_t r = 0; r <= rings; ++r) {
        for (uint32_t s = 0; s < segments; ++s) {
            const double polar = 3.14159265358979323846 * r / rings;
            const double around = 2 * 3.14159265358979323846 * s / segments;
            const double sine = r == 0 || r == rings ? 0 : sin(polar);
            const double n[3] = {sine * cos(around), sine * sin(around), cos(polar)};
            for (int k = 0; k < 3; ++k) {
                normals[3 * (r * segments + s) + k] = (float)n[k];
                positions[3 * (r * segments + s) + k] = (float)(radius * n[k]);
            }
            if (r == rings) continue;
            const uint32_t a = r * segments + s;
            const uint32_t b = r * segments + (s + 1) % segments;
            if (r > 0) memcpy(indices + 3 * triangles++, (uint32_t[3]){a, a + segments, b}, 12);
            if (r < rings - 1)
                memcpy(indices + 3 * triangles++, (uint32_t[3]){b, a + segments, b + segments}, 12);
        }
    }
    const uint32_t instance = add_instance(scene,
                                           &(mcv_mesh){.vertex_count = vertices,
                                                       .triangle_count = triangles,
                                                       .positions = positions,
                                                       .normals = normals,
                                                       .indices = indices},
                                           material, to_world);
    free(positions);
    free(normals);
    free(indices);
    return instance;
}

static inline void add_emitter(mcv_scene *scene, uint32_t type, uint32_t instance, double radiance,
                               double half_angle) {
    mcv_emitter emitter = {
        .name = (char *)"emitter", .type = type, .instance = instance, .texture = MCV_NONE};
    mcv_params_set_defaults(mcv_emitter_table(type), &emitter.as);
    double *value = type == MCV_EMITTER_PARALLEL ? emitter.as.parallel.radiance
                    : type == MCV_EMITTER_AREA   ? emitter.as.area.radiance
                                                 : emitter.as.environment.radiance;
    for (int k = 0; k < 3; ++k) value[k] = radiance;
    if (type == MCV_EMITTER_PARALLEL) emitter.as.parallel.halfAngle = half_angle;
    BUILD(mcv_scene_add_emitter(scene, &emitter, &builder_error));
}

static inline void add_environment(mcv_scene *scene, double radiance) {
    add_emitter(scene, MCV_EMITTER_ENVIRONMENT, MCV_NONE, radiance, 0);
}

/* A sensor with its parameters set by the caller in `values->as`; the rest of *values is filled in
 * here. */
static inline void add_sensor(mcv_scene *scene, uint32_t type, const mcv_sensor *values,
                              mcv_transform to_world) {
    mcv_sensor sensor = *values;
    sensor.name = (char *)"sensor";
    sensor.type = type;
    sensor.to_world = to_world;
    BUILD(mcv_scene_add_sensor(scene, &sensor, &builder_error));
}

static inline mcv_sensor sensor_defaults(uint32_t type) {
    mcv_sensor sensor = {.type = type};
    mcv_params_set_defaults(mcv_sensor_table(type), &sensor.as);
    return sensor;
}

/* A pinhole camera of square pixels that sees `width` per unit of distance. */
static inline void add_pinhole(mcv_scene *scene, uint32_t pixels, double width,
                               mcv_transform to_world) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_PINHOLE);
    sensor.as.pinhole.imageDistance = 1;
    sensor.as.pinhole.resolution[0] = sensor.as.pinhole.resolution[1] = pixels;
    sensor.as.pinhole.pixelSize[0] = sensor.as.pinhole.pixelSize[1] = width / pixels;
    add_sensor(scene, MCV_SENSOR_PINHOLE, &sensor, to_world);
}

#endif
