/* SPDX-License-Identifier: Apache-2.0 */
/* The shipped scenes of deflectometry, small: their dents and forms are those of their files. */
#include "found.h"

#define SQUARE(x) ((x) * (x))

enum { WIDTH = 70, HEIGHT = 52, COUNT = WIDTH * HEIGHT };

static mcv_rig *open_scene(const char *name) {
    char path[512];
    mcv_rig *rig = NULL;
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, name);
    WELL(mcv_rig_open(path, &rig, &error));
    return rig;
}

/* A Gaussian dent: depth and standard deviation, and where its middle is [m]. */
typedef struct dent {
    double depth, s, at[2];
} dent;

/*
 * The factor on the closed form of a dent's slopes d r/s² exp(-r²/2s²) that fits best, and its
 * standard error from the uncertainties that are stated.
 */
static double factor_of(const found *f, const dent *d, double *deviation) {
    const float *place = map_of(f, "place", 2), *slope = map_of(f, "slope", 2),
                *u = map_of(f, "slope error", 2);
    double product = 0, square = 0, variance = 0;
    for (int i = 0; i < 2 * COUNT; ++i) {
        const double r[2] = {place[i % COUNT] - d->at[0], place[COUNT + i % COUNT] - d->at[1]},
                     expected = d->depth / (d->s * d->s) * r[i / COUNT] *
                                exp(-(r[0] * r[0] + r[1] * r[1]) / (2 * d->s * d->s));
        if (isnan(slope[i])) continue;
        product += expected * (double)slope[i];
        square += expected * expected;
        variance += pow(expected * (double)u[i], 2);
    }
    *deviation = sqrt(variance) / square;
    return product / square;
}

/*
 * A pixel of width w averages slopes, which takes w²/(12 s²) of the factor: of a Gaussian exp(-r²/2
 * s²) the slopes have the mean squared spatial frequency 2/s², and the box 1 - w² k²/24. With w =
 * 0.6 mm that is 0.7 %. The mesh is right to 1 %. The best plane takes nothing.
 */
static void test_dent_of_the_mirror(void **state) {
    (void)state;
    const dent d = {1e-6, 2e-3, {0.004, 0.003}};
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = open_scene("dented-mirror.gltf");
    found f = find(session, rig,
                   "{\"plane\": \"table\", \"spp\": 256, \"resolution\": \"70x52\", "
                   "\"remove-form\": \"plane\", \"slope-png\": \"slopes.png\"}");
    double deviation;
    const double factor = factor_of(&f, &d, &deviation);
    print_message("mirror: %.4f ± %.4f of the dent\n", factor, deviation);
    assert_float_equal(told(&f, NULL, "pixels"), COUNT, 0);
    assert_true(deviation < 0.01);
    assert_float_equal(factor, 0.993, 0.01 + 4 * deviation);
    mcv_picture *drawn = NULL;
    WELL(mcv_picture_read("slopes.png", &drawn, &error));
    mcv_picture_free(drawn);
    drop(&f);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

/* Finds the panel, its paint of the given α. */
static found find_panel(mcv_session *session, const mcv_rig *rig, double alpha) {
    char options[512];
    snprintf(options, sizeof options,
             "{\"plane\": \"table\", \"spp\": 512, \"resolution\": \"70x52\", \"unwrap\": "
             "\"gray\", \"remove-form\": \"quadric\", \"set\": "
             "[\"materials/paint/extensions/MCVISI_materials/roughness=%.17g\"]}",
             sqrt(alpha));
    return find(session, rig, options);
}

/*
 * The panel is z = -x²/(2 R) - y²/(2 S), and the best surface of second order has these curvatures
 * but for the dent. The dent's volume 2π s² d is 3.1e-9 m³, its mean over 168 mm x 126 mm 0.15 µm:
 * over half of the height squared that is a curvature of 0.15 µm/(63 mm)² = 4e-5/m, times some 5 of
 * the quadric's least squares. A pixel of w = 2.4 mm takes w²/(12 s²) = 1.9 % of the dent's slopes.
 */
static void test_painted_panel(void **state) {
    (void)state;
    const dent d = {20e-6, 5e-3, {0.02, 0.015}};
    mcv_session *session = open_session(NULL);
    mcv_rig *rig = open_scene("painted-panel.gltf");
    found f = find_panel(session, rig, SQUARE(0.032));
    double deviation;
    const double factor = factor_of(&f, &d, &deviation), xx = told(&f, NULL, "curvature_xx"),
                 xy = told(&f, NULL, "curvature_xy"), yy = told(&f, NULL, "curvature_yy");
    print_message("panel: %.4f ± %.4f of the dent; curvatures %.6f %.6f %.6f\n", factor, deviation,
                  xx, xy, yy);
    assert_true(told(&f, NULL, "pixels") >= 0.99 * COUNT);
    assert_true(deviation < 0.02);
    assert_float_equal(factor, 0.981, 0.01 + 4 * deviation);
    assert_float_equal(xx, -1 / 2.0, 5e-4);
    assert_float_equal(yy, -1 / 5.0, 5e-4);
    assert_float_equal(xy, 0, 5e-4);
    /* Paint that is less well polished: as a rough mirror (test_deflectometry), k = 4π d/period. d
     * goes from 0.48 m to 0.56 m across the panel. The slope of x K1(x) is -x K0(x), -0.43 and
     * -0.42 at these α: with d = 0.51 m, the mean to 2 %, the ratio is known to 0.01. Noise adds
     * some 0.005. */
    const double alpha = 0.002, k = 4 * M_PI * 0.51 / 14.4e-3,
                 expected = k * alpha * bessel_k1(k * alpha) /
                            (k * SQUARE(0.032) * bessel_k1(k * SQUARE(0.032)));
    found rough = find_panel(session, rig, alpha);
    const double seen =
        told(&rough, "across_columns", "contrast") / told(&f, "across_columns", "contrast");
    print_message("rough paint: contrast falls by %.4f, expected %.4f\n", seen, expected);
    assert_float_equal(seen, expected, 0.02);
    drop(&rough);
    drop(&f);
    mcv_rig_free(rig);
    mcv_session_close(session);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_dent_of_the_mirror),
        cmocka_unit_test(test_painted_panel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
