/* SPDX-License-Identifier: Apache-2.0 */
/* The scenes that Mitsuba 3 renders as well, from its own descriptions in mitsuba_peer.py: a floor,
 * lights, a body, a camera above. */
#ifndef MCVISI_TESTS_PEER_SCENES_H
#define MCVISI_TESTS_PEER_SCENES_H

#include "exact_builder.h"

/* GGX of widths α of 0.05 and 0.02, glTF's roughness squared. What microfacets send on to each
 * other is given back here and lost there: in glass of 0.05 half a percent, and the benchmark's
 * many samples see what metal of 0.05 loses. */
#define PEER_ROUGH 0.22360679774997896
#define PEER_SATIN 0.1414213562373095

/* Of one channel, or the same made of three: what a coloured diffuse surface reflects of them. */
static const double peer_tint[3] = {1, 5.0 / 6, 2.0 / 3};

static inline uint32_t add_peer_diffuse(mcv_scene *scene, bool coloured, double share) {
    mcv_material diffuse = {.texture = MCV_NONE};
    for (int k = 0; k < 3; ++k)
        diffuse.as.diffuse.reflectance[k] = coloured ? share * peer_tint[k] : share;
    return add_material(scene, MCV_MATERIAL_DIFFUSE, &diffuse);
}

static inline void add_lamp(mcv_scene *scene) {
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 1, 1, add_absorber(scene), looking_down_z(0.8, 0.3, 2)), 3, 0);
}

static inline void add_ball(mcv_scene *scene, double radius, double z, uint32_t material) {
    mcv_solid ball = sphere(radius);
    ball.to_world = looking_down_z(0, 0, z);
    add_solid(scene, &ball, material, material);
}

static inline void add_peer_camera(mcv_scene *scene, const char *name, uint32_t pixels) {
    const mcv_transform at = looking_down_z(0, 0, 4);
    if (strcmp(name, "lens") == 0) {
        mcv_sensor camera = sensor_defaults(MCV_SENSOR_THIN_LENS);
        mcv_thin_lens_params *p = &camera.as.thin_lens;
        p->focalLength = 0.05;
        p->focusDistance = 4;
        p->lensDiameter = 0.1;
        p->resolution[0] = p->resolution[1] = pixels;
        p->pixelSize[0] = p->pixelSize[1] = 0.5 / (1 / 0.05 - 1 / 4.0) / pixels;
        add_sensor(scene, MCV_SENSOR_THIN_LENS, &camera, at);
    } else if (strncmp(name, "telecentric", 11) == 0) {
        mcv_sensor camera = sensor_defaults(MCV_SENSOR_TELECENTRIC);
        mcv_telecentric_params *p = &camera.as.telecentric;
        p->magnification = 0.25;
        p->workingDistance = 3.5;
        p->fNumber = 1e4;
        p->resolution[0] = p->resolution[1] = pixels;
        p->pixelSize[0] = p->pixelSize[1] = 0.25 / pixels;
        add_sensor(scene, MCV_SENSOR_TELECENTRIC, &camera, at);
    } else if (strcmp(name, "parallel panel") == 0) {
        add_pinhole(scene, pixels, 0.25, looking_down_z(0, 0, 0.4));
    } else {
        add_pinhole(scene, pixels, 0.5, at);
    }
}

static inline uint32_t add_metal(mcv_scene *scene, double roughness) {
    mcv_material metal = {.texture = MCV_NONE};
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_CONDUCTOR), &metal.as);
    for (int k = 0; k < 3; ++k) {
        metal.as.conductor.n[k] = 0.27;
        metal.as.conductor.k[k] = 3.61;
    }
    metal.as.conductor.roughness = roughness;
    return add_material(scene, MCV_MATERIAL_CONDUCTOR, &metal);
}

static inline uint32_t add_rough_glass(mcv_scene *scene) {
    mcv_material glass = {.texture = MCV_NONE};
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_DIELECTRIC), &glass.as);
    for (int k = 0; k < 3; ++k) glass.as.dielectric.ior[k] = 1.5;
    glass.as.dielectric.roughness = PEER_SATIN;
    return add_material(scene, MCV_MATERIAL_DIELECTRIC, &glass);
}

static inline void add_block(mcv_scene *scene, uint32_t material) {
    const double half[3] = {0.3, 0.4, 0.2}, c = cos(M_PI / 6), s = sin(M_PI / 6);
    add_box(scene, half, material, (mcv_transform){{c, -s, 0, s, c, 0, 0, 0, 1, 0.1, 0, 0.8}});
}

/* As such lights are used: 100 x 100 mm, 100 mm from the origin, 30° above the floor. */
static inline void add_parallel_panel(mcv_scene *scene) {
    const double s = sqrt(0.75), at[3] = {0.1 * s, 0, 0.05}, forward[3] = {-s, 0, -0.5};
    const uint32_t panel = add_rectangle(scene, 0.1, 0.1, add_absorber(scene),
                                         looking(at, forward, (const double[3]){0, 1, 0}));
    add_emitter(scene, MCV_EMITTER_PARALLEL, panel, 1e4, M_PI / 360);
}

/* Parallel light through an opening, towards the origin, down from +x by a slope of one half. */
static inline void add_opening(mcv_scene *scene) {
    const double s = sqrt(0.2), at[3] = {8 * s, 0, 4 * s}, forward[3] = {-2 * s, 0, -s};
    const uint32_t panel = add_rectangle(scene, 0.5, 0.5, add_absorber(scene),
                                         looking(at, forward, (const double[3]){0, 1, 0}));
    add_emitter(scene, MCV_EMITTER_PARALLEL, panel, 1e4, M_PI / 360);
}

/* `mesh`: of "assembly", about the cube [-1, 1]³; NULL for the others. */
static inline mcv_scene *make_peer_scene(const char *name, uint32_t pixels, bool coloured,
                                         const mcv_mesh *mesh) {
    mcv_scene *scene = new_scene();
    const bool is_backlight = strcmp(name, "telecentric backlight") == 0,
               is_opening = strcmp(name, "opening") == 0;
    const bool is_panel = strcmp(name, "parallel panel") == 0,
               is_lamp_lit = !is_opening && !is_panel;
    const bool is_sky = strcmp(name, "sky") == 0, is_furnace = strcmp(name, "furnace") == 0;
    const bool is_absorbing = strcmp(name, "absorbing") == 0, is_cube = strcmp(name, "cube") == 0;
    const bool is_lens = strcmp(name, "lens") == 0,
               is_rough_glass = strcmp(name, "rough glass") == 0,
               is_metal = strstr(name, "conductor");
    if (is_furnace || is_sky || is_absorbing) add_environment(scene, 1);
    if (is_cube) add_environment(scene, 0.5);
    if (is_lens || is_metal || is_rough_glass) add_environment(scene, 0.2);
    if (!is_furnace && !is_backlight)
        add_rectangle(scene, 4, 4, add_peer_diffuse(scene, coloured, 0.6), looking_up_z(0, 0, 0));
    if (!is_furnace && !is_sky && !is_absorbing && !is_cube && is_lamp_lit) add_lamp(scene);
    if (is_furnace) add_ball(scene, 0.5, 1, add_glass(scene, 1.5, 0, 0));
    if (is_sky) add_ball(scene, 0.5, 1, add_peer_diffuse(scene, coloured, 0.5));
    if (is_absorbing) add_ball(scene, 0.4, 1, add_glass(scene, 1.5, 2, 0));
    if (is_cube) add_block(scene, add_glass(scene, 1.5, 0, 0));
    if (is_lens) add_ball(scene, 0.3, 1.5, add_glass(scene, 1.5, 0, 0));
    if (is_metal)
        add_ball(scene, 0.4, 0.4,
                 add_metal(scene, strcmp(name, "conductor") == 0         ? 0
                                  : strcmp(name, "satin conductor") == 0 ? PEER_SATIN
                                                                         : PEER_ROUGH));
    if (is_rough_glass) add_ball(scene, 0.4, 0.6, add_rough_glass(scene));
    if (strcmp(name, "area") == 0)
        add_ball(scene, 0.3, 0.3, add_peer_diffuse(scene, coloured, 0.8));
    if (strcmp(name, "telecentric") == 0)
        add_ball(scene, 0.3, 0.5, add_peer_diffuse(scene, coloured, 0.8));
    if (is_backlight) {
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 3, 3, add_absorber(scene), looking_up_z(0, 0, 0)), 1, 0);
        add_block(scene, add_peer_diffuse(scene, coloured, 0.5));
    }
    if (is_opening) add_opening(scene);
    if (is_panel) add_parallel_panel(scene);
    if (is_opening || is_panel)
        add_ball(scene, is_panel ? 0.02 : 0.2, is_panel ? 0.02 : 0.2,
                 add_peer_diffuse(scene, coloured, 0.8));
    if (mesh)
        add_instance(scene, mesh, add_peer_diffuse(scene, coloured, 0.5),
                     (mcv_transform){{0.7, 0, 0, 0, 0.7, 0, 0, 0, 0.7, 0, 0, 0.8}});
    add_peer_camera(scene, name, pixels);
    return scene;
}

#endif
