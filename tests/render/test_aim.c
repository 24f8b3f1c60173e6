/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sensors that look into a parallel emitter, with pupils from a thousandth to a thousand times as
 * wide as its cone: closed forms, conservation, and images found by chance alone.
 */
#include "estimates.h"

#include "render/render.h"
#include "uneven_panel.h"

enum { SAMPLES = 64, PIXELS = 16 };
static const double alpha = 0.02; /* half-angle of the pupil */

static mcv_film render(const mcv_scene *scene, uint32_t schedule, uint64_t samples,
                       mcv_render_stats *stats) {
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    options.replicates = REPLICATES;
    options.last = samples;
    options.schedule = schedule;
    BUILD(render_again(scene, 0, &options, &film, stats, &builder_error));
    return film;
}

/* Whether the image was made with aimed pupils must be as said. */
static mcv_estimate render_mean(const mcv_scene *scene, uint64_t samples, bool aims) {
    mcv_render_stats stats;
    mcv_film film = render(scene, MCV_SCHEDULE_AUTO, samples, &stats);
    const mcv_estimate mean = image_estimate(&film);
    if ((strstr(stats.features, "pupil-guiding") != NULL) != aims)
        fail_msg("features: %s", stats.features);
    mcv_film_free(&film);
    return mean;
}

/* Roundings to float32 move the edge of a cone of 2e-5 rad, whose angles are known to some 2^-23,
 * by 1 % of it. */
static void expect(const char *what, mcv_estimate m, double expected, double rounding) {
    expect_estimate(what, m, expected, 0.03, rounding);
}

/* A field of 1 mm, magnification 1; pupil half-angle alpha: tan alpha = D_t/2f. */
static void add_camera(mcv_scene *scene, double pupil, uint32_t radiometry,
                       mcv_transform to_world) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_TELECENTRIC);
    mcv_telecentric_params *p = &sensor.as.telecentric;
    p->focalLength = 0.05;
    p->imageDistance = 0.1;
    p->stopDiameter = 2 * 0.05 * tan(pupil);
    p->lensDiameter = 0.05;
    p->resolution[0] = p->resolution[1] = PIXELS;
    p->pixelSize[0] = p->pixelSize[1] = 1e-3 / PIXELS;
    p->radiometry = radiometry;
    add_sensor(scene, MCV_SENSOR_TELECENTRIC, &sensor, to_world);
}

/* The camera looks down from 0.2 m; the panel looks up at it, turned by `tilt`. */
static mcv_scene *direct_scene(double ratio, double tilt, uint32_t radiometry) {
    mcv_scene *scene = mcv_scene_new("backlight");
    const uint32_t panel =
        add_panel(scene, 0.1, 0.1, true,
                  looking((const double[]){0, 0, 0}, (const double[]){sin(tilt), 0, cos(tilt)},
                          (const double[]){0, 1, 0}));
    add_emitter(scene, MCV_EMITTER_PARALLEL, panel, 3, alpha / ratio);
    add_camera(scene, alpha, radiometry, looking_down_z(0, 0, 0.2));
    return scene;
}

static const double ratios[] = {1e-1, 0.5, 2, 10, 100, 1000};
enum { RATIOS = sizeof ratios / sizeof ratios[0] };

/* The directions (a/f, 1) of a pixel fill the circle tan α; of these the cone holds (tan β/tan α)².
 */
static void test_direct(void **state) {
    (void)state;
    for (size_t i = 0; i < RATIOS; ++i) {
        const double share = fmin(1, pow(tan(alpha / ratios[i]) / tan(alpha), 2));
        char what[64];
        snprintf(what, sizeof what, "pupil/cone %g", ratios[i]);
        mcv_scene *scene = direct_scene(ratios[i], 0, 0);
        expect(what, render_mean(scene, SAMPLES, ratios[i] > 1), 3 * share,
               1e-4 * fmax(1, ratios[i] / 10));
        mcv_scene_free(scene);
    }
}

/* A tilted panel: the cone of half-angle β, seen at the angle t from the axis, cuts the plane z = 1
 * in an ellipse of axes ratio cos t... */
static void test_tilted(void **state) {
    (void)state;
    for (size_t i = 2; i < RATIOS; ++i) {
        const double beta = alpha / ratios[i], tilt = 0.4 * alpha;
        /* Semi-axes of the section of a cone (Dandelin): (tan(t + β) - tan(t - β))/2 along, and
         * across by the centre's distance. */
        const double along = (tan(tilt + beta) - tan(tilt - beta)) / 2;
        const double centre = (tan(tilt + beta) + tan(tilt - beta)) / 2;
        /* The cone's surface above the centre: cos β |v| = v·axis, v = (centre, y, 1). */
        const double dot = centre * sin(tilt) + cos(tilt);
        const double across = sqrt(dot * dot / (cos(beta) * cos(beta)) - centre * centre - 1);
        const double share = along * across / pow(tan(alpha), 2);
        char what[64];
        snprintf(what, sizeof what, "tilted, pupil/cone %g", ratios[i]);
        mcv_scene *scene = direct_scene(ratios[i], tilt, 0);
        /* Within the pupil: 0.4 α + β < α. */
        expect(what, render_mean(scene, SAMPLES, true), 3 * share, 1e-3 * fmax(1, ratios[i] / 10));
        mcv_scene_free(scene);
    }
}

/* Irradiance of the light within the cone: L π sin²β on the object's side, over m² = 1 in the
 * image. */
static void test_irradiance(void **state) {
    (void)state;
    for (size_t i = 2; i < RATIOS; ++i) {
        char what[64];
        snprintf(what, sizeof what, "irradiance, pupil/cone %g", ratios[i]);
        mcv_scene *scene = direct_scene(ratios[i], 0, MCV_RADIOMETRY_IRRADIANCE);
        expect(what, render_mean(scene, SAMPLES, true), 3 * M_PI * pow(sin(alpha / ratios[i]), 2),
               1e-4 * fmax(1, ratios[i] / 10));
        mcv_scene_free(scene);
    }
}

/* A light field camera with a field of 1 mm; its 3 x 3 squares of the lens have half the width tan
 * alpha, seen from the plane in focus. */
static void add_light_field_camera(mcv_scene *scene, mcv_transform to_world) {
    mcv_sensor sensor = sensor_defaults(MCV_SENSOR_LIGHT_FIELD);
    mcv_light_field_params *p = &sensor.as.light_field;
    p->focalLength = 0.05;
    p->imageDistance = 0.1;
    p->lensDiameter = 3 * 2 * 0.1 * tan(alpha);
    for (int k = 0; k < 2; ++k) {
        p->angularResolution[k] = 3;
        p->spatialResolution[k] = 4;
        p->pixelSize[k] = 1e-3 / (3 * 4);
    }
    add_sensor(scene, MCV_SENSOR_LIGHT_FIELD, &sensor, to_world);
}

/* Seen from each of its places in focus the lens fills the square of 3 tan α about a chief ray; of
 * these directions it is the cone's share.
 */
static void test_light_field_camera(void **state) {
    (void)state;
    for (size_t i = 2; i < RATIOS; ++i) {
        const double beta = alpha / ratios[i];
        char what[64];
        snprintf(what, sizeof what, "light field, pupil/cone %g", ratios[i]);
        mcv_scene *scene = mcv_scene_new("backlight");
        add_emitter(scene, MCV_EMITTER_PARALLEL,
                    add_panel(scene, 0.1, 0.1, true, looking_up_z(0, 0, 0)), 3, beta);
        add_light_field_camera(scene, looking_down_z(0, 0, 0.2));
        expect(what, render_mean(scene, SAMPLES, true),
               3 * M_PI * pow(tan(beta) / (6 * tan(alpha)), 2), 1e-4 * fmax(1, ratios[i] / 10));
        mcv_scene_free(scene);
    }
}

/* A ball lens between the panel and the plane in focus. */
static mcv_scene *ball_scene(double pupil, double beta, bool even) {
    mcv_scene *scene = mcv_scene_new("ball");
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_panel(scene, 0.04, 0.04, even, looking_up_z(0, 0, -0.03)), 3, beta);
    add_sphere(scene, 0.01, 100, add_glass(scene, 1.5, 0, 0), looking_down_z(0, 0, 0));
    add_camera(scene, pupil, 0, looking_down_z(0, 0, 0.11));
    return scene;
}

/*
 * The camera focuses on the ball's vertex; what leaves the pixel at height y with slope a meets the
 * panel at the angle a - y/F or so: all angles within the field. The light that all pixels see
 * together is the panel's, its cone's solid angle times the area in which the pupil's light meets
 * it: proportional to sin²β to first order, and the same with and without aiming.
 */
static void test_through_a_lens(void **state) {
    (void)state;
    mcv_scene *by_chance = ball_scene(alpha, alpha / 10, false);
    const mcv_estimate truth = render_mean(by_chance, 1024, false);
    const double share = truth.mean / pow(sin(alpha / 10), 2);
    mcv_scene_free(by_chance);
    print_message("by chance: %g ± %.2g\n", truth.mean, sqrt(truth.variance));
    for (size_t i = 3; i < RATIOS; ++i) {
        char what[64];
        snprintf(what, sizeof what, "through a ball, pupil/cone %g", ratios[i]);
        mcv_scene *scene = ball_scene(alpha, alpha / ratios[i], true);
        mcv_estimate m = render_mean(scene, SAMPLES, true);
        m.variance += truth.variance / pow(ratios[i] / 10, 4);
        /* Aberrations: β² relative; those of the pupil are in both. */
        expect(what, m, share * pow(sin(alpha / ratios[i]), 2), 1e-3 * fmax(1, ratios[i] / 10));
        mcv_scene_free(scene);
    }
}

/* Narrow pupils before wide cones need no aim. */
static void test_wide_cones(void **state) {
    static const double wide[] = {2, 10, 100, 1000};
    (void)state;
    for (size_t i = 0; i < sizeof wide / sizeof wide[0]; ++i) {
        mcv_render_stats stats;
        mcv_scene *scene = ball_scene(2e-4, 2e-4 * wide[i], true);
        mcv_film film = render(scene, MCV_SCHEDULE_AUTO, SAMPLES, &stats);
        print_message("through a ball, pupil/cone 1/%g: %g\n", wide[i], image_estimate(&film).mean);
        assert_true(image_estimate(&film).mean > 0);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

/* No bit depends on the schedule. */
static void test_schedules(void **state) {
    (void)state;
    mcv_scene *scene = ball_scene(alpha, alpha / 100, true);
    mcv_render_stats stats;
    mcv_film tile = render(scene, MCV_SCHEDULE_TILE, 16, &stats);
    mcv_film stream = render(scene, MCV_SCHEDULE_STREAM, 16, &stats);
    assert_memory_equal(tile.sums, stream.sums, sizeof(double) * PIXELS * PIXELS * REPLICATES);
    assert_true(mcv_film_mean(&tile) > 0);
    mcv_film_free(&tile);
    mcv_film_free(&stream);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_direct),         cmocka_unit_test(test_tilted),
        cmocka_unit_test(test_irradiance),     cmocka_unit_test(test_light_field_camera),
        cmocka_unit_test(test_through_a_lens), cmocka_unit_test(test_wide_cones),
        cmocka_unit_test(test_schedules)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
