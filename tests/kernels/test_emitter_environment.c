/* SPDX-License-Identifier: Apache-2.0 */
/* The environment with an image: which pixel stands where in the sky, how much light comes from it,
 * what is refused. */
#include "image_emitters.h"

#include "reference/vector.h"
#include "device/pack.h"

enum { WIDTH = 8, HEIGHT = 5, PIXELS = 40 };

#define NAMED "\"type\":\"environment\","
#define CAMERA "\"type\":\"pinhole\",\"imageDistance\":1,\"resolution\":[40,40],\"pixelSize\":0.05"

/* The pixel of a direction in the environment's frame, and how far it is from the pixel's edges, in
 * pixels. */
static double pixel_of(ref_vec d, int *column, int *row) {
    const double across = WIDTH * (0.5 + atan2(d.x, -d.z) / (2 * M_PI)),
                 down = HEIGHT * atan2(hypot(d.x, d.z), d.y) / M_PI;
    *column = (int)fmin(floor(across), WIDTH - 1);
    *row = (int)fmin(floor(down), HEIGHT - 1);
    return fmin(fabs(across - round(across)), fabs(down - round(down)));
}

/*
 * Cameras of 90° that look along the six axes of the environment's node see the whole sky, each
 * camera pixel one of the image's but for those with an edge in them. One product of float32, and a
 * sum of equal values: 1e-6.
 */
static void test_each_pixel_is_where_it_belongs(void **state) {
    (void)state;
    static const double axes[6][2][3] = {{{0, 0, -1}, {0, 1, 0}}, {{1, 0, 0}, {0, 1, 0}},
                                         {{0, 0, 1}, {0, 1, 0}},  {{-1, 0, 0}, {0, 1, 0}},
                                         {{0, 1, 0}, {1, 0, 0}},  {{0, -1, 0}, {1, 0, 0}}};
    write_png("environment.png", WIDTH, HEIGHT);
    for (int i = 0; i < 4; ++i) {
        mcv_scene *scene;
        size_t compared = 0;
        char *text = rig_text(rigs[i >> 1], NAMED "\"image\":0,\"radiance\":2", CAMERA, 0.1,
                              "environment.png");
        BUILD(load_text("environment.gltf", text, NULL, &scene, &builder_error));
        /* Too small for a sample to meet it; the program is that of the sky with a sun. */
        add_rectangle(scene, 1e-3, 1e-3, add_diffuse(scene, 0.5), looking_down_z(0, 0, 100));
        for (int view = 0; view < 6; ++view) {
            const mcv_transform place =
                looking((const double[]){0, 0, 0}, axes[view][0], axes[view][1]);
            const mcv_transform in_world =
                mcv_transform_compose(&scene->emitters[0].to_world, &place);
            mcv_image mean, error;
            add_pinhole(scene, PIXELS, 2, in_world);
            mcv_film film = render_by(i & 1, scene, scene->sensor_count - 1, 1, 1);
            BUILD(mcv_film_develop(&film, &mean, &error, &builder_error));
            for (int p = 0; p < PIXELS * PIXELS; ++p) {
                int column = 0, row = 0, columns[4], rows[4];
                bool one = true;
                for (int corner = 0; corner < 4; ++corner) {
                    const double c = 2.0 * (p % PIXELS + (corner & 1)) / PIXELS - 1,
                                 r = 1 - 2.0 * (p / PIXELS + (corner >> 1)) / PIXELS;
                    const double *m = place.m; /* columns right, up, back */
                    const ref_vec d = {c * m[0] + r * m[1] - m[2], c * m[3] + r * m[4] - m[5],
                                       c * m[6] + r * m[7] - m[8]};
                    const double edge = pixel_of(ref_unit(d), columns + corner, rows + corner);
                    one = one && edge > 1e-3 && columns[corner] == columns[0] &&
                          rows[corner] == rows[0];
                }
                /* The poles lie between camera pixels: corners touch them there, and edges. */
                if (!one) continue;
                column = columns[0];
                row = rows[0];
                uint8_t rgb[3];
                value_of(WIDTH, HEIGHT, (uint32_t)column, (uint32_t)row, rgb);
                ++compared;
                for (int k = 0; k < 3; ++k) {
                    const double expected = 2 * linear(rgb[k]),
                                 seen = mean.pixels[k * PIXELS * PIXELS + p];
                    if (!(fabs(seen - expected) <= 1e-6 * expected))
                        fail_msg("%s, rig {%s}, view %d: pixel (%d, %d) channel %d is %.9g, "
                                 "expected %.9g of (%d, %d)",
                                 i & 1 ? "reference" : "device", rigs[i >> 1], view, p % PIXELS,
                                 p / PIXELS, k, seen, expected, column, row);
                }
            }
            mcv_image_free(&mean);
            mcv_image_free(&error);
            mcv_film_free(&film);
        }
        assert_true(compared > 6 * PIXELS * PIXELS / 2);
        mcv_scene_free(scene);
        free(text);
    }
}

/* An OpenEXR image whose pixels are all `rest`, but for one. */
static void write_sky(uint32_t width, uint32_t height, float rest, uint32_t column, uint32_t row,
                      float sun) {
    mcv_image image;
    BUILD(mcv_image_new(&image, width, height, 1, &builder_error));
    for (uint32_t i = 0; i < width * height; ++i) image.pixels[i] = rest;
    image.pixels[row * width + column] = sun;
    const mcv_exr_part part = {.name = "part", .image = image};
    BUILD(mcv_exr_write(MCV_BINARY_DIR "/tests/sky.exr", &part, 1, NULL, 0, &builder_error));
    mcv_image_free(&image);
}

/* ∫ max(0, n·d) dΩ over a pixel, in the environment's frame, by the midpoint rule of 400 x 400
 * points: 1e-5 of it and better. */
static double projected(uint32_t width, uint32_t height, uint32_t column, uint32_t row, ref_vec n) {
    enum { STEPS = 400 };
    double sum = 0;
    for (int i = 0; i < STEPS * STEPS; ++i) {
        const double polar = M_PI * (row + (i / STEPS + 0.5) / STEPS) / height;
        const double longitude = 2 * M_PI * ((column + (i % STEPS + 0.5) / STEPS) / width - 0.5);
        const ref_vec d = {sin(polar) * sin(longitude), cos(polar), -sin(polar) * cos(longitude)};
        sum += fmax(0, ref_dot(n, d)) * sin(polar);
    }
    return sum * 2 * M_PI * M_PI / ((double)width * height * STEPS * STEPS);
}

/*
 * A floor that faces n sees a sun of one pixel in a sky of radiance 1: E = π + (L - 1) ∫ n·d dΩ.
 * What the midpoint rule and float32 leave is 2e-5. That the sun is looked for shows in the error:
 * found by chance alone it were larger than the mean.
 */
static void test_sky_with_sun(void **state) {
    (void)state;
    static const struct {
        uint32_t width, height, column, row;
        float rest, sun;
        double error;
    } skies[] = {{64, 32, 40, 9, 1, 1, 0.005},        {64, 32, 40, 9, 1, 5000, 0.005},
                 {512, 256, 130, 60, 0, 3e5F, 0.002}, {512, 256, 300, 127, 0, 3e5F, 0.01},
                 {37, 19, 5, 9, 1, 100, 0.01},        {64, 32, 40, 0, 0.5F, 1e5F, 0.005}};
    const double rho = 0.5, s = sqrt(0.5);
    for (size_t i = 0; i < 2 * sizeof skies / sizeof skies[0]; ++i) {
        const uint32_t width = skies[i / 2].width, height = skies[i / 2].height;
        mcv_scene *scene;
        char what[64];
        write_sky(width, height, skies[i / 2].rest, skies[i / 2].column, skies[i / 2].row,
                  skies[i / 2].sun);
        char *text = rig_text(rigs[i & 1], NAMED "\"image\":{\"uri\":\"sky.exr\"},\"radiance\":3",
                              CAMERA, 0.1, "environment.png");
        BUILD(load_text("environment.gltf", text, NULL, &scene, &builder_error));
        /* It faces the rig's +y. */
        const mcv_transform floor = looking((const double[]){0, 0, 0}, (const double[]){0, 1, 0},
                                            (const double[]){1, 0, 0});
        const mcv_transform camera = looking((const double[]){s, s, 0}, (const double[]){-s, -s, 0},
                                             (const double[]){-s, s, 0});
        add_rectangle(scene, 4, 4, add_diffuse(scene, rho),
                      mcv_transform_compose(&scene->emitters[0].to_world, &floor));
        add_pinhole(scene, 4, 0.1, mcv_transform_compose(&scene->emitters[0].to_world, &camera));
        mcv_film film = render_by(false, scene, 1, 256, 1);
        const double bright = skies[i / 2].sun - skies[i / 2].rest;
        const double irradiance =
            M_PI * skies[i / 2].rest + bright * projected(width, height, skies[i / 2].column,
                                                          skies[i / 2].row, (ref_vec){0, 1, 0});
        snprintf(what, sizeof what, "sky of %u x %u, sun of %g", width, height, skies[i / 2].sun);
        expect_estimate(what, image_estimate(&film), rho / M_PI * 3 * irradiance,
                        skies[i / 2].error, 2e-5);
        mcv_film_free(&film);
        mcv_scene_free(scene);
        free(text);
    }
}

/*
 * A sun that brings as much as the sky around it: with random numbers a choice between both by
 * their power has a variance of 1/4 of the squared mean. Next-event estimation leaves the sky to
 * the floor's own choice of directions, which finds it without noise; 1/64 of the sky's light, the
 * share s of the choices is 0.03 then, leaves s/4, and the power heuristic at most as much again.
 */
static void test_sun_is_not_weighed_against_the_sky(void **state) {
    (void)state;
    enum { WIDE = 64, HIGH = 32, COLUMN = 40, ROW = 9, SAMPLES = 256, SIDE = 4 };
    const ref_vec up = {0, 1, 0};
    const double seen = projected(WIDE, HIGH, COLUMN, ROW, up), s = sqrt(0.5);
    write_sky(WIDE, HIGH, 1, COLUMN, ROW, (float)(1 + M_PI / seen));
    char *text = rig_text(rigs[0], NAMED "\"image\":{\"uri\":\"sky.exr\"},\"radiance\":1", CAMERA,
                          0.1, "environment.png");
    mcv_scene *scene;
    BUILD(load_text("environment.gltf", text, NULL, &scene, &builder_error));
    add_rectangle(
        scene, 4, 4, add_diffuse(scene, 0.5),
        looking((const double[]){0, 0, 0}, (const double[]){0, 1, 0}, (const double[]){1, 0, 0}));
    add_pinhole(scene, SIDE, 0.1,
                looking((const double[]){s, s, 0}, (const double[]){-s, -s, 0},
                        (const double[]){-s, s, 0}));
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    options.replicates = REPLICATES;
    options.last = SAMPLES;
    options.sampler = MCV_SAMPLER_RANDOM;
    BUILD(mcv_render(scene, 1, &options, &film, &stats, &builder_error));
    const double share = 2.0 / 64 / (1 + 2.0 / 64),
                 error = sqrt(share / 2 / (SAMPLES * REPLICATES * SIDE * SIDE));
    /* The error is estimated from the spread of the replicates: twice it is out of reach. */
    expect_estimate("sun and sky of the same power", image_estimate(&film), 0.5 * 2, 2 * error,
                    2e-5);
    mcv_film_free(&film);
    mcv_scene_free(scene);
    free(text);
}

/* A box before a colourful sky looks the same to the reference, which does not look for the sky. */
static void test_reference_agrees(void **state) {
    (void)state;
    mcv_scene *scene;
    char *text =
        rig_text(rigs[1], NAMED "\"image\":0,\"radiance\":2", CAMERA, 0.1, "environment.png");
    BUILD(load_text("environment.gltf", text, NULL, &scene, &builder_error));
    add_box(scene, (const double[]){0.2, 0.3, 0.1}, add_diffuse(scene, 0.7),
            mcv_transform_identity());
    add_rectangle(scene, 3, 3, add_diffuse(scene, 0.5), looking_up_z(0, 0, -0.1));
    add_pinhole(scene, 16, 1,
                looking((const double[]){0, -1.2, 1.6}, (const double[]){0, 0.6, -0.8},
                        (const double[]){0, 0.8, 0.6}));
    mcv_film film = render_by(false, scene, 1, 16, 1), expected = render_by(true, scene, 1, 16, 2);
    expect_same_picture("box before a sky", &film, &expected);
    mcv_film_free(&film);
    mcv_film_free(&expected);
    mcv_scene_free(scene);
    free(text);
}

/* A constant environment has nothing of it: no image, nobody who looks for it, the same words per
 * path. */
static void test_constant_costs_nothing(void **state) {
    (void)state;
    mcv_scene *scene = mcv_scene_new("constant");
    mcv_packed packed;
    add_rectangle(scene, 1, 1, add_diffuse(scene, 0.5), looking_up_z(0, 0, 0));
    add_environment(scene, 2);
    BUILD(mcv_pack(scene, NULL, &packed, &builder_error));
    assert_int_equal(packed.features, MCV_FEATURE_BIT(DIFFUSE) | MCV_FEATURE_BIT(ENVIRONMENT));
    assert_int_equal(packed.emitter_count, 0);
    mcv_packed_free(&packed);
    mcv_scene_free(scene);
}

static void test_bad_input(void **state) {
    (void)state;
    static const bad_emitter cases[] = {
        {NAMED "\"image\":1", "emitters/e/image: "},
        {NAMED "\"image\":{\"uri\":\"none.exr\"}", "emitters/e/image: \"none.exr\" "},
        {NAMED "\"image\":0,\"power\":1", "emitters/e: unknown key \"power\""},
        {NAMED "\"image\":0,\"radiance\":-1", "emitters/e/radiance: "},
    };
    refuse_emitters(cases, sizeof cases / sizeof cases[0], "environment.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_each_pixel_is_where_it_belongs),
        cmocka_unit_test(test_sky_with_sun),
        cmocka_unit_test(test_sun_is_not_weighed_against_the_sky),
        cmocka_unit_test(test_reference_agrees),
        cmocka_unit_test(test_constant_costs_nothing),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
