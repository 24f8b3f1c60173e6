/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* Laws of optics that the sensors must keep on the device: magnification, blur, fall-off. */
#include "elements.h"
#include "reference_checks.h"

#include "analysis/edge.h"

#include <float.h>

/* The relative error of one float32 operation. */
static const double u = 0x1p-24;

/* The slope of y over x, both free in their origin. */
static double slope_of(const double *x, const double *y, int count) {
    double mean_x = 0, mean_y = 0, product = 0, square = 0;
    for (int i = 0; i < count; ++i) {
        mean_x += x[i] / count;
        mean_y += y[i] / count;
    }
    for (int i = 0; i < count; ++i) {
        product += (x[i] - mean_x) * (y[i] - mean_y);
        square += (x[i] - mean_x) * (x[i] - mean_x);
    }
    return product / square;
}

/*
 * 128 chief rays of a telecentric camera that looks askew meet a wall 20 mm before, in and behind
 * the plane in focus, all by one renderer. The image scale is the slope of image over object. A hit
 * is off by some 8 u of 0.15 m, 7e-8 m; the slope over 30 mm by √(12/128) of it: 7e-7 at the worst.
 * In double 2^-29 of that; 1e-12 are asked for.
 */
static void check_telecentric_magnification(bool reference) {
    enum { RAYS = 128 };
    const double m = 0.25, width = RAYS * 60e-6;
    double magnification[3];
    checked = reference ? "reference" : "device";
    for (int step = -1; step <= 1; ++step) {
        const double forward[3] = {2.0 / 3, -1.0 / 3, -2.0 / 3},
                     up[3] = {1.0 / 3, -2.0 / 3, 2.0 / 3},
                     right[3] = {-2.0 / 3, -2.0 / 3, -1.0 / 3};
        const double depth = 0.11 + 0.02 * step;
        mcv_scene *scene = mcv_scene_new("telecentric");
        mcv_sensor sensor = sensor_defaults(MCV_SENSOR_TELECENTRIC);
        mcv_telecentric_params *p = &sensor.as.telecentric;
        p->magnification = m;
        p->workingDistance = 0.11;
        p->fNumber = 8;
        p->resolution[0] = RAYS;
        p->resolution[1] = 1;
        p->pixelSize[0] = p->pixelSize[1] = width / RAYS;
        add_sensor(scene, MCV_SENSOR_TELECENTRIC, &sensor,
                   looking((const double[3]){0.01, 0.02, -0.01}, forward, up));
        double at[3];
        for (int k = 0; k < 3; ++k)
            at[k] = scene->sensors[0].to_world.m[9 + k] + depth * forward[k];
        add_rectangle(scene, 0.1, 0.1, add_absorber(scene),
                      looking(at, (const double[3]){-forward[0], -forward[1], -forward[2]}, up));

        uint32_t cases[6 * RAYS];
        ref_sensor_ray sights[RAYS];
        mcv_trace_ray rays[RAYS];
        for (uint32_t i = 0; i < RAYS; ++i) {
            cases[6 * i] = i;
            cases[6 * i + 1] = 0;
            for (int k = 2; k < 6; ++k)
                cases[6 * i + k] = as_uint(0.5f); /* the middle of the pixel and of the stop */
        }
        sights_by(reference, &scene->sensors[0], RAYS, cases, sights);
        for (int i = 0; i < RAYS; ++i) {
            const ref_vec o = sights[i].origin, d = sights[i].direction;
            rays[i] = (mcv_trace_ray){{o.x, o.y, o.z}, {d.x, d.y, d.z}};
        }
        mcv_render_options options = mcv_render_defaults();
        mcv_vertex *vertices = NULL;
        size_t count = 0;
        BUILD((reference ? mcv_reference_trace : mcv_trace)(scene, rays, RAYS, &options, &vertices,
                                                            &count, &builder_error));
        assert_int_equal(count, 2 * RAYS);
        double image[RAYS], object[RAYS];
        for (int i = 0; i < RAYS; ++i) {
            const mcv_vertex *hit = vertices + 2 * i + 1;
            assert_true(hit->ray == (uint32_t)i && hit->event == MCV_EVENT_NON_SPECULAR);
            image[i] = (i + 0.5) * width / RAYS;
            object[i] = 0;
            for (int k = 0; k < 3; ++k)
                object[i] += right[k] * (hit->position[k] - scene->sensors[0].to_world.m[9 + k]);
        }
        magnification[step + 1] = 1 / fabs(slope_of(image, object, RAYS));
        free(vertices);
        mcv_scene_free(scene);
    }
    for (int i = 0; i < 3; ++i) {
        char what[64];
        snprintf(what, sizeof what, "T22 telecentric magnification at %+d mm", 20 * (i - 1));
        check(what, magnification[i] / m, 1, reference ? 1e-12 : 1e-6);
    }
    check("T22 its change over 40 mm of depth", magnification[2] / magnification[0], 1,
          reference ? 1e-12 : 1e-6);
}

static void test_telecentric_magnification(void **state) {
    (void)state;
    for (int reference = 0; reference < 2; ++reference) check_telecentric_magnification(reference);
}

/*
 * T24: a 4f system's two halves, each a lens of f with the stop or the sensor in its focal plane. A
 * ray that leaves the object tilted by a passes that plane at f tan a, wherever it comes from; a
 * ray that meets a lens focused at infinity so tilted is seen f tan a beside the axis, wherever it
 * meets the lens. Directions are off by a few u of the sum of both terms, some 0.2: 1e-5 of the
 * 1e-3 pixels.
 */
static void test_4f_system(void **state) {
    enum { SIZE = 128, CASES = 512 };
    const double f = 0.05, pitch = 10e-6, stop = 0.008;
    (void)state;
    for (int reference = 0; reference < 2; ++reference)
        for (int second = 0; second < 2; ++second) {
            mcv_scene *scene = mcv_scene_new("4f");
            mcv_sensor sensor =
                sensor_defaults(second ? MCV_SENSOR_THIN_LENS : MCV_SENSOR_TELECENTRIC);
            uint32_t cases[6 * CASES];
            ref_sensor_ray sights[CASES];
            ref_random random = {5};
            double worst = 0;
            if (second) {
                sensor.as.thin_lens.focalLength = sensor.as.thin_lens.imageDistance = f;
                sensor.as.thin_lens.lensDiameter = 0.02;
            } else {
                sensor.as.telecentric.focalLength = f;
                sensor.as.telecentric.imageDistance = 0.0625;
                sensor.as.telecentric.stopDiameter = stop;
                sensor.as.telecentric.lensDiameter = 0.05;
            }
            for (int k = 0; k < 2; ++k) {
                *(second ? sensor.as.thin_lens.resolution + k
                         : sensor.as.telecentric.resolution + k) = SIZE;
                *(second ? sensor.as.thin_lens.pixelSize + k
                         : sensor.as.telecentric.pixelSize + k) = pitch;
            }
            add_sensor(scene, sensor.type, &sensor, looking_down_z(0, 0, 0));
            for (int i = 0; i < CASES; ++i) {
                uint32_t *in = cases + 6 * i;
                for (int k = 0; k < 2; ++k) in[k] = (uint32_t)(SIZE * ref_random_unit(&random));
                in[2] = in[3] = as_uint(0.5f);
                /* The second lens is met anywhere; of the stop before it, the middle or the ends of
                 * one axis. */
                for (int k = 4; k < 6; ++k)
                    in[k] = as_uint(second ? (float)(0.999 * ref_random_unit(&random)) : 0.5f);
                if (!second) in[4 + i % 2] = as_uint(0.5f * (float)(i % 3));
            }
            sights_by(reference, &scene->sensors[0], CASES, cases, sights);
            for (int i = 0; i < CASES; ++i) {
                const uint32_t *in = cases + 6 * i;
                const double tilt[2] = {-sights[i].direction.x / sights[i].direction.z,
                                        -sights[i].direction.y / sights[i].direction.z};
                for (int k = 0; k < 2; ++k) {
                    const double pixels = in[k] + 0.5 - SIZE / 2,
                                 place = (2 * (double)as_float(in[4 + k]) - 1) * stop / 2 / pitch;
                    const double shift = f * tilt[k] / pitch;
                    /* The image is upright in the node's frame: rows count downwards. A ray through
                     * the stop's right comes from the left.
                     */
                    worst = worse(worst, fabs(shift - (second ? (k ? -pixels : pixels) : -place)));
                }
            }
            checked = reference ? "reference" : "device";
            check(second ? "T24 4f system, second lens: tilt to f tan a at any place [pixels]"
                         : "T24 4f system, first lens: tilt to f tan a from any place [pixels]",
                  worst, 0, reference ? 1e-9 : 1e-3);
            mcv_scene_free(scene);
        }
}

/* A thin lens of 250 x 250 pixels of 10 µm, f = 25 mm at f/2, in focus at s1 = 0.4 m. */
static const double focal_length = 0.025, in_focus = 0.4, diameter = 0.0125, pixel = 10e-6;

static mcv_sensor thin_lens(uint32_t width, uint32_t height) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_THIN_LENS);
    mcv_thin_lens_params *p = &sensor.as.thin_lens;
    p->focalLength = focal_length;
    p->focusDistance = in_focus;
    p->lensDiameter = diameter;
    p->resolution[0] = width;
    p->resolution[1] = height;
    p->pixelSize[0] = p->pixelSize[1] = pixel;
    return sensor;
}

/* Diameter of the image of a point at depth s2, in pixels. */
static double blur(double s2) {
    return diameter * focal_length * fabs(s2 - in_focus) / (s2 * (in_focus - focal_length)) / pixel;
}

/*
 * A point is imaged where the rays through it meet the film: through the left and the right rim of
 * the lens at two places, the blur's diameter apart. Rays through a rim pass the depth s2 at places
 * that are linear in the column, so two columns tell which meets the point. Places are off by 8 u
 * of 0.1 m, columns by that over the 0.05 mm that a pixel sees: 1e-3 pixels bear it five times. In
 * double, 2^-29 of that: 1e-10 are ample.
 */
static void test_blur_by_rays(void **state) {
    enum { SIZE = 250 };
    static const double depths[] = {0.2, 0.3, 0.39, 0.4, 0.41, 0.6, 2};
    static const float rims[] = {0, 1}; /* ξ, with η = 1/2: the two ends of the x axis */
    mcv_scene *scene = mcv_scene_new("thin lens");
    const mcv_sensor sensor = thin_lens(SIZE, SIZE);
    uint32_t cases[6 * 64] = {0};
    ref_sensor_ray sights[64];
    (void)state;
    add_sensor(scene, MCV_SENSOR_THIN_LENS, &sensor, looking_down_z(0, 0, 0));
    for (uint32_t i = 0; i < 4; ++i) {
        cases[6 * i] = i % 2 ? SIZE - 1 : 0;
        cases[6 * i + 1] = 40;
        cases[6 * i + 4] = as_uint(rims[i / 2]);
        cases[6 * i + 5] = as_uint(0.5f);
    }
    assert_true(blur(0.2) > 80 && blur(0.4) == 0);
    for (int reference = 0; reference < 2; ++reference) {
        double worst = 0;
        sights_by(reference, &scene->sensors[0], 64, cases, sights);
        for (size_t d = 0; d < sizeof depths / sizeof depths[0]; ++d) {
            for (int step = -2; step <= 2; ++step) {
                const double point = step * 0.002;
                double column[2];
                for (int rim = 0; rim < 2; ++rim) {
                    double place[2];
                    for (int end = 0; end < 2; ++end) {
                        const ref_sensor_ray sight = sights[2 * rim + end];
                        place[end] =
                            sight.origin.x - depths[d] * sight.direction.x / sight.direction.z;
                    }
                    column[rim] = (point - place[0]) / (place[1] - place[0]) * (SIZE - 1);
                }
                worst = worse(worst, fabs(fabs(column[1] - column[0]) - blur(depths[d])));
            }
        }
        checked = reference ? "reference" : "device";
        check("T23 thin lens: blur diameter by rays [pixels]", worst, 0, reference ? 1e-10 : 1e-3);
    }
    mcv_scene_free(scene);
}

static mcv_film film_by(bool reference, const mcv_scene *scene, uint32_t samples) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    checked = reference ? "reference" : "device";
    options.replicates = REPLICATES;
    options.last = samples;
    if (reference)
        BUILD(mcv_reference_render(scene, 0, &options, &film, &stats, &builder_error));
    else
        BUILD(render_again(scene, 0, &options, &film, &stats, &builder_error));
    return film;
}

/*
 * The edge of a panel at depth s2: its image rises as the integral of a disk of the blur's diameter
 * D, of variance D²/16. Differences of neighbouring pixels have that and 1/6 more (a triangle of
 * two pixels; its ripple is below 10^-3 here), whence D of each replicate.
 */
static void test_blur_of_an_edge(void **state) {
    enum { COLUMNS = 96, ROWS = 32 };
    static const double depths[] = {0.34, 0.5};
    (void)state;
    for (int n = 0; n < 4; ++n) {
        const int i = n / 2;
        mcv_scene *scene = mcv_scene_new("edge");
        const mcv_sensor sensor = thin_lens(COLUMNS, ROWS);
        add_sensor(scene, MCV_SENSOR_THIN_LENS, &sensor, looking_down_z(0, 0, 0));
        /* It begins 0.3 pixels right of the axis and is wider than what is seen. */
        const double begins = 0.3 * pixel * depths[i] * (1 / focal_length - 1 / in_focus);
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 0.2, 0.2, add_absorber(scene),
                                  looking_up_z(0.1 + begins, 0, -depths[i])),
                    1, 0);
        mcv_film film = film_by(n % 2, scene, n % 2 ? 256 : 64);
        double widths[REPLICATES];
        for (uint32_t r = 0; r < REPLICATES; ++r) {
            double before = 0, total = 0, mean = 0, square = 0;
            for (int column = 0; column <= COLUMNS; ++column) {
                double here =
                    1; /* beyond the last column all is bright, before the first all is dark */
                if (column < COLUMNS) here = 0;
                for (int row = 0; row < ROWS && column < COLUMNS; ++row)
                    here += film.sums[((size_t)r * ROWS + row) * COLUMNS + column] /
                            ((double)film.samples * ROWS);
                total += here - before;
                mean += column * (here - before);
                square += (double)column * column * (here - before);
                before = here;
            }
            check("the edge rises from 0 to 1", total, 1, 1e-12);
            widths[r] = 4 * sqrt(square - mean * mean - 1.0 / 6);
        }
        const mcv_estimate estimate = mcv_estimate_replicates(widths, REPLICATES);
        print_message("  blur of an edge at %g m: %.4f pixels, standard error %.2g, formula %.4f\n",
                      depths[i], estimate.mean, sqrt(estimate.variance), blur(depths[i]));
        assert_true(sqrt(estimate.variance) < 0.02);
        check("T23 thin lens: blur diameter of a rendered edge [pixels]", estimate.mean,
              blur(depths[i]), 0.1);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

static double sinc(double x) { return x == 0 ? 1 : sin(M_PI * x) / (M_PI * x); }

/*
 * T25: the slanted edge of a panel, rendered in focus and out of it: the modulation up to Nyquist
 * is that of a box pixel times that of the blur's disc. What the paths' noise adds is within the
 * asked 0.01 by far: an edge of 80 rows of 1024 paths a pixel.
 */
static void test_mtf_of_a_rendered_edge(void **state) {
    enum { COLUMNS = 120, ROWS = 80 };
    static const double depths[] = {0.4, 0.381};
    const double tilt = 5 * M_PI / 180;
    (void)state;
    for (int n = 0; n < 4; ++n) {
        const double depth = depths[n / 2], disc = blur(depth),
                     begins = 0.3 * pixel * depth * (1 / focal_length - 1 / in_focus);
        mcv_scene *scene = mcv_scene_new("slanted edge");
        const mcv_sensor sensor = thin_lens(COLUMNS, ROWS);
        add_sensor(scene, MCV_SENSOR_THIN_LENS, &sensor, looking_down_z(0, 0, 0));
        const double at[3] = {begins + 0.1 * cos(tilt), -0.1 * sin(tilt), -depth},
                     up[3] = {sin(tilt), cos(tilt), 0};
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 0.2, 0.2, add_absorber(scene),
                                  looking(at, (const double[3]){0, 0, 1}, up)),
                    1, 0);
        mcv_film film = film_by(n % 2, scene, 64);
        mcv_readings readings = {0};
        BUILD(mcv_film_develop(&film, &readings.values, &readings.deviation, &builder_error));
        mcv_edge edge;
        mcv_edge_mtf mtf;
        BUILD(mcv_edge_parse("0,0,120,80", 1, &readings.values, &edge, &builder_error));
        BUILD(mcv_edge_find(&readings, &edge, &builder_error));
        BUILD(mcv_edge_spread(&readings, &edge, &mtf, &builder_error));
        double worst = 0;
        for (int k = 0; k <= MCV_MTF_COUNT / 2; ++k) {
            const double f = mtf.frequency[k], x = M_PI * disc * f;
            const double truth =
                fabs(sinc(f * cos(tilt)) * sinc(f * sin(tilt)) * (x < 1e-6 ? 1 : 2 * j1(x) / x));
            worst = worse(worst, fabs(mtf.modulation[k].value - truth));
        }
        check("the edge's tilt [rad]", fabs(edge.tilt.value), tilt, 2e-4);
        check(disc == 0 ? "T25 MTF of a rendered edge in focus"
                        : "T25 MTF of a rendered edge blurred by 4 pixels",
              worst, 0, 0.01);
        mcv_edge_mtf_free(&mtf);
        mcv_image_free(&readings.values);
        mcv_image_free(&readings.deviation);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

/* E = π L D²/(4 b²) cos⁴θ of a lens so small (D = b/1000) that θ is the pixel's angle, up to 45° in
 * the corner. */
static void test_cosine_fourth(void **state) {
    enum { SIZE = 64, STEPS = 32 };
    const double b = 0.025 / 0.9, radiance = 2, width = 2 * b * tan(M_PI / 4) / M_SQRT2 / SIZE;
    mcv_scene *scene = mcv_scene_new("cosine");
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_THIN_LENS);
    mcv_thin_lens_params *p = &sensor.as.thin_lens;
    (void)state;
    p->focalLength = 0.025; /* in focus at 10 f */
    p->imageDistance = b;
    p->lensDiameter = b / 1000;
    p->resolution[0] = p->resolution[1] = SIZE;
    p->pixelSize[0] = p->pixelSize[1] = width;
    p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
    add_sensor(scene, MCV_SENSOR_THIN_LENS, &sensor, looking_down_z(0, 0, 0));
    add_environment(scene, radiance);
    const double axis = M_PI * radiance * 1e-6 / 4;
    for (int reference = 0; reference < 2; ++reference) {
        mcv_film film = film_by(reference, scene, 64);
        for (uint32_t k = 0; k < SIZE / 2; k += 6) {
            double truth = 0;
            for (int i = 0; i < STEPS * STEPS; ++i) {
                const int across = i % STEPS, down = i / STEPS;
                const double x = (SIZE / 2.0 - (k + (across + 0.5) / STEPS)) * width / b;
                const double y = (SIZE / 2.0 - (k + (down + 0.5) / STEPS)) * width / b;
                truth += axis / pow(1 + x * x + y * y, 2) / (STEPS * STEPS);
            }
            char what[64];
            snprintf(what, sizeof what, "T22 cos4 of the thin lens, pixel %u, %u [W/m2]", k, k);
            /* Midpoint rule: (step/b)²/24 times |cos⁴''| <= 4 in x and y; κ D/2 = 5e-5: its square
             * times as much; 20 u of rounding. */
            const double slack =
                axis * (2 * 4.0 / 24 * pow(width / b / STEPS, 2) + 8 * 2.5e-9 + 20 * u);
            check_mean(what, film_estimate(&film, (size_t)k * SIZE + k, 1), truth, slack);
            assert_true(reference ||
                        fabs(film_estimate(&film, (size_t)k * SIZE + k, 1).mean / truth - 1) <
                            1e-3);
        }
        mcv_film_free(&film);
    }
    mcv_scene_free(scene);
}

/*
 * E = L A/h² times the mean of cos⁴ over the stop, 1/(1 + (D_t/2f)²), in every pixel: Student's t
 * with 15 degrees of freedom exceeds 7 once in 2 x 10^5, 1024 pixels are tested with a fixed seed.
 * Rows apart agree too.
 */
static void test_telecentric_irradiance(void **state) {
    enum { SIZE = 32 };
    const double radiance = 2;
    mcv_scene *scene = mcv_scene_new("telecentric");
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_TELECENTRIC);
    mcv_telecentric_params *p = &sensor.as.telecentric;
    (void)state;
    p->focalLength = 0.05;
    p->imageDistance = 0.0625;
    p->stopDiameter = 0.01;
    p->lensDiameter = 0.5; /* nothing is vignetted */
    p->resolution[0] = p->resolution[1] = SIZE;
    p->pixelSize[0] = p->pixelSize[1] = 1e-3;
    p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
    add_sensor(scene, MCV_SENSOR_TELECENTRIC, &sensor, looking_down_z(0, 0, 0));
    add_environment(scene, radiance);
    const double truth =
                     radiance * M_PI / 4 * pow(0.01 / 0.0125, 2) / (1 + pow(0.01 / 2 / 0.05, 2)),
                 rounding = 20 * u * truth;
    for (int reference = 0; reference < 2; ++reference) {
        mcv_film film = film_by(reference, scene, 256);
        double worst = 0, deviation = 0;
        for (size_t i = 0; i < SIZE * SIZE; ++i) {
            const mcv_estimate estimate = film_estimate(&film, i, 1);
            worst = worse(worst, fmax(fabs(estimate.mean - truth) - rounding, 0) /
                                     sqrt(estimate.variance));
            deviation = worse(deviation, fabs(estimate.mean / truth - 1));
        }
        print_message(
            "  telecentric irradiance: pixels within %.2g of %.6g W/m2, %.2f standard errors\n",
            deviation, truth, worst);
        assert_true(worst <= 7);
        assert_true(reference || deviation < 1e-4); /* constant, not only noisy */
        check_mean("T22 telecentric irradiance, image [W/m2]", film_estimate(&film, 0, SIZE * SIZE),
                   truth, rounding);
        check_mean("T22 telecentric irradiance, upper rows",
                   film_estimate(&film, 0, SIZE * (SIZE / 4)), truth, rounding);
        check_mean("T22 telecentric irradiance, middle rows",
                   film_estimate(&film, SIZE * SIZE / 2, SIZE * (SIZE / 4)), truth, rounding);
        mcv_film_free(&film);
    }
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_telecentric_magnification),
        cmocka_unit_test(test_4f_system),
        cmocka_unit_test(test_blur_by_rays),
        cmocka_unit_test(test_blur_of_an_edge),
        cmocka_unit_test(test_cosine_fourth),
        cmocka_unit_test(test_mtf_of_a_rendered_edge),
        cmocka_unit_test(test_telecentric_irradiance),
    };
    return cmocka_run_group_tests(tests, open_device, close_device);
}
