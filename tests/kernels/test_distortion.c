/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Tilted films and distorting lenses on the device against the reference's formulas in double, the
 * way back that light paths take, and the plane in focus of a tilted film. u = 2^-24 is the
 * relative error of one float32 operation.
 */
#include "elements.h"

#include "reference/random.h"
#include "scene/lens_map.h"

enum { CASES = 1 << 16 };
static const double u = 0x1p-24;

#define SET_LENS(p, ...) \
    do { \
        const struct { double tilt, direction, k[6], p[2], s[4], kappa; } lens = {__VA_ARGS__}; \
        if (lens.tilt != 0) (p)->tilt = lens.tilt, (p)->tiltDirection = lens.direction; \
        (p)->k1 = lens.k[0], (p)->k2 = lens.k[1], (p)->k3 = lens.k[2], (p)->k4 = lens.k[3]; \
        (p)->p1 = lens.p[0], (p)->p2 = lens.p[1], (p)->s1 = lens.s[0], (p)->s4 = lens.s[3]; \
        (p)->kappa = lens.kappa; \
    } while (0)

enum { TILTED, BROWN_CONRADY, DIVISION, BOTH, LENSES };

#define SET_KIND(p, kind) \
    do { \
        if ((kind) == TILTED) SET_LENS(p, 0.25, 0.6, {0}, {0}, {0}, 0); \
        if ((kind) == BROWN_CONRADY) \
            SET_LENS(p, 0, 0, {-0.3, 0.1, -0.02, 0.05}, {2e-3, -3e-3}, {1e-3, 0, 0, 2e-3}, 0); \
        if ((kind) == DIVISION) SET_LENS(p, 0, 0, {0}, {0}, {0}, -2500); \
        if ((kind) == BOTH) SET_LENS(p, -0.2, 2, {0.2, 0.05}, {1e-3, 0}, {0}, 0); \
        (p)->resolution[0] = 200, (p)->resolution[1] = 150; \
        (p)->pixelSize[0] = 50e-6, (p)->pixelSize[1] = 40e-6; \
        (p)->principalPoint[0] = 90.3, (p)->principalPoint[1] = 80.2; \
    } while (0)

static mcv_sensor sensor_of_kind(uint32_t type, int kind, int falloff) {
    mcv_sensor sensor = sensor_defaults(type);
    if (type == MCV_SENSOR_PINHOLE) {
        mcv_pinhole_params *p = &sensor.as.pinhole;
        SET_KIND(p, kind);
        p->imageDistance = 0.02;
    } else if (type == MCV_SENSOR_THIN_LENS) {
        mcv_thin_lens_params *p = &sensor.as.thin_lens;
        SET_KIND(p, kind);
        p->focalLength = 0.018;
        p->imageDistance = 0.02;
        p->lensDiameter = 0.008;
        p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
        p->falloff = falloff;
    } else {
        mcv_telecentric_params *p = &sensor.as.telecentric;
        SET_KIND(p, kind);
        p->focalLength = 0.04;
        p->imageDistance = 0.06;
        p->stopDiameter = 0.005;
        /* With a table, too; the film's corners are 6.4 mm away. */
        if (kind == TILTED || kind == BOTH)
            p->relativeIllumination = (mcv_curve){4, {0, 3e-3, 5e-3, 7e-3}, {1, 0.95, 0.8, 0.5}};
        p->radiometry = MCV_RADIOMETRY_IRRADIANCE;
        p->falloff = falloff;
    }
    return sensor;
}

static void make_cases(const mcv_sensor *sensor, size_t words, uint32_t *cases) {
    ref_random random = {7};
    uint32_t size[2];
    mcv_sensor_film_size(sensor, &size[0], &size[1]);
    for (size_t i = 0; i < CASES; ++i) {
        for (int k = 0; k < 2; ++k)
            cases[words * i + k] = (uint32_t)(size[k] * ref_random_unit(&random));
        for (int k = 2; k < 6; ++k)
            cases[words * i + k] = as_uint((float)(ref_random_bits(&random) >> 40) * 0x1p-24F);
        if (words > 6) cases[words * i + 6] = as_uint((float)(0.1 + ref_random_unit(&random)));
    }
}

/* All kinds of lenses of all cameras. A slope takes some 40 operations, of which Newton's steps
 * leave the last; slopes are below 0.5, and the lens's derivatives below 2. Shares of weights are
 * products of derivatives that cancel a little: they take 100. The reference's shares come from
 * differences, within 1e-8. */
static void compare(uint32_t type, int kind, int falloff, uint32_t *cases, float *sights) {
    mcv_scene *scene = mcv_scene_new("sensor");
    const mcv_sensor values = sensor_of_kind(type, kind, falloff);
    double worst[3] = {0};
    size_t at_rim = 0;
    add_sensor(scene, type, &values, mcv_transform_identity());
    const mcv_sensor *sensor = &scene->sensors[0];
    const double scale = type == MCV_SENSOR_TELECENTRIC ? sensor->as.telecentric.focalLength : 1;
    make_cases(sensor, 6, cases);
    device_sights(sensor, CASES, cases, sights);
    for (size_t i = 0; i < CASES; ++i) {
        const float *out = sights + 7 * i;
        const ref_sensor_ray sight = reference_sight(sensor, cases + 6 * i);
        const double d[2] = {sight.direction.x / -sight.direction.z,
                             sight.direction.y / -sight.direction.z};
        worst[0] = fmax(worst[0],
                        fmax(fabs(out[0] - sight.origin.x), fabs(out[1] - sight.origin.y)) / scale);
        worst[1] = fmax(worst[1], fmax(fabs(out[3] - d[0]), fabs(out[4] - d[1])));
        if ((out[6] > 0) != (sight.weight > 0))
            ++at_rim;
        else if (sight.weight > 0)
            worst[2] = fmax(worst[2], fabs(out[6] / sight.weight - 1));
    }
    print_message("type %u, lens %d: origin %.2g, direction %.2g, weight %.2g, %zu at the rim\n",
                  type, kind, worst[0], worst[1], worst[2], at_rim);
    assert_true(worst[0] <= 40 * u && worst[1] <= 40 * u);
    assert_true(worst[2] <= 100 * u + 1e-8);
    assert_true(at_rim <= 4);
    mcv_scene_free(scene);
}

static void test_sights(void **state) {
    static const uint32_t types[] = {MCV_SENSOR_PINHOLE, MCV_SENSOR_THIN_LENS,
                                     MCV_SENSOR_TELECENTRIC};
    uint32_t *cases = malloc(6 * sizeof *cases * CASES);
    float *sights = floats(7 * (size_t)CASES);
    (void)state;
    assert_non_null(cases);
    for (int t = 0; t < 3; ++t)
        for (int kind = 0; kind < LENSES; ++kind)
            for (int falloff = 0; falloff < (t ? 2 : 1); ++falloff)
                compare(types[t], kind, falloff, cases, sights);
    free(cases);
    free(sights);
}

/*
 * The way back: the place on the film is found within 1e-3 pixels (a slope's 40 u over 2 mrad of a
 * pixel), and W = weight over the pupil's area and the area of slopes (of a telecentric camera: of
 * places) that a pixel sees through one point of it, by central differences of the reference.
 */
static double seen_area(const mcv_sensor *sensor, const uint32_t *in) {
    const bool telecentric = sensor->type == MCV_SENSOR_TELECENTRIC;
    const float step = 1.0F / 64;
    double by[2][2];
    for (int k = 0; k < 2; ++k) {
        double at[2][2];
        for (int side = 0; side < 2; ++side) {
            uint32_t moved[6];
            memcpy(moved, in, sizeof moved);
            moved[2 + k] = as_uint(as_float(in[2 + k]) + (side ? step : -step));
            const ref_sensor_ray sight = reference_sight(sensor, moved);
            at[side][0] = telecentric ? sight.origin.x : sight.direction.x / -sight.direction.z;
            at[side][1] = telecentric ? sight.origin.y : sight.direction.y / -sight.direction.z;
        }
        for (int j = 0; j < 2; ++j) by[k][j] = (at[1][j] - at[0][j]) / (2 * (double)step);
    }
    return fabs(by[0][0] * by[1][1] - by[0][1] * by[1][0]);
}

static void check_way_back(uint32_t type, int kind, int falloff, uint32_t *cases, float *results) {
    mcv_scene *scene = mcv_scene_new("sensor");
    const mcv_sensor values = sensor_of_kind(type, kind, falloff);
    double worst[2] = {0};
    add_sensor(scene, type, &values, mcv_transform_identity());
    const mcv_sensor *sensor = &scene->sensors[0];
    const double radius = type == MCV_SENSOR_THIN_LENS ? 0.004
                          : type == MCV_SENSOR_PINHOLE ? M_2_SQRTPI / 2
                                                       : 0.0025 / 0.04;
    make_cases(sensor, 7, cases);
    run_sensor("invert_sensor", sensor, CASES, cases, 7 * sizeof *cases, results,
               6 * sizeof *results);
    for (size_t i = 0; i < CASES; ++i) {
        const uint32_t *in = cases + 7 * i;
        const float *out = results + 6 * i;
        if (!(out[5] > 0) || !(out[2] > 0)) continue;
        worst[0] = fmax(worst[0], fmax(fabs(out[0] - in[0] - (double)as_float(in[2])),
                                       fabs(out[1] - in[1] - (double)as_float(in[3]))));
        if (i % 16 != 0) continue;
        const double truth = out[5] / (M_PI * radius * radius * seen_area(sensor, in));
        worst[1] = fmax(worst[1], fabs(out[2] / truth - 1));
    }
    print_message("type %u, lens %d, back: %.2g pixels, W %.2g\n", type, kind, worst[0], worst[1]);
    assert_true(worst[0] > 0 && worst[0] < 1e-3);
    assert_true(worst[1] > 0 && worst[1] < 2e-5);
    mcv_scene_free(scene);
}

static void test_way_back(void **state) {
    static const uint32_t types[] = {MCV_SENSOR_PINHOLE, MCV_SENSOR_THIN_LENS,
                                     MCV_SENSOR_TELECENTRIC};
    uint32_t *cases = malloc(7 * sizeof *cases * CASES);
    float *results = floats(6 * (size_t)CASES);
    (void)state;
    assert_non_null(cases);
    for (int t = 0; t < 3; ++t)
        for (int kind = 0; kind < LENSES; ++kind)
            check_way_back(types[t], kind, kind % 2, cases, results);
    free(cases);
    free(results);
}

/*
 * Scheimpflug: all rays of a pixel meet on the plane w = w0 - y tanτ/m, y down from the axis where
 * they meet, w0 = f b/(b - f), m = (b - f)/f. Both cameras have the same one: it goes through the
 * line in which the planes of film and lens meet. Where rays meet is found within 1e-4 of w: slopes
 * are off by 40 u, and the rays lie 0.05 apart at least.
 */
static void test_plane_in_focus(void **state) {
    uint32_t *cases = malloc(6 * sizeof *cases * CASES);
    float *sights = floats(7 * (size_t)CASES);
    (void)state;
    assert_non_null(cases);
    for (int telecentric = 0; telecentric < 2; ++telecentric) {
        const uint32_t type = telecentric ? MCV_SENSOR_TELECENTRIC : MCV_SENSOR_THIN_LENS;
        mcv_scene *scene = mcv_scene_new("sensor");
        mcv_sensor values = sensor_of_kind(type, LENSES, 0);
        const double f = telecentric ? 0.04 : 0.018, b = telecentric ? 0.06 : 0.02,
                     w0 = f * b / (b - f);
        double worst = 0;
        if (telecentric)
            values.as.telecentric.tilt = 0.25;
        else
            values.as.thin_lens.tilt = 0.25;
        add_sensor(scene, type, &values, mcv_transform_identity());
        make_cases(scene->sensors, 6, cases);
        for (size_t i = 1; i < CASES; i += 2) {
            memcpy(cases + 6 * i, cases + 6 * (i - 1), 4 * sizeof *cases);
            for (int k = 4; k < 6; ++k) /* nearly the opposite side of the pupil */
                cases[6 * i + k] = as_uint(1 - 0x1p-24F - as_float(cases[6 * (i - 1) + k]));
        }
        device_sights(scene->sensors, CASES, cases, sights);
        for (size_t i = 0; i < CASES; i += 2) {
            const float *a = sights + 7 * i, *c = a + 7;
            const double dx = (double)a[3] - c[3], dy = (double)a[4] - c[4];
            if (hypot(dx, dy) < 0.05) continue;
            const double w = (((double)c[0] - a[0]) * dx + ((double)c[1] - a[1]) * dy) /
                             (dx * dx + dy * dy),
                         down = -(a[1] + w * a[4]), plane = w0 - down * tan(0.25) * f / (b - f);
            worst = fmax(worst, fabs(w / plane - 1));
        }
        print_message("%s: in focus within %.2g\n", telecentric ? "telecentric" : "thin lens",
                      worst);
        assert_true(worst > 0 && worst < 1e-4);
        mcv_scene_free(scene);
    }
    free(cases);
    free(sights);
}

static int open_with_features(void **state) {
    element_features = MCV_FEATURE_BIT(DISTORTION) | MCV_FEATURE_BIT(LIGHT_TRACING);
    return open_device(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sights),
        cmocka_unit_test(test_way_back),
        cmocka_unit_test(test_plane_in_focus),
    };
    return cmocka_run_group_tests(tests, open_with_features, close_device);
}
