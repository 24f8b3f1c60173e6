/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* ctest: timeout 1800 */
/*
 * Light paths bring what camera paths find by chance: random small scenes of smooth, diffuse,
 * translucent, glossy and matt bodies, in air or in coloured water, under parallel light and
 * projectors wide enough to be found, seen by random sensors. Each is rendered with and without
 * light paths; the shares of both ways range from nothing to all.
 */
#include "scene_builder.h"

#include "analysis/compare.h"
#include "render/render.h"

#ifndef SCENES
#define SCENES 16
#endif

enum { REPLICATES = 16, PIXELS = 4 };

static uint32_t bits;

static double uniform(double from, double to) {
    bits = bits * 1664525u + 1013904223u;
    return from + (to - from) * (bits >> 8) * 0x1p-24;
}

static int one_of(int count) { return (int)uniform(0, count); }

static void colour(double low, double high, double rgb[3]) {
    for (int k = 0; k < 3; ++k) rgb[k] = uniform(low, high);
}

/* Looks along any direction within the given cosine of -z. */
static mcv_transform somehow_down(double x, double y, double z, double least) {
    const double c = uniform(least, 1), s = sqrt(1 - c * c), a = uniform(0, 2 * M_PI);
    const double forward[3] = {s * cos(a), s * sin(a), -c}, up[3] = {c * cos(a), c * sin(a), s};
    return looking((const double[3]){x, y, z}, forward, up);
}

static uint32_t spreading(mcv_scene *scene) {
    mcv_material material = {.surface_texture = MCV_NONE};
    const int kind = one_of(4);
    if (kind < 2) {
        mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_DIFFUSE), &material.as);
        colour(0.3, kind ? 0.6 : 0.9, material.as.diffuse.reflectance);
        if (kind) colour(0.1, 0.4, material.as.diffuse.transmittance);
        return add_material(scene, MCV_MATERIAL_DIFFUSE, &material);
    }
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_METALLIC_ROUGHNESS), &material.as);
    mcv_metallic_roughness_params *p = &material.as.metallic_roughness;
    colour(0.3, 0.9, p->baseColor);
    p->metallic = uniform(0, 1);
    p->roughness = kind == 2 ? uniform(0.5, 1) : uniform(0.3, 0.5); /* matt, glossy */
    return add_material(scene, MCV_MATERIAL_METALLIC_ROUGHNESS, &material);
}

static void add_smooth_body(mcv_scene *scene) {
    mcv_material material = {.surface_texture = MCV_NONE};
    const double x = uniform(-0.006, 0.006), y = uniform(-0.006, 0.006), z = uniform(0.007, 0.02);
    const mcv_transform to_world = somehow_down(x, y, z, 0.3);
    switch (one_of(5)) {
    case 0:
        add_sphere(scene, uniform(0.003, 0.006), 32,
                   add_glass(scene, uniform(1.2, 2), uniform(0, 50), 1), to_world);
        break;
    case 1:
        add_box(scene, (const double[]){uniform(0.004, 0.01), uniform(0.004, 0.01), 0.002},
                add_glass(scene, uniform(1.2, 2), uniform(0, 50), 1), to_world);
        break;
    case 2:
        mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_MIRROR), &material.as);
        colour(0.5, 1, material.as.mirror.reflectance);
        add_rectangle(scene, 0.015, 0.02, add_material(scene, MCV_MATERIAL_MIRROR, &material),
                      to_world);
        break;
    case 3:
        mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_SHEET), &material.as);
        colour(0.5, 1, material.as.sheet.transmittance);
        add_rectangle(scene, 0.02, 0.02, add_material(scene, MCV_MATERIAL_SHEET, &material),
                      to_world);
        break;
    default:
        mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_BEAM_SPLITTER), &material.as);
        colour(0.2, 0.5, material.as.beam_splitter.reflectance);
        colour(0.2, 0.5, material.as.beam_splitter.transmittance);
        add_rectangle(scene, 0.02, 0.02, add_material(scene, MCV_MATERIAL_BEAM_SPLITTER, &material),
                      to_world);
    }
}

/* A square of `side` with texture coordinates, its front along the node's -z. */
static uint32_t add_screen(mcv_scene *scene, double side, mcv_transform to_world) {
    const float h = (float)(side / 2);
    float positions[] = {-h, -h, 0, h, -h, 0, h, h, 0, -h, h, 0},
          texcoords[] = {0, 1, 1, 1, 1, 0, 0, 0};
    uint32_t indices[] = {0, 2, 1, 0, 3, 2};
    return add_instance(scene,
                        &(mcv_mesh){.vertex_count = 4,
                                    .triangle_count = 2,
                                    .positions = positions,
                                    .texcoords = texcoords,
                                    .indices = indices},
                        add_absorber(scene), to_world);
}

static void add_light(mcv_scene *scene) {
    static const uint32_t types[] = {MCV_EMITTER_PARALLEL, MCV_EMITTER_TELECENTRIC_PROJECTOR,
                                     MCV_EMITTER_PROJECTOR};
    static uint8_t picture[4 * 4 * 3];
    mcv_emitter light = {.name = (char *)"light", .type = types[one_of(3)], .texture = MCV_NONE};
    const double distance = 0.05, side = uniform(0.01, 0.025);
    const mcv_transform to_world =
        somehow_down(uniform(-0.005, 0.005), uniform(-0.005, 0.005), distance, 0.95);
    light.instance = add_screen(scene, side, to_world);
    mcv_params_set_defaults(mcv_emitter_table(light.type), &light.as);
    if (light.type == MCV_EMITTER_PARALLEL) {
        light.as.parallel.halfAngle = uniform(4, 25) * M_PI / 180;
        colour(10, 100, light.as.parallel.radiance);
    } else {
        for (size_t i = 0; i < sizeof picture; ++i) picture[i] = (uint8_t)uniform(0, 256);
        mcv_texture texture = {.width = 4,
                               .height = 3,
                               .wrap_s = 33071,
                               .wrap_t = 33071,
                               .nearest = true,
                               .rgba = picture};
        BUILD(mcv_scene_add_texture(scene, &texture, &builder_error));
    }
    if (light.type == MCV_EMITTER_TELECENTRIC_PROJECTOR) {
        mcv_telecentric_projector_params *p = &light.as.telecentric_projector;
        p->image = 0;
        p->halfAngle = uniform(4, 25) * M_PI / 180;
        p->size[0] = p->size[1] = side;
        colour(10, 100, p->radiance);
    }
    if (light.type == MCV_EMITTER_PROJECTOR) {
        mcv_projector_params *p = &light.as.projector;
        p->image = 0;
        p->focalLength = 0.02;
        p->focusDistance = uniform(0.04, 0.06);
        p->lensDiameter = side;
        for (int k = 0; k < 2; ++k) p->pixelSize[k] = uniform(0.002, 0.005);
        colour(10, 100, p->radiance);
    }
    BUILD(mcv_scene_add_emitter(scene, &light, &builder_error));
}

static void add_camera(mcv_scene *scene) {
    static const uint32_t types[] = {MCV_SENSOR_PINHOLE, MCV_SENSOR_THIN_LENS,
                                     MCV_SENSOR_TELECENTRIC};
    mcv_sensor sensor = sensor_defaults(types[one_of(3)]);
    const double distance = 0.1, field = exp(uniform(log(2e-4), log(0.03))), f = 0.02,
                 focus = uniform(0.08, 0.12);
    const double b = f * focus / (focus - f), c = uniform(0.4, 0.9), s = sqrt(1 - c * c);
    const uint32_t radiometry = one_of(2) ? MCV_RADIOMETRY_IRRADIANCE : MCV_RADIOMETRY_RADIANCE;
    uint32_t *pixels;
    double *pitch, image = field * b / focus;
    if (sensor.type == MCV_SENSOR_PINHOLE) {
        sensor.as.pinhole.imageDistance = b;
        pixels = sensor.as.pinhole.resolution, pitch = sensor.as.pinhole.pixelSize;
    } else if (sensor.type == MCV_SENSOR_THIN_LENS) {
        mcv_thin_lens_params *p = &sensor.as.thin_lens;
        p->focalLength = f;
        p->imageDistance = b;
        p->lensDiameter = uniform(0.001, 0.01);
        p->radiometry = radiometry;
        pixels = p->resolution, pitch = p->pixelSize;
    } else {
        mcv_telecentric_params *p = &sensor.as.telecentric;
        p->magnification = 0.5;
        p->workingDistance = focus;
        p->numericalAperture = uniform(0.002, 0.05);
        p->radiometry = radiometry;
        image = field / 2;
        pixels = p->resolution, pitch = p->pixelSize;
    }
    for (int k = 0; k < 2; ++k) pixels[k] = PIXELS, pitch[k] = image / PIXELS;
    add_sensor(scene, sensor.type, &sensor,
               looking((const double[]){distance * s, 0, distance * c}, (const double[]){-s, 0, -c},
                       (const double[]){-c, 0, s}));
}

static mcv_scene *random_scene(uint32_t number) {
    mcv_scene *scene = mcv_scene_new("random");
    bits = 2654435761u * (number + 1);
    const bool water = one_of(4) == 0;
    add_rectangle(scene, 0.06, 0.06, spreading(scene), looking_up_z(0, 0, 0));
    add_rectangle(scene, 0.06, 0.03, spreading(scene),
                  looking((const double[]){-0.015, 0, 0.015}, (const double[]){1, 0, 0},
                          (const double[]){0, 0, 1}));
    for (int i = one_of(3); i >= 0; --i) add_smooth_body(scene);
    if (one_of(2))
        add_box(scene, (const double[]){0.002, 0.003, 0.004}, spreading(scene),
                somehow_down(0.008, 0, 0.005, 0));
    if (water)
        add_box(scene, (const double[]){0.5, 0.5, 0.5}, add_glass(scene, 1.33, uniform(0, 10), 0),
                looking_down_z(0, 0, 0));
    add_light(scene);
    if (one_of(3) == 0) add_light(scene);
    add_camera(scene);
    return scene;
}

static void test_against_chance(void **state) {
    (void)state;
    int traced = 0;
    for (uint32_t i = 0; i < SCENES; ++i) {
        mcv_scene *scene = random_scene(i);
        mcv_film films[2];
        mcv_render_stats stats[2];
        mcv_comparison c;
        for (int chance = 0; chance < 2; ++chance) {
            mcv_render_options options = mcv_render_defaults();
            options.replicates = REPLICATES;
            options.last = chance ? 4096 : 1024;
            options.seed = 1 + 2 * i + (uint32_t)chance;
            options.no_light_paths = chance;
            BUILD(mcv_render(scene, 0, &options, &films[chance], &stats[chance], &builder_error));
        }
        const bool with_light = strstr(stats[0].features, "light-tracing");
        BUILD(mcv_compare_films(&films[0], &films[1], &c, &builder_error));
        print_message("scene %u (%s, sensor %u, %s light paths): %.6g and %.6g, errors %.2g %% and "
                      "%.2g %%; %s\n",
                      i, stats[0].features, scene->sensors[0].type, with_light ? "with" : "without",
                      c.mean_x, c.mean_y, 100 * mcv_film_relative_error(&films[0]),
                      100 * mcv_film_relative_error(&films[1]), c.reason);
        /* Light that is found in a few bursts tells nothing about pixels. */
        const bool found = mcv_film_relative_error(&films[1]) <= 0.1;
        if (stats[0].saturated > 0 || stats[0].nonfinite > 0)
            fail_msg("scene %u: saturated or not finite", i);
        if (c.different && found) fail_msg("scene %u: %s", i, c.reason);
        traced += with_light && found;
        mcv_film_free(&films[0]);
        mcv_film_free(&films[1]);
        mcv_scene_free(scene);
    }
    assert_true(traced >= SCENES / 4);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_chance)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
