/* SPDX-License-Identifier: Apache-2.0 */
/* Glass by name, Abbe's number, and what becomes of colours: against data sheets, and each channel
 * against a grey render at its wavelength.
 */
#include "exact_builder.h"
#include "loader/load.h"
#include "scene/spectra.h"

/* test_glass_slow.c sets it: all cases, of which the quick test has those that no others stand for.
 */
#ifndef SLOW
#define SLOW 0
#endif

static const double line_d = 587.5618e-9, line_f = 486.1327e-9, line_c = 656.2725e-9;

/*
 * n_d and Abbe's number of data sheets, to their last digit: half of it, and as much for the lines'
 * wavelengths, which are rounded too. Of water, which has no data sheet, the index relative to air
 * at 20 °C, 1.33304, and the source's formula divided by that of air; of the plastics the source's
 * table.
 */
static void catalogue(void **state) {
    (void)state;
    static const struct {
        double n, abbe;
    } known[] = {
        {1.51680, 64.17}, {1.52249, 59.48}, {1.56883, 55.98}, {1.60738, 56.65}, {1.62041, 60.32},
        {1.62229, 53.27}, {1.71300, 53.83}, {1.65113, 55.89}, {1.85025, 32.17}, {1.67003, 47.11},
        {1.62004, 36.37}, {1.62005, 36.43}, {1.60342, 38.03}, {1.67270, 32.21}, {1.67271, 32.25},
        {1.80518, 25.43}, {1.80518, 25.36}, {1.72828, 28.53}, {1.78472, 25.68}, {1.84666, 23.78},
        {1.48656, 84.47}, {1.45846, 67.82}, {1.33304, 55.71}, {1.49100, 59.20}, {1.58500, 29.10}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        const int glass = (int)i + 1;
        const double n = mcv_glass_index(glass, line_d);
        const double abbe =
            (n - 1) / (mcv_glass_index(glass, line_f) - mcv_glass_index(glass, line_c));
        if (fabs(n - known[i].n) > 1e-5 || fabs(abbe - known[i].abbe) > 1e-2)
            fail_msg("%s has n = %g and Abbe's number %g, not %g and %g",
                     mcv_param_options("glass")[glass], n, abbe, known[i].n, known[i].abbe);
    }
    assert_null(mcv_param_options("glass")[1 + sizeof known / sizeof known[0]]);
}

static uint32_t add_named(mcv_scene *scene, int glass, double abbe_number, double ior) {
    mcv_material material;
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_DIELECTRIC), &material.as);
    material.as.dielectric.glass = glass;
    material.as.dielectric.abbeNumber = abbe_number;
    for (int k = 0; k < 3; ++k) material.as.dielectric.ior[k] = ior;
    return add_material(scene, MCV_MATERIAL_DIELECTRIC, &material);
}

enum { BK7 = 1, SF11 = 19 };

/* In a scene: the index at its wavelengths, by channel. */
static void wavelengths(void **state) {
    (void)state;
    mcv_scene *scene = new_scene();
    scene->wavelengths[0] = line_c, scene->wavelengths[1] = line_d, scene->wavelengths[2] = line_f;
    add_named(scene, BK7, 0, 1.5);
    add_named(scene, 0, 30, 1.7);
    mcv_scene_settle_spectra(scene);
    assert_int_equal(mcv_scene_channels(scene), 3);
    static const double data_sheet[] = {1.51432, 1.51680, 1.52238};
    for (int k = 0; k < 3; ++k)
        expect_near("N-BK7", true, scene->materials[0].as.dielectric.ior[k], data_sheet[k], 1e-5);
    const double *n = scene->materials[1].as.dielectric.ior;
    expect_near("n_d", true, n[1], 1.7, 1e-15);
    expect_near("Abbe's number", true, (n[1] - 1) / (n[2] - n[0]), 30, 1e-10);
    mcv_scene_free(scene);

    /* A glass alone makes no colours, a glass with an Abbe number does; one wavelength is grey
     * whatever there is. */
    for (int i = 0; i < 3; ++i) {
        scene = new_scene();
        for (int k = 0; k < 3 && i == 2; ++k) scene->wavelengths[k] = line_f;
        if (i == 0)
            add_named(scene, BK7, 0, 1.5);
        else
            add_named(scene, 0, 30, 1.7);
        mcv_scene_settle_spectra(scene);
        assert_int_equal(mcv_scene_channels(scene), i == 1 ? 3 : 1);
        mcv_scene_free(scene);
    }
}

static void bad(void **state) {
    (void)state;
    mcv_scene *scene = new_scene();
    static const struct {
        const char *word;
        mcv_dielectric_params glass;
    } cases[] = {
        {"both glass and ior", {.ior = {1.6, 1.6, 1.6}, .glass = BK7}},
        {"both glass and abbeNumber", {.ior = {1.5, 1.5, 1.5}, .glass = BK7, .abbeNumber = 30}},
        {"ior for each channel", {.ior = {1.5, 1.6, 1.7}, .abbeNumber = 30}},
        {"ior", {.ior = {1.5, 0.9, 1.5}}},
        {"ior", {.ior = {1.5, NAN, 1.5}}},
        {"abbeNumber", {.ior = {1.5, 1.5, 1.5}, .abbeNumber = -1}}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const mcv_material material = {.name = (char *)"flint",
                                       .type = MCV_MATERIAL_DIELECTRIC,
                                       .texture = MCV_NONE,
                                       .as.dielectric = cases[i].glass};
        const mcv_result result = mcv_scene_add_material(scene, &material, &builder_error);
        if (result != MCV_BAD_INPUT || !strstr(builder_error.text, cases[i].word) ||
            !strstr(builder_error.text, "flint"))
            fail_msg("\"%s\" should name flint and say \"%s\"",
                     result == MCV_OK ? "" : builder_error.text, cases[i].word);
    }
    mcv_scene_free(scene);
}

/* Of scene files: the sentence names file, material and parameter. */
static void bad_files(void **state) {
    (void)state;
    static const struct {
        const char *material, *word;
    } cases[] = {
        {"{\"type\": \"dielectric\", \"glass\": \"N-BK77\"}", "glass: \"N-BK77\" must be"},
        {"{\"type\": \"dielectric\", \"ior\": 0.9}", "ior"},
        {"{\"type\": \"dielectric\", \"ior\": [1.5, 1.5]}", "ior"},
        {"{\"type\": \"dielectric\", \"ior\": 1e999}", ""},
        {"{\"type\": \"dielectric\", \"ior\": \"NaN\"}", "ior"},
        {"{\"type\": \"dielectric\", \"roughness\": 1.5}", "roughness"},
        {"{\"type\": \"dielectric\", \"coating\": -0.1}", "coating"},
        {"{\"type\": \"conductor\", \"n\": -1, \"k\": 3}", "n: "},
        {"{\"type\": \"conductor\", \"n\": 1, \"k\": -3}", "k: "},
        {"{\"type\": \"conductor\", \"n\": 1}", "n and k must be given together"},
        {"{\"type\": \"conductor\", \"metal\": \"gold\", \"roughness\": -0.1}", "roughness"},
        {"{\"type\": \"conductor\", \"metal\": \"goold\"}", "goold"}};
    const char *path = "test_glass.gltf";
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_scene *scene;
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fprintf(file,
                "{\"asset\": {\"version\": \"2.0\"}, \"extensionsUsed\": [\"MCVISI_materials\"], "
                "\"materials\": [{\"name\": \"flint\", "
                "\"extensions\": {\"MCVISI_materials\": %s}}]}",
                cases[i].material);
        assert_int_equal(fclose(file), 0);
        const mcv_result result =
            mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &builder_error);
        remove(path);
        if (result == MCV_BAD_INPUT) print_message("  %s\n", builder_error.text);
        const bool named =
            *cases[i].word == 0 ||
            strstr(builder_error.text, "flint"); /* text that is no JSON has no material yet */
        if (result != MCV_BAD_INPUT || !strstr(builder_error.text, cases[i].word) ||
            !strstr(builder_error.text, path) || !named)
            fail_msg("%s: \"%s\" should name %s and flint and say \"%s\"", cases[i].material,
                     result == MCV_OK ? "" : builder_error.text, path, cases[i].word);
    }
}

/* KHR_materials_dispersion is 20/V_d. */
static void khr_dispersion(void **state) {
    (void)state;
    const char *path = "test_glass.gltf";
    for (int wrong = 0; wrong < 2; ++wrong) {
        mcv_scene *scene;
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fprintf(file,
                "{\"asset\": {\"version\": \"2.0\"}, \"materials\": [{\"name\": \"flint\", "
                "\"pbrMetallicRoughness\": {\"metallicFactor\": 0, "
                "\"roughnessFactor\": 0}, \"extensions\": {\"KHR_materials_transmission\": "
                "{\"transmissionFactor\": 1}, "
                "\"KHR_materials_volume\": {\"thicknessFactor\": 1}, \"KHR_materials_ior\": "
                "{\"ior\": 1.7}, \"KHR_materials_dispersion\": "
                "{\"dispersion\": %s}}}], \"extensions\": {\"MCVISI_spectrum\": {\"wavelengths\": "
                "[656.2725e-9, 587.5618e-9, "
                "486.1327e-9]}}, \"extensionsUsed\": [\"KHR_materials_transmission\", "
                "\"KHR_materials_volume\", \"KHR_materials_ior\", "
                "\"KHR_materials_dispersion\", \"MCVISI_spectrum\"]}",
                wrong ? "-1" : "0.8");
        assert_int_equal(fclose(file), 0);
        const mcv_result result =
            mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &builder_error);
        remove(path);
        if (wrong) {
            assert_int_equal(result, MCV_BAD_INPUT);
            assert_non_null(strstr(builder_error.text, "dispersion"));
            continue;
        }
        if (result != MCV_OK) fail_msg("%s", builder_error.text);
        const double *n = scene->materials[0].as.dielectric.ior;
        expect_near("n_d", true, n[1], 1.7, 1e-15);
        expect_near("Abbe's number", true, (n[1] - 1) / (n[2] - n[0]), 25, 1e-10);
        if (scene->warning_count > 0) fail_msg("warning: %s", scene->warnings[0]);
        mcv_scene_free(scene);
    }
}

/* --- images
 * -----------------------------------------------------------------------------------------------------
 */

enum { SIZE = 16, RENDERERS = 3, PIXELS = SIZE * SIZE };
static const char *const renderers[] = {"tile", "stream", "reference"};

/* A ball of flint; a camera in its centre or before it; roughness as given. */
static mcv_scene *flint_ball(bool inside, double roughness) {
    mcv_scene *scene = new_scene();
    const mcv_solid ball = sphere(0.02);
    mcv_material flint;
    mcv_params_set_defaults(mcv_material_table(MCV_MATERIAL_DIELECTRIC), &flint.as);
    flint.as.dielectric.abbeNumber = 10; /* more than any glass disperses */
    flint.as.dielectric.roughness = roughness;
    for (int k = 0; k < 3; ++k) flint.as.dielectric.ior[k] = 1.7;
    const uint32_t glass = add_material(scene, MCV_MATERIAL_DIELECTRIC, &flint);
    add_solid(scene, &ball, glass, glass);
    mcv_sensor sensor = {.name = (char *)"camera",
                         .type = MCV_SENSOR_PINHOLE,
                         .to_world = looking_down_z(0, 0, inside ? 0 : 0.1)};
    mcv_params_set_defaults(mcv_sensor_table(sensor.type), &sensor.as);
    sensor.as.pinhole.imageDistance = 0.01;
    sensor.as.pinhole.resolution[0] = sensor.as.pinhole.resolution[1] = SIZE;
    sensor.as.pinhole.pixelSize[0] = sensor.as.pinhole.pixelSize[1] = 0.3e-3;
    BUILD(mcv_scene_add_sensor(scene, &sensor, &builder_error));
    return scene;
}

static void render(const mcv_scene *scene, int renderer, mcv_render_options options,
                   mcv_image *mean, mcv_image *error) {
    mcv_render_stats stats;
    mcv_film film;
    options.schedule = renderer == 1 ? MCV_SCHEDULE_STREAM : MCV_SCHEDULE_TILE;
    if (renderer == 2)
        BUILD(mcv_reference_render(scene, 0, &options, &film, &stats, &builder_error));
    else
        BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    assert_int_equal(stats.nonfinite, 0);
    BUILD(mcv_film_develop(&film, mean, error, &builder_error));
    mcv_film_free(&film);
}

/*
 * A furnace: smooth flint is not to be seen, and from inside it the sky is n² of each channel. A
 * path brings three times that in its channel, so that the channels' shares add up to 3 without
 * noise. Rounding as in a grey furnace.
 */
static void furnace(void **state) {
    (void)state;
    for (int inside = 0; inside < 2; ++inside) {
        mcv_scene *scene = flint_ball(inside, 0);
        add_environment(scene, 1);
        /* A box that glows like the sky is not to be seen, either; with it this is the kernel
         * program of the strip below. */
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_box(scene, (const double[]){0.01, 0.02, 0.005}, add_absorber(scene),
                            looking_up_z(0.01, 0, -0.05)),
                    1, 0);
        mcv_scene_settle_spectra(scene);
        const double *n = scene->materials[0].as.dielectric.ior;
        for (int renderer = 0; renderer < RENDERERS; ++renderer) {
            mcv_render_options options = mcv_render_defaults();
            mcv_image mean;
            double sums[3] = {0};
            options.last = 16;
            options.depth = 400;
            render(scene, renderer, options, &mean, NULL);
            assert_int_equal(mean.channels, 3);
            for (int pixel = 0; pixel < PIXELS; ++pixel) {
                double sum = 0;
                for (int k = 0; k < 3; ++k) {
                    const double share =
                        mean.pixels[k * PIXELS + pixel] / (inside ? n[k] * n[k] : 1);
                    sum += share;
                    sums[k] += share / PIXELS;
                }
                if (!(fabs(sum - 3) <= 3e-4))
                    fail_msg("inside %d, %s, pixel %d: channels add up to %.8g, not 3", inside,
                             renderers[renderer], pixel, sum);
            }
            /* Each channel is drawn by a third of 64 paths per pixel: standard deviation √2 of a
             * path's value, 5 standard errors. */
            for (int k = 0; k < 3; ++k)
                expect_near(renderers[renderer], renderer == 2, sums[k], 1,
                            5 * sqrt(2.0 / (64 * PIXELS)));
            mcv_image_free(&mean);
        }
        mcv_scene_free(scene);
    }
}

/*
 * A luminous strip seen through flint, smooth or rough: each channel is what a scene of that
 * wavelength alone shows, which has one channel. Both schedules have the same bits.
 */
static void channels(void **state) {
    (void)state;
    static const double roughnesses[] = {0, 0.3};
    for (int i = SLOW; i < 1 + SLOW; ++i) {
        mcv_image coloured[RENDERERS], noise[RENDERERS];
        for (int grey = 0; grey < 4; ++grey) {
            mcv_scene *scene = flint_ball(false, roughnesses[i]);
            static const double default_wavelengths[] = {611.4e-9, 549.1e-9, 464.2e-9};
            for (int k = 0; k < 3 && grey > 0; ++k)
                scene->wavelengths[k] = default_wavelengths[grey - 1];
            add_emitter(scene, MCV_EMITTER_AREA,
                        add_rectangle(scene, 0.004, 0.1, add_absorber(scene),
                                      looking_up_z(0.001, 0, -0.035)),
                        1, 0);
            add_environment(scene, 0); /* dark: the furnace has one */
            mcv_scene_settle_spectra(scene);
            for (int renderer = 0; renderer < RENDERERS; ++renderer) {
                mcv_render_options options = mcv_render_defaults();
                mcv_image mean, error;
                options.last = 64;
                options.replicates = 16;
                options.seed = (uint32_t)(10 * grey);
                if (grey > 0 && renderer == 1) continue;
                render(scene, renderer, options, &mean, &error);
                assert_int_equal(mean.channels, grey ? 1 : 3);
                if (grey == 0) {
                    coloured[renderer] = mean;
                    noise[renderer] = error;
                    continue;
                }
                double worst = 0, shift = 0, variance = 0;
                for (int pixel = 0; pixel < PIXELS; ++pixel) {
                    const int at = (grey - 1) * PIXELS + pixel;
                    const double off = coloured[renderer].pixels[at] - mean.pixels[pixel];
                    const double se =
                        hypot((double)noise[renderer].pixels[at], (double)error.pixels[pixel]);
                    if (se > 0) worst = fmax(worst, fabs(off) / se);
                    shift += off;
                    variance += se * se;
                }
                /* t with 15 degrees of freedom each: of 256 pixels 7 in 1 of 1e4; the sum 4.5
                 * (normal: 1e-5). */
                print_message(
                    "roughness %g, channel %d, %s: worst pixel %.2f, sum %.2f standard errors\n",
                    roughnesses[i], grey - 1, renderers[renderer], worst, shift / sqrt(variance));
                assert_true(worst > 0 && worst < 7);
                assert_true(fabs(shift) < 4.5 * sqrt(variance));
                mcv_image_free(&mean);
                mcv_image_free(&error);
            }
            mcv_scene_free(scene);
        }
        assert_memory_equal(coloured[0].pixels, coloured[1].pixels, 3 * sizeof(float) * PIXELS);
        /* And the channels do differ: by more than their noise. */
        double apart = 0, variance = 0;
        for (int pixel = 0; pixel < PIXELS; ++pixel) {
            apart +=
                fabs((double)coloured[0].pixels[pixel] - coloured[0].pixels[2 * PIXELS + pixel]);
            variance +=
                pow(noise[0].pixels[pixel], 2) + pow(noise[0].pixels[2 * PIXELS + pixel], 2);
        }
        assert_true(apart > 10 * sqrt(variance));
        for (int renderer = 0; renderer < RENDERERS; ++renderer) {
            mcv_image_free(coloured + renderer);
            mcv_image_free(noise + renderer);
        }
    }
}

/* Light paths: the lines behind a prism are where, and as bright as, those of scenes of one
 * wavelength. */
static void light_paths(void **state) {
    (void)state;
    static const char *const wavelengths[] = {NULL, "spectrum/wavelengths=611.4nm",
                                              "spectrum/wavelengths=549.1nm",
                                              "spectrum/wavelengths=464.2nm"};
    enum { WIDTH = 56, HEIGHT = 42, COUNT = WIDTH * HEIGHT };
    mcv_image coloured = {0}, noise = {0};
    for (int grey = 0; grey < 4; ++grey) {
        const char *overrides[] = {"sensors/camera/resolution=[56, 42]",
                                   "sensors/camera/pixelSize=72um", wavelengths[grey]};
        mcv_render_options options = mcv_render_defaults();
        mcv_scene *scene;
        mcv_image mean, error;
        BUILD(mcv_scene_load(MCV_SOURCE_DIR "/scenes/prism.gltf",
                             (mcv_overrides){overrides, grey ? 3 : 2}, &scene, &builder_error));
        options.last = 64;
        options.replicates = 16;
        options.seed = (uint32_t)grey;
        render(scene, 0, options, &mean, &error);
        mcv_scene_free(scene);
        if (grey == 0) {
            coloured = mean;
            noise = error;
            continue;
        }
        double sums[2] = {0}, rows[2] = {0}, variance = 0;
        for (int i = 0; i < COUNT; ++i) {
            const size_t at = (size_t)(grey - 1) * COUNT + (size_t)i;
            const double v[2] = {coloured.pixels[at], mean.pixels[i]};
            for (int k = 0; k < 2; ++k) sums[k] += v[k], rows[k] += v[k] * (i / WIDTH);
            variance += pow(noise.pixels[at], 2) + pow(error.pixels[i], 2);
        }
        print_message("channel %d: %.5g and %.5g, row %.3f and %.3f\n", grey - 1, sums[0], sums[1],
                      rows[0] / sums[0], rows[1] / sums[1]);
        /* Splats of one replicate are correlated by its points: the pixels' errors overestimate the
         * sum's, if anything. */
        expect_near("light of a line", false, sums[0], sums[1], 5 * sqrt(variance));
        /* A line is 10 pixels long and 1 high, tilted over 3 rows: its centre is known to its
         * standard deviation by its light's error. */
        expect_near("row of a line", false, rows[0] / sums[0], rows[1] / sums[1],
                    5 * 3 * sqrt(variance) / sums[1]);
        assert_true(sums[1] > 0);
        mcv_image_free(&mean);
        mcv_image_free(&error);
    }
    mcv_image_free(&coloured);
    mcv_image_free(&noise);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(catalogue), cmocka_unit_test(wavelengths),    cmocka_unit_test(bad),
        cmocka_unit_test(bad_files), cmocka_unit_test(khr_dispersion), cmocka_unit_test(furnace),
        cmocka_unit_test(channels),
    };
    const struct CMUnitTest long_tests[] = {cmocka_unit_test(channels),
                                            cmocka_unit_test(light_paths)};
    return SLOW ? cmocka_run_group_tests(long_tests, NULL, NULL)
                : cmocka_run_group_tests(tests, NULL, NULL);
}
