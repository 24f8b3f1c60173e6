/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* Camera rays of both renderers: the report's maps, orientation, both radiometries. */
#include "elements.h"
#include "reference_checks.h"

#include <float.h>

/* A sensor with W x H pixels of 10 µm and what else the test sets; resolved by the scene, as from a
 * file. */
static mcv_scene *scene_with(uint32_t type, const mcv_sensor *values) {
    mcv_scene *scene = mcv_scene_new("sensor");
    add_sensor(scene, type, values, looking_down_z(0, 0, 0));
    return scene;
}

static const double pixel = 10e-6;

static mcv_sensor telecentric(uint32_t width, uint32_t height) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_TELECENTRIC);
    mcv_telecentric_params *p = &sensor.as.telecentric;
    p->focalLength = 0.05;
    p->imageDistance = 0.0625; /* m = 1/4, in focus at 0.25 m */
    p->stopDiameter = 0.008;
    p->lensDiameter = 0.05;
    p->resolution[0] = width;
    p->resolution[1] = height;
    p->pixelSize[0] = p->pixelSize[1] = pixel;
    return sensor;
}

static mcv_sensor thin_lens(uint32_t width, uint32_t height, double image_distance) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_THIN_LENS);
    mcv_thin_lens_params *p = &sensor.as.thin_lens;
    p->focalLength = 0.025;
    p->imageDistance = image_distance;
    p->lensDiameter = 0.006;
    p->resolution[0] = width;
    p->resolution[1] = height;
    p->pixelSize[0] = p->pixelSize[1] = pixel;
    return sensor;
}

static mcv_sensor light_field(int aperture) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_LIGHT_FIELD);
    mcv_light_field_params *p = &sensor.as.light_field;
    p->focalLength = 0.05;
    p->imageDistance = 0.06;
    p->lensDiameter = 0.02;
    p->spatialResolution[0] = 16;
    p->spatialResolution[1] = 12;
    p->angularResolution[0] = 5;
    p->angularResolution[1] = 3;
    p->pixelSize[0] = p->pixelSize[1] = pixel;
    p->aperture = aperture;
    return sensor;
}

/* Where a camera ray is at a depth before the lens. */
static ref_vec at_depth(ref_sensor_ray sight, double depth) {
    return ref_add(sight.origin,
                   ref_scale((depth + sight.origin.z) / -sight.direction.z, sight.direction));
}

/* Directions are rounded a few times; at depth z a place is off by a few ulp of z and of the
 * origin. */
static double place_bound(bool reference, double depth) {
    return 16 * (reference ? DBL_EPSILON : 0x1p-24) * (depth + 0.1);
}

enum { CASES = 1024 };
static uint32_t cases[6 * CASES]; /* column, row, x, y, two numbers for the aperture */
static ref_sensor_ray sights[CASES];

static void set_case(size_t i, uint32_t column, uint32_t row, float x, float y, float xi,
                     float eta) {
    const uint32_t in[6] = {column, row, as_uint(x), as_uint(y), as_uint(xi), as_uint(eta)};
    memcpy(cases + 6 * i, in, sizeof in);
}

static void look_by(bool reference, const mcv_scene *scene) {
    checked = reference ? "reference" : "device";
    sights_by(reference, &scene->sensors[0], CASES, cases, sights);
}

/* T22: the chief ray's place is the image point over m at every depth. */
static void test_telecentric_magnification(void **state) {
    const mcv_sensor sensor = telecentric(100, 80);
    mcv_scene *scene = scene_with(MCV_SENSOR_TELECENTRIC, &sensor);
    (void)state;
    for (size_t i = 0; i < CASES; ++i)
        set_case(i, (uint32_t)(i % 100), (uint32_t)(i % 80), 0.25F, 0.75F, 0.5F, 0.5F);
    for (int reference = 0; reference < 2; ++reference) {
        double worst = 0;
        look_by(reference, scene);
        for (size_t i = 0; i < CASES; ++i)
            for (int step = -2; step <= 2; ++step) {
                const ref_vec place = at_depth(sights[i], 0.25 + 0.01 * step);
                worst = worse(worst, fabs(place.x - ((double)(i % 100) + 0.25 - 50) * pixel * 4));
                worst = worse(worst, fabs(place.y - (40 - ((double)(i % 80) + 0.75)) * pixel * 4));
            }
        check("T22 telecentric: chief rays over +-20 mm of depth [m]", worst, 0,
              place_bound(reference, 0.27));
    }
    mcv_scene_free(scene);
}

/* All rays of an image point meet in the plane in focus. */
static void test_focus(void **state) {
    const mcv_sensor sensors[] = {thin_lens(100, 80, 0.03), telecentric(100, 80)};
    const double depth[] = {0.15, 0.25}, scale[] = {5, 4}; /* 1/f - 1/b, object over image size */
    (void)state;
    for (int i = 0; i < 2; ++i) {
        mcv_scene *scene = scene_with(sensors[i].type, &sensors[i]);
        ref_random random = {9};
        for (size_t k = 0; k < CASES; ++k) {
            const uint32_t column = (uint32_t)(100 * ref_random_unit(&random)),
                           row = (uint32_t)(80 * ref_random_unit(&random));
            const float xi = (float)(0.999 * ref_random_unit(&random)),
                        eta = (float)(0.999 * ref_random_unit(&random));
            set_case(k, column, row, 0.5F, 0.5F, xi, eta);
        }
        for (int reference = 0; reference < 2; ++reference) {
            double worst = 0, spread = 0;
            look_by(reference, scene);
            for (size_t k = 0; k < CASES; ++k) {
                const ref_vec place = at_depth(sights[k], depth[i]);
                worst = worse(worst, fabs(place.x - (cases[6 * k] + 0.5 - 50) * pixel * scale[i]));
                worst = worse(worst,
                              fabs(place.y - (40 - (cases[6 * k + 1] + 0.5)) * pixel * scale[i]));
                spread = fmax(spread, hypot(sights[k].origin.x, sights[k].origin.y));
            }
            check(i ? "T23 telecentric: place in focus [m]" : "T23 thin lens: place in focus [m]",
                  worst, 0, place_bound(reference, 0.25));
            assert_true(spread > 0.0025); /* the aperture was used */
        }
        mcv_scene_free(scene);
    }
}

/* Report 4.2.2: s -> its macro pixel's centre c, w = -w_z/b c, o linear in s - c. */
static void test_light_field_map(void **state) {
    const mcv_sensor sensor = light_field(MCV_APERTURE_SQUARE);
    mcv_scene *scene = scene_with(MCV_SENSOR_LIGHT_FIELD, &sensor);
    const double depth = 0.3, scale = 5;     /* 1/(1/0.05 - 1/0.06) m; w_z/b */
    const double x = 0.125, y = 1 - 0x1p-24; /* the last sample that is still in the pixel */
    (void)state;
    for (uint32_t i = 0; i < CASES; ++i)
        set_case(i, i * 7 % 80, i * 5 % 36, (float)x, (float)y, 0.3F, 0.3F);
    for (int reference = 0; reference < 2; ++reference) {
        double worst_focus = 0, worst_lens = 0;
        look_by(reference, scene);
        for (uint32_t i = 0; i < CASES; ++i) {
            const uint32_t column = cases[6 * i], row = cases[6 * i + 1], m = column / 5,
                           n = row / 3;
            const ref_vec place = at_depth(sights[i], depth);
            /* The upright image: a macro pixel right of the centre looks at the right, one above at
             * what is above. */
            const double focus_x = (m + 0.5 - 8) * 5 * pixel * scale,
                         focus_y = (6 - (n + 0.5)) * 3 * pixel * scale;
            /* The report's o with its sign, s read in the upright image: p mod J grows to the
             * right, p mod K downwards. */
            const double lens_x = ((column % 5 + x) / 5 * 2 - 1) * 0.01,
                         lens_y = -((row % 3 + y) / 3 * 2 - 1) * 0.01;
            worst_focus = worse(worst_focus, hypot(place.x - focus_x, place.y - focus_y));
            worst_lens =
                worse(worst_lens, hypot(sights[i].origin.x - lens_x, sights[i].origin.y - lens_y));
        }
        check("T24 light field: place in focus [m]", worst_focus, 0, place_bound(reference, depth));
        check("T24 light field: place on the lens [m]", worst_lens, 0,
              8 * (reference ? DBL_EPSILON : 0x1p-24) * 0.01);
    }
    mcv_scene_free(scene);

    const mcv_sensor circle = light_field(MCV_APERTURE_CIRCLE);
    scene = scene_with(MCV_SENSOR_LIGHT_FIELD, &circle);
    assert_true(ref_sensor_ray_sample(&scene->sensors[0], 0, 0, 0.5, 0.5, 0, 0).weight ==
                0); /* a corner of the pupil */
    assert_true(ref_sensor_ray_sample(&scene->sensors[0], 2, 1, 0.5, 0.5, 0, 0).weight == 1);
    mcv_scene_free(scene);
}

/* A light at the upper right lights the upper right of every sensor's image, and nothing else. */
static void test_images_are_upright(void **state) {
    mcv_sensor sensors[4] = {sensor_defaults(MCV_SENSOR_PINHOLE), thin_lens(40, 40, 0.03),
                             telecentric(40, 40), light_field(0)};
    (void)state;
    sensors[0].as.pinhole.imageDistance = 0.06;
    for (int k = 0; k < 2; ++k) {
        sensors[0].as.pinhole.resolution[k] = 40;
        sensors[0].as.pinhole.pixelSize[k] = pixel;
        sensors[3].as.light_field.pixelSize[k] = 2 * pixel;
    }
    for (int i = 0; i < 4; ++i) {
        mcv_scene *scene = scene_with(sensors[i].type, &sensors[i]);
        const double depth = i == 1 ? 0.15 : i == 2 ? 0.25 : 0.3;
        add_emitter(
            scene, MCV_EMITTER_AREA,
            add_rectangle(scene, 8e-4, 5e-4, add_absorber(scene), looking_up_z(5e-4, 3e-4, -depth)),
            1, 0);
        const mcv_render_options options = options_of(16, 4);
        mcv_render_stats stats;
        mcv_film film = render_with(scene, &options, true, &stats);
        double inside = 0, outside = 0;
        for (uint32_t row = 0; row < film.height; ++row) {
            for (uint32_t column = 0; column < film.width; ++column) {
                const double light =
                    film_estimate(&film, (size_t)row * film.width + column, 1).mean;
                if (2 * column >= film.width && 2 * row < film.height)
                    inside += light;
                else
                    outside += light;
            }
        }
        print_message("  sensor %d: %g pixels lit at the upper right, %g elsewhere\n", i, inside,
                      outside);
        if (!(inside > 1 && outside == 0)) fail_msg("sensor %d shows its image the wrong way", i);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

static mcv_film film_by(bool reference, const mcv_scene *scene, uint32_t samples) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats = {0};
    mcv_film film = {0};
    checked = reference ? "reference" : "device";
    options.replicates = REPLICATES;
    options.last = samples;
    options.depth = 4;
    BUILD((reference ? mcv_reference_render : mcv_render)(scene, 0, &options, &film, &stats,
                                                          &builder_error));
    return film;
}

/* T22: E = π L D²/(4 b²) cos⁴θ under an even sky, focused at infinity (b = f), where the ray's
 * angle is the pixel's. */
static void test_thin_lens_irradiance(void **state) {
    enum { SIZE = 21, STEPS = 64 };
    mcv_sensor sensor = thin_lens(SIZE, SIZE, 0.025);
    (void)state;
    sensor.as.thin_lens.pixelSize[0] = sensor.as.thin_lens.pixelSize[1] =
        2e-3; /* 40° in the corner */
    sensor.as.thin_lens.radiometry = MCV_RADIOMETRY_IRRADIANCE;
    mcv_scene *scene = scene_with(sensor.type, &sensor);
    add_environment(scene, 2);
    for (int reference = 0; reference < 2; ++reference) {
        mcv_film film = film_by(reference, scene, 256);
        const double axis = M_PI * 2 * 0.006 * 0.006 / (4 * 0.025 * 0.025);
        for (uint32_t k = 0; k <= SIZE / 2; k += 5) {
            /* The mean of cos⁴ over the pixel by the midpoint rule: error below (step/f)²/24 times
             * |cos⁴''| <= 4. */
            double truth = 0;
            for (int i = 0; i < STEPS; ++i) {
                for (int j = 0; j < STEPS; ++j) {
                    const double x = (SIZE / 2.0 - (k + (i + 0.5) / STEPS)) * 2e-3 / 0.025;
                    const double y = (SIZE / 2.0 - (k + (j + 0.5) / STEPS)) * 2e-3 / 0.025;
                    truth += axis / pow(1 + x * x + y * y, 2) / (STEPS * STEPS);
                }
            }
            char what[64];
            snprintf(what, sizeof what, "T22 thin lens irradiance, pixel %u, %u [W/m2]", k, k);
            check_mean(what, film_estimate(&film, (size_t)k * SIZE + k, 1), truth,
                       axis * 2 * 4.0 / 24 * pow(2e-3 / 0.025 / STEPS, 2) +
                           (reference ? 0 : 20 * 0x1p-24 * axis));
        }
        mcv_film_free(&film);
    }
    mcv_scene_free(scene);
}

/* T22: E = L A/h² times the mean of cos⁴ over the stop, 1/(1 + (D_t/2f)²), everywhere in the image.
 */
static void test_telecentric_irradiance(void **state) {
    enum { SIZE = 16 };
    mcv_sensor sensor = telecentric(SIZE, SIZE);
    (void)state;
    sensor.as.telecentric.stopDiameter = 0.03;
    sensor.as.telecentric.lensDiameter = 0.5;
    sensor.as.telecentric.pixelSize[0] = sensor.as.telecentric.pixelSize[1] = 1e-3;
    sensor.as.telecentric.radiometry = MCV_RADIOMETRY_IRRADIANCE;
    mcv_scene *scene = scene_with(sensor.type, &sensor);
    add_environment(scene, 2);
    const mcv_render_options options = options_of(64, 4);
    mcv_render_stats stats;
    mcv_film film = render_with(scene, &options, true, &stats);
    const double truth =
        2 * M_PI * 0.03 * 0.03 / (4 * 0.0125 * 0.0125) / (1 + pow(0.03 / 2 / 0.05, 2));
    check_mean("T22 telecentric irradiance, image [W/m2]", film_estimate(&film, 0, SIZE * SIZE),
               truth, 0);
    check_mean("T22 telecentric irradiance, upper rows", film_estimate(&film, 0, SIZE * (SIZE / 4)),
               truth, 0);
    check_mean("T22 telecentric irradiance, middle rows",
               film_estimate(&film, SIZE * SIZE / 2, SIZE * (SIZE / 4)), truth, 0);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

/* Radiance mode: an even sky is 1 whatever the aperture; light field irradiance on axis is L D²/b².
 */
static void test_other_radiometry(void **state) {
    mcv_render_stats stats;
    (void)state;
    for (int irradiance = 0; irradiance < 2; ++irradiance) {
        mcv_sensor sensor = light_field(MCV_APERTURE_SQUARE);
        sensor.as.light_field.radiometry =
            irradiance ? MCV_RADIOMETRY_IRRADIANCE : MCV_RADIOMETRY_RADIANCE;
        sensor.as.light_field.imageDistance =
            sensor.as.light_field.focalLength; /* infinity: the angle is the macro pixel's */
        mcv_scene *scene = scene_with(sensor.type, &sensor);
        add_environment(scene, 3);
        const mcv_render_options options = options_of(1, 4);
        mcv_film film = render_with(scene, &options, true, &stats);
        const double slope_x = 0.5 * 5 * pixel / 0.05,
                     slope_y = 0.5 * 3 * pixel / 0.05; /* macro pixels beside the centre */
        const double truth = irradiance ? 3 * 0.02 * 0.02 / (0.05 * 0.05) /
                                              pow(1 + slope_x * slope_x + slope_y * slope_y, 2)
                                        : 3;
        check(irradiance ? "light field irradiance [W/m2]" : "light field radiance [W/(m2 sr)]",
              film_estimate(&film, 18 * 80 + 40, 1).mean, truth, 16 * DBL_EPSILON * truth);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

/*
 * Irradiance under an even sky of 1 on the axis of f 50 mm, b 60 mm, D 50 mm (the lens from (0, 0)
 * to R = 25 mm, w = 300 mm): with the object side's angles π R²/b² / (1 + R²/w²) = 0.5417, with the
 * image side's π sin²θ' = π R²/(R² + b²) = 0.4647. The mean of the weights over 32 x 32 cells of
 * the aperture by the midpoint rule: the device fills the disk from the square -1 … 1, in which
 * second derivatives are at most 4 R²/b² of it and the diagonals have a kink as large: below R²/b²
 * (2/32)² in all.
 */
static void test_falloff_on_the_axis(void **state) {
    const double truths[] = {M_PI * 0.025 * 0.025 / (0.06 * 0.06) /
                                 (1 + 0.025 * 0.025 / (0.3 * 0.3)),
                             M_PI * 0.025 * 0.025 / (0.025 * 0.025 + 0.06 * 0.06)};
    (void)state;
    assert_true(fabs(truths[0] - 0.5417) < 5e-5 && fabs(truths[1] - 0.4647) < 5e-5);
    for (int falloff = 0; falloff < 2; ++falloff) {
        mcv_sensor sensor = thin_lens(2, 2, 0.06);
        sensor.as.thin_lens.focalLength = 0.05;
        sensor.as.thin_lens.lensDiameter = 0.05;
        sensor.as.thin_lens.radiometry = MCV_RADIOMETRY_IRRADIANCE;
        sensor.as.thin_lens.falloff = falloff;
        mcv_scene *scene = scene_with(sensor.type, &sensor);
        for (size_t i = 0; i < CASES; ++i)
            set_case(i, 1, 1, 0, 0, (float)((double)(i % 32) + 0.5) / 32,
                     (float)((double)(i / 32) + 0.5) / 32);
        for (int reference = 0; reference < 2; ++reference) {
            double mean = 0;
            look_by(reference, scene);
            for (size_t i = 0; i < CASES; ++i) mean += sights[i].weight / CASES;
            check(falloff ? "irradiance on the axis, image side"
                          : "irradiance on the axis, object side",
                  mean, truths[falloff], truths[falloff] * pow(25.0 / 60, 2) * pow(2.0 / 32, 2));
        }
        mcv_scene_free(scene);
    }
}

/*
 * Off the axis, of every sensor with a lens: the line from the image point s to the place o on the
 * lens leans by θ', cosθ' = b/|(o - s, b)|, and each ray weighs A cos⁴θ'/h².
 */
static void test_falloff_of_every_ray(void **state) {
    mcv_sensor sensors[] = {thin_lens(100, 80, 0.06), telecentric(100, 80),
                            light_field(MCV_APERTURE_SQUARE)};
    (void)state;
    sensors[0].as.thin_lens.lensDiameter = 0.02;
    for (int i = 0; i < 3; ++i) {
        mcv_sensor *sensor = sensors + i;
        int *radiometry =
            mcv_params_find(mcv_sensor_table(sensor->type), "radiometry", &sensor->as);
        int *falloff = mcv_params_find(mcv_sensor_table(sensor->type), "falloff", &sensor->as);
        double *size = mcv_params_find(mcv_sensor_table(sensor->type), "pixelSize", &sensor->as);
        *radiometry = MCV_RADIOMETRY_IRRADIANCE;
        *falloff = MCV_FALLOFF_IMAGE_SIDE;
        size[0] = size[1] = 2e-4; /* up to 10° and more in the corner */
        if (sensor->type == MCV_SENSOR_TELECENTRIC) sensor->as.telecentric.lensDiameter = 1;
        mcv_scene *scene = scene_with(sensor->type, sensor);
        const mcv_sensor *own = scene->sensors; /* resolved */
        const bool whole = sensor->type == MCV_SENSOR_LIGHT_FIELD,
                   stop = sensor->type == MCV_SENSOR_TELECENTRIC;
        const mcv_telecentric_params *t = &own->as.telecentric;
        const double b = stop    ? t->imageDistance
                         : whole ? own->as.light_field.imageDistance
                                 : own->as.thin_lens.imageDistance;
        const double d = stop ? t->stopDiameter : 0.02, h = stop ? b - t->focalLength : b;
        const double etendue = (whole ? 1 : M_PI / 4) * d * d / (h * h);
        const uint32_t width = whole ? 80 : 100, height = whole ? 36 : 80;
        ref_random random = {11};
        for (size_t k = 0; k < CASES; ++k)
            set_case(k, (uint32_t)(width * ref_random_unit(&random)),
                     (uint32_t)(height * ref_random_unit(&random)), 0.5F, 0.5F,
                     (float)(0.999 * ref_random_unit(&random)),
                     (float)(0.999 * ref_random_unit(&random)));
        for (int reference = 0; reference < 2; ++reference) {
            double worst = 0, least = 1;
            look_by(reference, scene);
            for (size_t k = 0; k < CASES; ++k) {
                double column = cases[6 * k] + 0.5, row = cases[6 * k + 1] + 0.5;
                if (whole) column = (floor(column / 5) + 0.5) * 5, row = (floor(row / 3) + 0.5) * 3;
                const double x = sights[k].origin.x - (width / 2.0 - column) * 2e-4,
                             y = sights[k].origin.y - (row - height / 2.0) * 2e-4;
                const double cosine = b / sqrt(x * x + y * y + b * b);
                worst = worse(worst, fabs(sights[k].weight / (etendue * pow(cosine, 4)) - 1));
                least = fmin(least, cosine);
            }
            /* Some 32 roundings of float32, or of double. */
            check("cos^4 on the image's side", worst, 0,
                  reference ? 32 * DBL_EPSILON : 32 * 0x1p-24);
            assert_true(least < 0.98);
        }
        mcv_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_falloff_on_the_axis),
        cmocka_unit_test(test_falloff_of_every_ray),
        cmocka_unit_test(test_telecentric_magnification),
        cmocka_unit_test(test_focus),
        cmocka_unit_test(test_light_field_map),
        cmocka_unit_test(test_images_are_upright),
        cmocka_unit_test(test_thin_lens_irradiance),
        cmocka_unit_test(test_telecentric_irradiance),
        cmocka_unit_test(test_other_radiometry),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
