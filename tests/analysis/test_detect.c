/* SPDX-License-Identifier: Apache-2.0 */
/* Detectability: the closed form of a known signal in white noise, what a matched filter does with
 * exposures of the camera, and how often the interval holds the truth. */
#include "test.h"

#include <math.h>
#include <stdlib.h>

#include "analysis/detect.h"
#include "mesh.h"

enum { SIDE = 24, PIXELS = SIDE * SIDE, MOST = 16, COLOURS = 3 };

static const mcv_camera plain = {.electrons_per_unit = {1, 1, 1},
                                 .full_well = 1e5,
                                 .gain = 1,
                                 .read_noise = 7,
                                 .dark_electrons = 20,
                                 .bits = 16};

static double normal(uint64_t *state) {
    const double u = 1 - random_unit(state), v = random_unit(state);
    return sqrt(-2 * log(u)) * cos(2 * M_PI * v);
}

/* A spot of this height in electrons, 3 pixels wide. */
static double spot(int i, double height) {
    const double x = i % SIDE - 0.5 * SIDE, y = i / SIDE - 0.5 * SIDE;
    return height * exp(-(x * x + y * y) / 18);
}

static double background(int i) { return 500 + 40 * (i % SIDE); }

static double true_squared(const mcv_camera *camera, double height) {
    double sum = 0;
    for (int i = 0; i < PIXELS; ++i)
        sum += pow(spot(i, height), 2) / mcv_detect_variance(camera, background(i));
    return sum;
}

typedef struct pictures {
    double with[MOST * PIXELS], without[MOST * PIXELS];
    mcv_pairs pairs;
} pictures;

/* Pairs that share errors (common), and errors of their own. */
static void make_pairs(pictures *p, uint32_t replicates, double height, double common, double own,
                       uint64_t *state) {
    for (uint32_t r = 0; r < replicates; ++r)
        for (int i = 0; i < PIXELS; ++i) {
            const double both = common * normal(state);
            p->without[r * PIXELS + (uint32_t)i] = background(i) + both;
            p->with[r * PIXELS + (uint32_t)i] =
                background(i) + both + spot(i, height) + own * normal(state);
        }
    p->pairs = (mcv_pairs){.width = SIDE,
                           .height = SIDE,
                           .channels = 1,
                           .replicates = replicates,
                           .with = p->with,
                           .without = p->without,
                           .correlation = {1, 1, 1, 1}};
}

static mcv_detection detect(const pictures *p, const mcv_camera *camera) {
    mcv_detection d;
    mcv_error error;
    assert_int_equal(mcv_detect(&p->pairs, camera, 3, NULL, &d, &error), MCV_OK);
    return d;
}

/* Without errors of the render it is the closed form; what both share does not matter. */
static void test_closed_form(void **state) {
    static pictures p;
    uint64_t random = 1;
    (void)state;
    make_pairs(&p, 4, 30, 0, 0, &random);
    mcv_detection d = detect(&p, &plain);
    const double wanted = true_squared(&plain, 30);
    double sum = 0, squares = 0, mean = 0;
    uint64_t visible = 0;
    for (int i = 0; i < PIXELS; ++i) {
        sum += spot(i, 30) / PIXELS;
        squares += pow(spot(i, 30), 2) / PIXELS;
        mean += background(i) / PIXELS;
        visible += spot(i, 30) >= 3 * sqrt(mcv_detect_variance(&plain, background(i)));
    }
    assert_true(fabs(d.squared.value / wanted - 1) < 1e-9);
    assert_true(fabs(d.detectability / sqrt(wanted) - 1) < 1e-9);
    assert_true(d.squared.uncertainty < 1e-9 && d.high - d.low < 1e-9);
    assert_true(fabs(d.difference.value / sum - 1) < 1e-9);
    assert_true(fabs(d.contrast.value / (sum / mean) - 1) < 1e-9);
    assert_true(fabs(d.rms_contrast.value / (sqrt(squares) / mean) - 1) < 1e-9);
    assert_int_equal(d.values, PIXELS);
    assert_int_equal(d.visible, visible);
    /* A variance by hand: 1000 + 20 + 49 + 1/12 + 4 + 100. */
    mcv_camera patterned = plain;
    patterned.dsnu = 2;
    patterned.prnu = 0.01;
    assert_true(fabs(mcv_detect_variance(&patterned, 1000) - 1173.0833333) < 1e-6);
    /* Above the full well both are equal. */
    mcv_camera small = plain;
    small.full_well = 400;
    assert_true(detect(&p, &small).squared.value == 0);
}

/* The matched filter on exposures of the camera: means and deviations of its output with and
 * without. Of n exposures each, the error of d' is √(2/n + d'²/(4 n)). */
static void test_matched_filter(void **state) {
    enum { EXPOSURES = 600 };
    const double height = 14, wanted = sqrt(true_squared(&plain, height));
    double sums[2] = {0, 0}, squares[2] = {0, 0};
    mcv_error error;
    mcv_image light;
    (void)state;
    assert_int_equal(mcv_image_new(&light, SIDE, SIDE, 1, &error), MCV_OK);
    for (int with = 0; with < 2; ++with)
        for (uint32_t seed = 0; seed < EXPOSURES; ++seed) {
            mcv_camera camera = plain;
            mcv_exposure exposure;
            double out = 0;
            camera.seed = seed + EXPOSURES * (uint32_t)with;
            for (int i = 0; i < PIXELS; ++i)
                light.pixels[i] = (float)(background(i) + spot(i, with ? height : 0));
            assert_int_equal(mcv_camera_expose(&camera, &light, NULL, &exposure, &error), MCV_OK);
            for (int i = 0; i < PIXELS; ++i)
                out += spot(i, height) * (double)exposure.grey.pixels[i] /
                       mcv_detect_variance(&plain, background(i));
            mcv_exposure_free(&exposure);
            sums[with] += out / EXPOSURES;
            squares[with] += out * out / EXPOSURES;
        }
    mcv_image_free(&light);
    const double deviation =
                     sqrt(0.5 * (squares[0] - sums[0] * sums[0] + squares[1] - sums[1] * sums[1])),
                 found = (sums[1] - sums[0]) / deviation,
                 u = sqrt(2.0 / EXPOSURES + wanted * wanted / (4.0 * EXPOSURES));
    if (fabs(found - wanted) > 3 * u)
        fail_msg("a matched filter has d' = %g, must be %g +- %g", found, wanted, u);
}

/*
 * The share of intervals that hold the truth, of 2000 each: between 93 and 97 % where there is a
 * signal. The deviation of such a share is 0.5 %. Without a signal the interval begins at 0 in all
 * but 2.5 % of cases.
 */
static void test_coverage(void **state) {
    enum { TRIALS = 2000 };
    static pictures p;
    static const struct {
        uint32_t replicates;
        double height, own;
    } cases[] = {{4, 0, 20}, {4, 4, 20}, {4, 12, 20}, {4, 40, 40}, {2, 12, 10}, {16, 4, 40}};
    uint64_t random = 3;
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        const double truth = sqrt(true_squared(&plain, cases[k].height));
        int held = 0;
        double mean = 0;
        for (int t = 0; t < TRIALS; ++t) {
            make_pairs(&p, cases[k].replicates, cases[k].height, 0, cases[k].own, &random);
            const mcv_detection d = detect(&p, &plain);
            held += d.low <= truth && truth <= d.high;
            mean += d.squared.value / TRIALS;
        }
        const double share = (double)held / TRIALS;
        print_message("R %u, d' %.3f: %.4f, mean of d'^2 %.4f (%.4f)\n", cases[k].replicates, truth,
                      share, mean, truth * truth);
        if (share < 0.93 || share > (truth > 0 ? 0.97 : 0.99))
            fail_msg("%u replicates, d' = %g: %g of the intervals hold it", cases[k].replicates,
                     truth, share);
    }
}

/*
 * The three channels of a pixel with equal errors, and the defect in each of them by its share.
 * Where the shares are opposite, the errors cancel in d'. Alike, d' is √3 times as large as of one
 * channel, and as uncertain; read through a Bayer pattern each pixel has its channel's error alone.
 * Of the faint defect the squares of the errors count, of the strong one their products with it.
 * 2 % are 2.9 deviations of the share that 1000 intervals hold.
 */
static void test_coverage_of_colours(void **state) {
    enum { TRIALS = 1000, REPLICATES = 4 };
    static pictures p;
    static struct {
        double with[COLOURS * REPLICATES * PIXELS], without[COLOURS * REPLICATES * PIXELS];
    } colours;
    static const struct {
        bool bayer;
        double height, shares[COLOURS];
    } cases[] = {{false, 12, {1, 1, 1}},  {true, 12, {1, 1, 1}},      {false, 120, {1, 1, 1}},
                 {true, 120, {1, 1, 1}},  {false, 120, {1, 0, 0}},    {false, 120, {1, -1, 0}},
                 {false, 12, {1, -1, 0}}, {false, 120, {1, 0.5, 0.2}}};
    uint64_t random = 5;
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
        const bool bayer = cases[k].bayer;
        const double height = cases[k].height, *shares = cases[k].shares;
        mcv_camera camera = plain;
        camera.bayer = bayer ? MCV_BAYER_RGGB : MCV_BAYER_NONE;
        double squares = 0;
        for (int c = 0; c < COLOURS; ++c) squares += shares[c] * shares[c];
        const double truth = sqrt((bayer ? 1 : squares) * true_squared(&plain, height));
        int held = 0;
        for (int t = 0; t < TRIALS; ++t) {
            make_pairs(&p, REPLICATES, 0, 0, 20, &random);
            for (int i = 0; i < REPLICATES * COLOURS * PIXELS; ++i) {
                const int from = i / (COLOURS * PIXELS) * PIXELS + i % PIXELS;
                colours.with[i] =
                    p.with[from] + shares[i / PIXELS % COLOURS] * spot(i % PIXELS, height);
                colours.without[i] = p.without[from];
            }
            p.pairs.channels = COLOURS;
            p.pairs.with = colours.with;
            p.pairs.without = colours.without;
            const mcv_detection d = detect(&p, &camera);
            held += d.low <= truth && truth <= d.high;
        }
        const double share = (double)held / TRIALS;
        print_message("%s, height %g, shares %g %g %g: %.4f\n", bayer ? "Bayer" : "three channels",
                      height, shares[0], shares[1], shares[2], share);
        if (fabs(share - 0.95) > 0.02)
            fail_msg("%s, shares %g %g %g: %g of the intervals hold d' = %g",
                     bayer ? "Bayer" : "three channels", shares[0], shares[1], shares[2], share,
                     truth);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed_form), cmocka_unit_test(test_matched_filter),
        cmocka_unit_test(test_coverage), cmocka_unit_test(test_coverage_of_colours)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
