/* SPDX-License-Identifier: Apache-2.0 */
/* The collimated beam: how bright it is, where each pixel of its image lands, where it ends, how
 * much it carries, what is refused. */
#include "image_emitters.h"

#include "reference/lights.h"
#include "scene/emitters.h"

enum { WIDTH = 6, HEIGHT = 4 };

#define NAMED "\"type\":\"collimatedBeam\",\"size\":[\"6mm\",\"4mm\"],"

/*
 * A wall of reflectance ρ 0.2 m before the emitter, tilted by 45° about the rig's x axis, and a
 * telecentric camera of scale 1 that looks at it from above: its right is the emitter's, and what
 * both foreshorten is the same, so that pixel (i, j) sees pixel (i, j) of the beam.
 */
static const double rho = 0.5;

static void add_wall_and_camera(mcv_scene *scene, uint32_t width, uint32_t height, double pixel) {
    const double s = sqrt(0.5);
    const mcv_transform rig = scene->instances[scene->emitters[0].instance].to_world;
    const mcv_transform wall =
        looking((const double[]){0, 0, -0.2}, (const double[]){0, s, s}, (const double[]){1, 0, 0});
    const mcv_transform above = looking((const double[]){0, 0.3, -0.2}, (const double[]){0, -1, 0},
                                        (const double[]){0, 0, -1});
    mcv_sensor camera = sensor_defaults(MCV_SENSOR_TELECENTRIC);
    camera.as.telecentric.magnification = 1;
    camera.as.telecentric.workingDistance = 0.3;
    camera.as.telecentric.numericalAperture = 1e-6;
    camera.as.telecentric.resolution[0] = width;
    camera.as.telecentric.resolution[1] = height;
    camera.as.telecentric.pixelSize[0] = camera.as.telecentric.pixelSize[1] = pixel;
    add_rectangle(scene, 0.2, 0.2, add_diffuse(scene, rho), mcv_transform_compose(&rig, &wall));
    add_sensor(scene, MCV_SENSOR_TELECENTRIC, &camera, mcv_transform_compose(&rig, &above));
}

/*
 * L = ρ/π E cos 45° times the pixel's value, with no noise: every sample gives the same. Some 10
 * roundings of float32 make 1e-6; samples nearer to a pixel's edge than the 1e-7 of rounding may
 * show its neighbour, but none of these fixed ones does.
 */
static void test_each_pixel_is_where_it_belongs(void **state) {
    (void)state;
    write_png("beam.png", WIDTH, HEIGHT);
    for (int i = 0; i < 8; ++i) {
        const bool mirror = i & 1, reference = i & 2;
        const char *rig = rigs[i >> 2];
        mcv_scene *scene;
        mcv_image mean, error;
        char *emitter =
            text_of(NAMED "\"image\":0,\"mirror\":%s,\"irradiance\":2", mirror ? "true" : "false");
        char *text = rig_text(rig, emitter, ONE_PIXEL, 0.1, "beam.png");
        BUILD(load_text("beam.gltf", text, NULL, &scene, &builder_error));
        add_wall_and_camera(scene, WIDTH, HEIGHT, 1e-3);
        mcv_film film = render_by(reference, scene, 1, 16, 1);
        BUILD(mcv_film_develop(&film, &mean, &error, &builder_error));
        for (uint32_t row = 0; row < HEIGHT; ++row) {
            for (uint32_t column = 0; column < WIDTH; ++column) {
                uint8_t rgb[3];
                value_of(WIDTH, HEIGHT, mirror ? WIDTH - 1 - column : column, row, rgb);
                for (uint32_t k = 0; k < 3; ++k) {
                    const double expected = rho / M_PI * 2 * sqrt(0.5) * linear(rgb[k]);
                    const double seen = mean.pixels[(k * HEIGHT + row) * WIDTH + column];
                    if (!(fabs(seen - expected) <= 1e-6 * expected))
                        fail_msg("%s, rig {%s}, mirror %d: pixel (%u, %u) channel %u is %.9g, "
                                 "expected %.9g",
                                 reference ? "reference" : "device", rig, mirror, column, row, k,
                                 seen, expected);
                }
            }
        }
        mcv_image_free(&mean);
        mcv_image_free(&error);
        mcv_film_free(&film);
        mcv_scene_free(scene);
        free(text);
        free(emitter);
    }
}

/* Inside and outside of its edge by 1e-4 of the beam's half-width, all around: the whole rectangle,
 * and the disk in it. */
static void test_the_beam_ends(void **state) {
    (void)state;
    for (int i = 0; i < 4; ++i) {
        const bool circle = i & 1, reference = i & 2;
        for (int k = 0; k < 24; ++k) {
            const double angle = 2 * M_PI * (k / 2 + 0.3) / 12, c = cos(angle), s = sin(angle);
            const double edge = circle ? 0.002 : fmin(0.003 / fabs(c), 0.002 / fabs(s));
            const double r = edge * (k & 1 ? 1.0001 : 0.9999);
            mcv_scene *scene;
            char *emitter =
                text_of(NAMED "\"aperture\":\"%s\",\"irradiance\":3", circle ? "circle" : "square");
            char *text = rig_text("", emitter, ONE_PIXEL, 0.1, "beam.png");
            BUILD(load_text("beam.gltf", text, NULL, &scene, &builder_error));
            add_rectangle(scene, 0.1, 0.1, add_diffuse(scene, rho), looking_up_z(0, 0, -0.2));
            const double from[3] = {r * c + 0.1, r * s, -0.1},
                         forward[3] = {-sqrt(0.5), 0, -sqrt(0.5)};
            add_pinhole(scene, 1, 1e-7, looking(from, forward, (const double[]){0, 1, 0}));
            mcv_film film = render_by(reference, scene, 1, 1, 1);
            const double expected = k & 1 ? 0 : rho / M_PI * 3, seen = mcv_film_mean(&film);
            if (!(fabs(seen - expected) <= 1e-6 * expected))
                fail_msg("%s, %s: %g of the edge at %g rad it is %.9g, expected %.9g",
                         reference ? "reference" : "device", circle ? "circle" : "square", r / edge,
                         angle, seen, expected);
            mcv_film_free(&film);
            mcv_scene_free(scene);
            free(text);
            free(emitter);
        }
    }
}

/* A part before the emitter throws a shadow with a sharp edge; a camera that looks into the beam
 * sees nothing. */
static void test_shadow_and_sight(void **state) {
    (void)state;
    for (int reference = 0; reference < 2; ++reference) {
        mcv_scene *scene;
        char *text = rig_text("", NAMED "\"irradiance\":3", ONE_PIXEL, 0.1, "beam.png");
        BUILD(load_text("beam.gltf", text, NULL, &scene, &builder_error));
        /* Far aside: with a surface that spreads light the program is that of the beam's edge. */
        add_rectangle(scene, 0.01, 0.01, add_diffuse(scene, rho), looking_up_z(10, 0, 0));
        mcv_film film = render_by(reference, scene, 0, 4, 1);
        assert_true(mcv_film_mean(&film) == 0);
        mcv_film_free(&film);
        add_wall_and_camera(scene, 2, 1, 1e-3);
        /* From x = 0 on to the right, between the emitter and the wall. */
        add_rectangle(scene, 0.01, 0.02, add_absorber(scene), looking_down_z(0.005, 0, -0.1));
        film = render_by(reference, scene, 1, 4, 1);
        const double *sums = film.sums, lit = rho / M_PI * 3 * sqrt(0.5) * 4;
        if (!(fabs(sums[0] - lit) <= 1e-6 * lit && sums[1] == 0))
            fail_msg("%s: %.9g and %.9g beside the shadow's edge, expected %.9g and 0",
                     reference ? "reference" : "device", sums[0], sums[1], lit);
        mcv_film_free(&film);
        mcv_scene_free(scene);
        free(text);
    }
}

static void test_power_arrives(void **state) {
    (void)state;
    static const double power[3] = {1, 2, 0.25};
    for (int i = 0; i < 2; ++i) {
        char *emitter = text_of("\"type\":\"collimatedBeam\",\"size\":[0.024,0.016],\"image\":0,"
                                "\"aperture\":\"%s\",\"power\":[1,2,0.25]",
                                i ? "circle" : "square");
        char *text = rig_text(i ? rigs[0] : "", emitter, ONE_PIXEL, 0.1, "beam.png");
        expect_power(text, power, 0.026, 0, i ? "round beam" : "rectangular beam");
        free(text);
        free(emitter);
    }
}

/* The mean of the image over the round aperture, counted on a grid of 2000 x 2000 points: its edge
 * is that fine. */
static void test_mean_of_image(void **state) {
    (void)state;
    enum { POINTS = 2000 };
    mcv_scene *scene;
    double sum[3] = {0, 0, 0}, inside = 0, mean[3];
    char *text = rig_text("", NAMED "\"image\":0,\"aperture\":\"circle\",\"irradiance\":1",
                          ONE_PIXEL, 0.1, "beam.png");
    BUILD(load_text("beam.gltf", text, NULL, &scene, &builder_error));
    for (int i = 0; i < POINTS * POINTS; ++i) {
        const double x = (i % POINTS + 0.5) / POINTS, y = (i / POINTS + 0.5) / POINTS;
        uint8_t rgb[3];
        if (hypot((x - 0.5) * 6, (y - 0.5) * 4) > 2) continue;
        value_of(WIDTH, HEIGHT, (uint32_t)(x * WIDTH), (uint32_t)(y * HEIGHT), rgb);
        for (int k = 0; k < 3; ++k) sum[k] += linear(rgb[k]);
        inside += 1;
    }
    mcv_emitter_image_mean(scene, &scene->emitters[0], mean);
    for (int k = 0; k < 3; ++k)
        if (!(fabs(mean[k] - sum[k] / inside) <= mean[k] / POINTS))
            fail_msg("channel %d: mean %.9g, counted %.9g", k, mean[k], sum[k] / inside);
    mcv_scene_free(scene);
    free(text);
}

static void test_bad_input(void **state) {
    (void)state;
    static const bad_emitter cases[] = {
        {NAMED "\"radiance\":1", "emitters/e: unknown key \"radiance\""},
        {NAMED "\"halfAngle\":0,\"power\":1", "emitters/e: unknown key \"halfAngle\""},
        {NAMED "\"aperture\":\"circle\"", "emitters/e: needs irradiance [W/m²] or power [W]"},
        {NAMED "\"irradiance\":1,\"power\":1", "emitters/e: has both irradiance 1 and power 1"},
        {NAMED "\"irradiance\":-1", "emitters/e/irradiance: -1 must lie from 0"},
        {NAMED "\"irradiance\":1,\"aperture\":\"disk\"",
         "emitters/e/aperture: \"disk\" must be \"square\" or \"circle\""},
        {NAMED "\"irradiance\":1,\"image\":3", "emitters/e/image: "},
        {NAMED "\"irradiance\":1,\"image\":{\"uri\":\"none.exr\"}",
         "emitters/e/image: \"none.exr\" "},
        {"\"type\":\"collimatedBeam\",\"irradiance\":1", "emitters/e/size: is missing"},
        {"\"type\":\"collimatedBeam\",\"size\":0,\"irradiance\":1",
         "emitters/e/size: 0 must be above 0"},
        {"\"type\":\"bulb\",\"size\":1", "emitters/e/type: unknown type \"bulb\": known are "
                                         "parallel, telecentricProjector, lightField, projector, "
                                         "area, screen, environment, "
                                         "collimatedBeam"},
        {"\"type\":\"unknown\"", "known are parallel, "},
        {"\"type\":\"parallel\",\"size\":1,\"radiance\":1,\"halfAngle\":0",
         "use the type \"collimatedBeam\""},
    };
    refuse_emitters(cases, sizeof cases / sizeof cases[0], "beam.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_pixel_is_where_it_belongs),
        cmocka_unit_test(test_the_beam_ends),
        cmocka_unit_test(test_shadow_and_sight),
        cmocka_unit_test(test_power_arrives),
        cmocka_unit_test(test_mean_of_image),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
