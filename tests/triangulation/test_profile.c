/* SPDX-License-Identifier: Apache-2.0 */
/* Profiles: heights from drawn lines, their uncertainty by the closed form, straight lines. */
/* ctest: label truth */
#include "scene_builder.h"
#include "truths.h"

#include "triangulation/profile.h"

#include <math.h>
#include <stdlib.h>

enum { WIDTH = 96, HEIGHT = 160 };

/*
 * The laser looks down -z from 0.2 m above the origin, its line along x. The camera looks at the
 * origin from `angle` away from z towards -y, with a film that is tilted (Scheimpflug).
 */
static const double angle = M_PI / 6, distance = 0.25, focal_length = 0.025, pixel = 5e-6,
                    magnification = 1.0 / 9;

static mcv_camera_model model_of(uint32_t type) {
    mcv_scene *scene = mcv_scene_new("head");
    mcv_camera_model model;
    mcv_sensor sensor = sensor_defaults(type);
    if (type == MCV_SENSOR_THIN_LENS) {
        mcv_thin_lens_params *p = &sensor.as.thin_lens;
        p->focalLength = focal_length;
        p->focusDistance = distance;
        p->fNumber = 8;
        p->tilt = atan(magnification / tan(angle));
        p->tiltDirection = M_PI;
        p->resolution[0] = WIDTH, p->resolution[1] = HEIGHT;
        p->pixelSize[0] = p->pixelSize[1] = pixel;
    } else {
        mcv_telecentric_params *p = &sensor.as.telecentric;
        p->magnification = magnification;
        p->workingDistance = distance;
        p->fNumber = 8;
        p->resolution[0] = WIDTH, p->resolution[1] = HEIGHT;
        p->pixelSize[0] = p->pixelSize[1] = pixel;
    }
    const double at[3] = {0, -distance * sin(angle), distance * cos(angle)},
                 forward[3] = {0, sin(angle), -cos(angle)}, up[3] = {0, cos(angle), sin(angle)};
    add_sensor(scene, type, &sensor, looking(at, forward, up));
    BUILD(mcv_camera_model_of(scene, scene->sensors, &model, &builder_error));
    mcv_scene_free(scene);
    return model;
}

/* Draws the line of light on the surface z = height(x), a Gaussian of 1.5 pixels about the image of
 * each point; columns are found by bisection. */
static void draw(const mcv_camera_model *model, double (*height)(double), mcv_image *image) {
    BUILD(mcv_image_new(image, WIDTH, HEIGHT, 1, &builder_error));
    for (uint32_t column = 0; column < WIDTH; ++column) {
        double low = -0.01, high = 0.01, place[2] = {0, 0};
        for (int i = 0; i < 80; ++i) {
            const double x = (low + high) / 2, world[3] = {x, 0, height(x)};
            assert_true(mcv_camera_model_project(model, world, place));
            if (place[0] < column + 0.5)
                low = x;
            else
                high = x;
        }
        for (uint32_t row = 0; row < HEIGHT; ++row) {
            const double from = (row - place[1]) / 1.5 * M_SQRT1_2,
                         to = (row + 1 - place[1]) / 1.5 * M_SQRT1_2;
            image->pixels[row * WIDTH + column] = (float)(1000 * (erf(to) - erf(from)) / 2);
        }
    }
}

static double plane(double x) {
    (void)x;
    return 1e-3;
}

static double slope(double x) { return -5e-4 + 0.2 * x; }

/* Steps of 0.2 mm that are 1 mm wide. */
static double staircase(double x) { return 2e-4 * floor(x / 1e-3); }

static mcv_profile_settings settings_of(const mcv_transform *laser) {
    return (mcv_profile_settings){.line = {.extractor = MCV_LINE_GAUSS, .window = 15},
                                  .threshold_share = 0.05,
                                  .laser = laser,
                                  .frame = laser};
}

/*
 * The resolution is the height that a pixel stands for, p/(m sin θ) = 90 µm here. Heights of drawn
 * lines are within 1e-4 of it, 9 nm: float values leave 1e-6 pixels or so, the rest is geometry.
 * The laser's node lies at z = 0.2 m.
 */
static void test_heights(void **state) {
    (void)state;
    static double (*const shapes[])(double) = {plane, slope, staircase};
    const mcv_transform laser = looking_down_z(0, 0, 0.2);
    const mcv_profile_settings settings = settings_of(&laser);
    const double resolution = pixel / (magnification * sin(angle));
    for (int type = 0; type < 2; ++type)
        for (int shape = 0; shape < 3; ++shape) {
            mcv_camera_model model = model_of(type ? MCV_SENSOR_TELECENTRIC : MCV_SENSOR_THIN_LENS);
            mcv_image image;
            mcv_profile_point points[WIDTH];
            double largest = 0, furthest = 0;
            draw(&model, shapes[shape], &image);
            mcv_profile_find(&settings, &image, NULL, &model, points);
            for (int i = 0; i < WIDTH; ++i) {
                assert_int_equal(points[i].line.state, MCV_LINE_SEEN);
                const double x = points[i].at[0], step = fmod(fabs(x) + 0.5e-3, 1e-3) - 0.5e-3;
                if (shape == 2 && fabs(step) < 5e-6) continue; /* a column that a step leaves out */
                largest = fmax(largest, fabs(points[i].at[2] + 0.2 - shapes[shape](x)));
                furthest = fmax(furthest, fabs(points[i].at[1]));
            }
            print_message("camera %d, shape %d: %.3g of the resolution\n", type, shape,
                          largest / resolution);
            note_truth(shape == 0   ? "T30 heights of a plane [resolution]"
                       : shape == 1 ? "T30 heights of a slope [resolution]"
                                    : "T30 heights of stairs [resolution]",
                       "program", largest / resolution, 1e-4);
            if (!(largest <= 1e-4 * resolution) || !(furthest <= 1e-12))
                fail_msg("camera %d, shape %d: z is off by %g m, y by %g m", type, shape, largest,
                         furthest);
            mcv_image_free(&image);
            mcv_camera_model_free(&model);
        }
}

/* u(z) = u(place) p/(m sin θ) where the camera looks, and to 2 % within the small field. */
static void test_uncertainty(void **state) {
    (void)state;
    const mcv_transform laser = looking_down_z(0, 0, 0.2);
    mcv_profile_settings settings = settings_of(&laser);
    mcv_camera_model model = model_of(MCV_SENSOR_TELECENTRIC);
    const double resolution = pixel / (magnification * sin(angle));
    mcv_image image, deviations;
    mcv_profile_point points[WIDTH];
    draw(&model, slope, &image);
    BUILD(mcv_image_new(&deviations, WIDTH, HEIGHT, 1, &builder_error));
    for (int i = 0; i < WIDTH * HEIGHT; ++i) deviations.pixels[i] = 1;
    mcv_profile_find(&settings, &image, &deviations, &model, points);
    for (int i = 0; i < WIDTH; ++i) {
        assert_true(points[i].line.uncertainty > 0);
        assert_true(fabs(points[i].u_z / (points[i].line.uncertainty * resolution) - 1) <= 1e-6);
    }
    /* Speckle of a line of 1.5 pixels is added: the fit's line is that wide. */
    settings.contrast = 0.7;
    settings.wavelength = 660e-9;
    const double noise = points[0].uncertainty;
    mcv_profile_find(&settings, &image, &deviations, &model, points);
    const double speckle = mcv_line_speckle_noise(0.7, 660e-9 * model.f_number, 1.5 * pixel, pixel,
                                                  (mcv_line_stop){NULL, false}) /
                           pixel;
    assert_true(fabs(points[0].uncertainty / hypot(noise, speckle) - 1) <= 1e-3);
    mcv_image_free(&image);
    mcv_image_free(&deviations);
    mcv_camera_model_free(&model);
}

/* The part's coordinates go back by the feed; a turned frame turns them. */
static void test_frames(void **state) {
    (void)state;
    const mcv_transform laser = looking_down_z(0, 0, 0.2), upright = mcv_transform_identity();
    mcv_camera_model model = model_of(MCV_SENSOR_THIN_LENS);
    mcv_profile_settings settings = settings_of(&laser);
    mcv_image image;
    mcv_profile_point points[WIDTH];
    draw(&model, plane, &image);
    settings.frame = &upright;
    settings.feed = 3e-4;
    mcv_profile_find(&settings, &image, NULL, &model, points);
    for (int i = 0; i < WIDTH; ++i) {
        assert_true(fabs(points[i].at[2] - 1e-3) <= 1e-8);
        assert_true(fabs(points[i].at[1] + 3e-4) <= 1e-12);
    }
    /* 0.01 of a wave along 20 periods of x: the line takes nothing of it off. */
    uint64_t used;
    mcv_profile_point waves[200];
    for (int i = 0; i < 200; ++i)
        waves[i] = (mcv_profile_point){
            .at = {i * 1e-3, 0, 0.5 + 3 * i * 1e-3 + 0.01 * sin(2 * M_PI * (i % 100 + 0.5) / 5)}};
    waves[7].at[2] = NAN;
    const double residual = mcv_profile_residual(waves, 200, 100, &used);
    assert_int_equal(used, 195);
    if (!(fabs(residual / (0.01 / M_SQRT2) - 1) <= 0.02)) fail_msg("residual %g", residual);
    mcv_image_free(&image);
    mcv_camera_model_free(&model);
}

/* A column of the image across the line is a row of its transpose. */
static void test_rows(void **state) {
    (void)state;
    const mcv_profile_settings columns = {.line = {.extractor = MCV_LINE_COG, .window = 15},
                                          .threshold_share = 0.05};
    mcv_profile_settings rows = columns;
    mcv_camera_model model = model_of(MCV_SENSOR_THIN_LENS);
    mcv_image image, turned;
    mcv_profile_point along[WIDTH], down[WIDTH];
    draw(&model, slope, &image);
    BUILD(mcv_image_new(&turned, HEIGHT, WIDTH, 1, &builder_error));
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) turned.pixels[x * HEIGHT + y] = image.pixels[y * WIDTH + x];
    rows.rows = true;
    assert_int_equal(mcv_profile_length(&columns, &image), WIDTH);
    assert_int_equal(mcv_profile_length(&rows, &turned), WIDTH);
    mcv_profile_find(&columns, &image, NULL, NULL, along);
    mcv_profile_find(&rows, &turned, NULL, NULL, down);
    for (int i = 0; i < WIDTH; ++i) assert_true(along[i].line.place == down[i].line.place);
    mcv_image_free(&image);
    mcv_image_free(&turned);
    mcv_camera_model_free(&model);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_heights),
        cmocka_unit_test(test_uncertainty),
        cmocka_unit_test(test_frames),
        cmocka_unit_test(test_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
