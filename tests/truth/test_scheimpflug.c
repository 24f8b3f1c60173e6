/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/*
 * A tilted film in rendered pictures: an array of knife edges at known depths is sharp where the
 * plane in focus meets them, and a tilted pixel on the axis gets the cosine of the tilt.
 */
#include "scene_builder.h"
#include "truths.h"

#include "render/render.h"
#include "scene/lens_map.h"
#include "scene/sensors.h"

enum { EDGES = 7, CELL = 40, WIDTH = EDGES * CELL, HEIGHT = 120, WINDOW = 9 };
static const double focal_length = 0.016, focus = 0.2, tilt = 10 * M_PI / 180, pixel = 20e-6;

static mcv_sensor tilted_camera(void) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_THIN_LENS);
    mcv_thin_lens_params *p = &sensor.as.thin_lens;
    p->focalLength = focal_length;
    p->focusDistance = focus;
    p->lensDiameter = 0.008;
    p->resolution[0] = WIDTH;
    p->resolution[1] = HEIGHT;
    p->pixelSize[0] = p->pixelSize[1] = pixel;
    p->tilt = tilt;
    return sensor;
}

static mcv_image render_image(const mcv_scene *scene, uint32_t samples) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    mcv_image image;
    options.replicates = 2;
    options.last = samples;
    options.depth = 1;
    options.seed = 1;
    BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    BUILD(mcv_film_develop(&film, &image, NULL, &builder_error));
    mcv_film_free(&film);
    return image;
}

/* The variance of an edge's line spread about a column, in pixels squared. */
static double spread_of_edge(const float *row, int edge) {
    double sum = 0, first = 0, second = 0;
    for (int i = -WINDOW; i < WINDOW; ++i) {
        const double weight = (double)row[edge + i] - row[edge + i - 1];
        sum += weight, first += weight * i, second += weight * i * i;
    }
    return second / sum - pow(first / sum, 2);
}

/* The vertex of a parabola a + b x + c x² through values at x = 0 … HEIGHT - 1, by least squares.
 */
static double vertex_of(const double values[HEIGHT]) {
    double m[3][4] = {{0}};
    for (int x = 0; x < HEIGHT; ++x) {
        const double t = x - HEIGHT / 2.0, power[3] = {1, t, t * t};
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) m[i][j] += power[i] * power[j];
            m[i][3] += power[i] * values[x];
        }
    }
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const double factor = m[j][i] / m[i][i];
            for (int k = 0; j != i && k < 4; ++k) m[j][k] -= factor * m[i][k];
        }
    return HEIGHT / 2.0 - m[1][3] / m[1][1] / (2 * m[2][3] / m[2][2]);
}

/*
 * A point at the depth z is imaged at b' = f z/(z - f); on a film at b e its blur has the width D
 * |1 - b e/b'|, so the variance of an edge is a parabola in e, and e one in the row: its vertex
 * lies at e = b'/b, the row where the plane in focus has the depth z. The noise of the picture, two
 * edges and 120 rows, leaves 0.4 rows (three of the standard deviations of 0.14 among the edges),
 * and the plane crosses 0.5 mm of depth per row.
 */
static void test_knife_edges(void **state) {
    mcv_scene *scene = mcv_scene_new("edges");
    const mcv_sensor camera = tilted_camera();
    double depths[EDGES], worst = 0;
    (void)state;
    add_environment(scene, 1);
    add_sensor(scene, MCV_SENSOR_THIN_LENS, &camera, looking_down_z(0, 0, 0));
    const double b = scene->sensors[0].as.thin_lens.imageDistance, m = b / focus;
    const uint32_t black = add_absorber(scene);
    for (int j = 0; j < EDGES; ++j) {
        depths[j] = 0.187 + 0.0045 * j;
        const double scale = depths[j] * pixel / b;
        add_rectangle(scene, CELL / 2.0 * scale, 0.1, black,
                      looking_up_z((j - EDGES / 2) * CELL * scale, 0, -depths[j]));
    }
    const mcv_image image = render_image(scene, 512);
    for (int j = 0; j < EDGES; ++j) {
        double spread[HEIGHT];
        for (int row = 0; row < HEIGHT; ++row) {
            const float *line = image.pixels + (size_t)WIDTH * row;
            spread[row] = (spread_of_edge(line, CELL * j + CELL / 4) +
                           spread_of_edge(line, CELL * j + 3 * CELL / 4)) /
                          2;
        }
        /* The plane w = w0 - y tanτ/m, y = w s_y downwards, and the row from s_y. */
        const double y = (focus - depths[j]) * m / tan(tilt), s = y / depths[j],
                     film = s * b / (cos(tilt) - s * sin(tilt)),
                     truth = HEIGHT / 2.0 + film / pixel, found = vertex_of(spread) + 0.5;
        print_message("  edge at %.1f mm: sharp in row %.2f, the plane is there in %.2f\n",
                      1e3 * depths[j], found, truth);
        if (!(fabs(found - truth) < 0.4)) fail_msg("sharp in row %.2f, not in %.2f", found, truth);
        worst = fmax(worst, fabs(found - truth));
    }
    note_truth("Scheimpflug: knife edges on the plane in focus [rows]", "device", worst, 0.4);
    mcv_image_free((mcv_image *)&image);
    mcv_scene_free(scene);
}

/* The irradiance of a pixel on the axis from a lens that is equally bright: π L sin²θ cosτ, because
 * the whole lens lies before the film. The picture is one pixel of 10⁻⁴ of the film's distance. */
static void test_cosine_of_tilt(void **state) {
    (void)state;
    mcv_scene *scene = mcv_scene_new("bright");
    mcv_sensor camera = tilted_camera();
    mcv_thin_lens_params *p = &camera.as.thin_lens;
    p->resolution[0] = p->resolution[1] = 1;
    p->pixelSize[0] = p->pixelSize[1] = 1e-6;
    p->tilt = 0.6;
    p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
    p->falloff = MCV_FALLOFF_IMAGE_SIDE;
    add_environment(scene, 1);
    add_rectangle(scene, 0.1, 0.1, add_absorber(scene), looking_up_z(0, 0, 0.3)); /* behind it */
    add_sensor(scene, MCV_SENSOR_THIN_LENS, &camera, looking_down_z(0, 0, 0));
    const double b = scene->sensors[0].as.thin_lens.imageDistance, r = 0.004,
                 truth = M_PI * r * r / (r * r + b * b) * cos(0.6);
    const mcv_image image = render_image(scene, 1 << 14);
    const double found = image.pixels[0];
    print_message("  irradiance %.7g, must be %.7g\n", found, truth);
    /* Weights differ by 1 ± 0.3 over the lens; 2^15 Sobol points leave less than 1e-4 of that. */
    note_truth("Scheimpflug: irradiance on the axis", "device", fabs(found / truth - 1), 1e-4);
    assert_true(fabs(found / truth - 1) < 1e-4);
    mcv_image_free((mcv_image *)&image);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_knife_edges),
                                       cmocka_unit_test(test_cosine_of_tilt)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
