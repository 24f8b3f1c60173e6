/* SPDX-License-Identifier: Apache-2.0 */
/* Regions: which pixels belong to one, figures against their definitions, and stated uncertainties
 * against many pictures. Seeds are fixed.
 */
#include "test.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "analysis/blur.h"
#include "analysis/noise.h"
#include "analysis/region.h"
#include "coverage.h"
#include "io/values.h"

enum { WIDTH = 80, HEIGHT = 60, PLANE = WIDTH * HEIGHT };

static mcv_readings make(void) {
    mcv_readings r = {0};
    mcv_error error = {""};
    assert_int_equal(mcv_image_new(&r.values, WIDTH, HEIGHT, 1, &error), MCV_OK);
    assert_int_equal(mcv_image_new(&r.deviation, WIDTH, HEIGHT, 1, &error), MCV_OK);
    return r;
}

static mcv_readings make_rendered(void) {
    mcv_readings r = make();
    mcv_error error = {""};
    assert_int_equal(mcv_image_new(&r.render, WIDTH, HEIGHT, 1, &error), MCV_OK);
    return r;
}

static void release(mcv_readings *r) {
    mcv_image_free(&r->values);
    mcv_image_free(&r->deviation);
    mcv_image_free(&r->render);
}

static mcv_roi parse(const mcv_readings *r, const char *text) {
    mcv_roi region;
    mcv_error error = {""};
    if (mcv_roi_parse(text, 7, &r->values, &region, &error) != MCV_OK) fail_msg("%s", error.text);
    return region;
}

static void test_what_belongs(void **state) {
    mcv_readings r = make();
    mcv_error error = {""};
    mcv_roi region = parse(&r, "spot=10,20,5,4");
    (void)state;
    assert_string_equal(region.name, "spot");
    assert_int_equal(region.count, 20);
    assert_true(region.inside[20 * WIDTH + 10] && region.inside[23 * WIDTH + 14] &&
                !region.inside[24 * WIDTH + 14]);
    mcv_roi_free(&region);
    /* Where the centre is inside: 0.6 … 2.4 holds that of pixel 1 alone. */
    region = parse(&r, "0.6,0.6,1.8,1.8");
    assert_string_equal(region.name, "7");
    assert_int_equal(region.count, 1);
    mcv_roi_free(&region);
    /* A right triangle of 40 x 40 pixels: centres below the diagonal, 39·40/2, and those on it,
     * which belong to one side. */
    region = parse(&r, "0,0,40,40,0,40");
    if (region.count < 780 || region.count > 820)
        fail_msg("%llu pixels in the triangle", (unsigned long long)region.count);
    mcv_roi_free(&region);
    /* A mask, and NaN that belong to no region. */
    for (size_t i = 0; i < PLANE; ++i) r.values.pixels[i] = (float)(i % 3 == 0);
    assert_int_equal(mcv_values_write("test_region.png", &r.values, 8, &error), MCV_OK);
    region = parse(&r, "m=test_region.png");
    assert_int_equal(region.count, PLANE / 3);
    mcv_roi_free(&region);
    r.values.pixels[0] = NAN;
    region = parse(&r, "0,0,2,2");
    assert_int_equal(region.count, 3);
    mcv_roi_free(&region);
    release(&r);
}

static void expect_refused(const mcv_readings *r, const char *text, const char *part) {
    mcv_roi region;
    mcv_error error = {""};
    assert_int_not_equal(mcv_roi_parse(text, 1, &r->values, &region, &error), MCV_OK);
    if (!strstr(error.text, part)) fail_msg("%s: \"%s\" is missing in: %s", text, part, error.text);
    assert_null(region.inside);
}

static void test_bad_regions(void **state) {
    mcv_readings r = make();
    mcv_image small;
    mcv_error error = {""};
    (void)state;
    expect_refused(&r, "70,50,11,5", "80 x 60");
    expect_refused(&r, "-1,0,5,5", "column -1");
    expect_refused(&r, "5,5,0.2,0.2", "no pixel");
    expect_refused(&r, "1,2,3", "X,Y,W,H");
    expect_refused(&r, "1,2,3,4,5", "X,Y,W,H");
    expect_refused(&r, "1,2,,4", "X,Y,W,H");
    expect_refused(&r, "1,2,3,4,", "X,Y,W,H");
    expect_refused(&r, "a=b", "X,Y,W,H");
    expect_refused(&r, "missing.png", "missing.png");
    expect_refused(&r, "1,2,1e999,4", "X,Y,W,H");
    assert_int_equal(mcv_image_new(&small, 10, 10, 1, &error), MCV_OK);
    assert_int_equal(mcv_values_write("test_region.png", &small, 8, &error), MCV_OK);
    expect_refused(&r, "test_region.png", "10 x 10");
    unlink("test_region.png");
    mcv_image_free(&small);
    release(&r);
}

/* --- uncertainties
 * ---------------------------------------------------------------------------------------------- */

enum { FIGURES = 9 };
static const char *const names[FIGURES] = {"mean",  "deviation",  "rms contrast",
                                           "snr",   "uniformity", "difference",
                                           "Weber", "Michelson",  "CNR"};

static void collect(const mcv_readings *r, const mcv_roi *region, const mcv_roi *background,
                    mcv_quantity found[FIGURES]) {
    const mcv_roi_figures f = mcv_roi_measure(r, region);
    const mcv_contrast_figures c = mcv_roi_contrast(r, region, background);
    const mcv_quantity all[FIGURES] = {f.mean,  f.deviation,  f.rms_contrast,
                                       f.snr,   f.uniformity, c.difference,
                                       c.weber, c.michelson,  c.contrast_to_noise};
    memcpy(found, all, sizeof all);
}

/* The root of a population's variance plus the mean variance of its noise: what the sample
 * deviation estimates. */
static double true_deviation(const mcv_readings *clean, const mcv_roi *region, double mean,
                             double *signal) {
    double squares = 0, noise = 0;
    for (size_t i = 0; i < PLANE; ++i) {
        if (!region->inside[i]) continue;
        squares += pow(clean->values.pixels[i] - mean, 2);
        noise += pow(clean->deviation.pixels[i], 2) / (double)region->count;
    }
    *signal = sqrt(squares / ((double)region->count - 1));
    return hypot(*signal, sqrt(noise));
}

typedef struct scenery {
    const char *name, *region, *background;
    double shading,
        texture;           /* of the field; the texture is finer than the cells of its uniformity */
    bool known;            /* the pixels' uncertainties; else they are estimated */
    double camera, render; /* standard deviations: of what a camera adds, 0: shot-like; of the
                              render's error at a value of 100 */
    double
        f_number; /* of a lens that blurs the render's error before the camera reads it, 0: none */
} scenery;

enum { PICTURES = 4 }; /* replicates, from whose spread the render's error comes */

/* A render as a film develops it: the mean of its replicates and its standard error, both blurred
 * by the lens. */
static void render(const scenery *s, const mcv_image *clean, uint32_t seed, mcv_readings *r) {
    const mcv_lens_mtf lens = {.f_number = s->f_number, .wavelength = 550e-9},
                       mtf[3] = {lens, lens, lens};
    mcv_error error = {""};
    for (uint32_t i = 0; i < PLANE; ++i) {
        mcv_noise noise = mcv_noise_begin(seed, 1, i);
        double values[PICTURES], mean = 0, squares = 0;
        const double one = s->render * sqrt(PICTURES * (double)clean->pixels[i] / 100);
        for (int k = 0; k < PICTURES; ++k)
            mean += (values[k] = clean->pixels[i] + one * mcv_noise_normal(&noise)) / PICTURES;
        for (int k = 0; k < PICTURES; ++k) squares += (values[k] - mean) * (values[k] - mean);
        r->values.pixels[i] = (float)mean;
        r->render.pixels[i] = (float)sqrt(squares / (PICTURES - 1) / PICTURES);
    }
    r->render_freedom = PICTURES - 1;
    r->correlation = (mcv_correlation){1, 1, 1, 1};
    if (s->f_number > 0)
        assert_int_equal(mcv_blur(&r->values, &r->render, mtf, (const double[]){3.45e-6, 3.45e-6},
                                  &r->correlation, &error),
                         MCV_OK);
}

static double field_at(const scenery *s, int x, int y) {
    return (100 - s->shading * (0.4 * x + 0.25 * y) + s->texture * sin(1.9 * x) * cos(1.7 * y)) *
           (x < 40 ? 1 : 0.6);
}

/* Value ± 1.96 uncertainty holds the truth in 95 % of the pictures. */
static void check_coverage(const scenery *s) {
    mcv_readings clean = make(), noisy = make_rendered(), silent = make(), unblurred = make();
    mcv_quantity found[FIGURES];
    int covered[FIGURES] = {0}, given[FIGURES] = {0};
    for (int y = 0; y < HEIGHT; ++y)
        for (int x = 0; x < WIDTH; ++x) {
            const int i = y * WIDTH + x;
            clean.values.pixels[i] = silent.values.pixels[i] = unblurred.values.pixels[i] =
                (float)field_at(s, x, y);
            /* Shot-like; without knowledge the noise is taken as even. */
            clean.deviation.pixels[i] = s->camera != 0 ? (float)fmax(0, s->camera)
                                        : s->known     ? sqrtf(2 + 0.1F * clean.values.pixels[i])
                                                       : 3;
        }
    if (s->f_number > 0) {
        const scenery exact = {.f_number = s->f_number};
        mcv_readings blurred = make_rendered();
        render(&exact, &clean.values, 0, &blurred);
        memcpy(clean.values.pixels, blurred.values.pixels, PLANE * sizeof(float));
        memcpy(silent.values.pixels, blurred.values.pixels, PLANE * sizeof(float));
        release(&blurred);
    }
    mcv_roi region = parse(&clean, s->region), background = parse(&clean, s->background);
    double b = 0, m = 0, ss, bs;
    for (size_t i = 0; i < PLANE; ++i) {
        if (region.inside[i]) m += clean.values.pixels[i] / (double)region.count;
        if (background.inside[i]) b += clean.values.pixels[i] / (double)background.count;
    }
    const double sm = true_deviation(&clean, &region, m, &ss),
                 sb = true_deviation(&clean, &background, b, &bs);
    const double even = mcv_roi_measure(&silent, &region).uniformity.value; /* by definition */
    const double truths[FIGURES] = {
        m, sm, ss / m, m / sm, even, m - b, (m - b) / b, (m - b) / (m + b), (m - b) / sb};
    for (uint32_t n = 0; n < CASES; ++n) {
        memcpy(noisy.values.pixels, clean.values.pixels, PLANE * sizeof(float));
        if (s->render > 0) render(s, &unblurred.values, n, &noisy);
        for (uint32_t i = 0; i < PLANE; ++i) {
            mcv_noise noise = mcv_noise_begin(n, 0, i);
            noisy.values.pixels[i] = (float)(noisy.values.pixels[i] +
                                             clean.deviation.pixels[i] * mcv_noise_normal(&noise));
            noisy.deviation.pixels[i] = hypotf(clean.deviation.pixels[i], noisy.render.pixels[i]);
        }
        if (!s->known) {
            mcv_roi_estimate_noise(&noisy, &background, 0);
            mcv_roi_estimate_noise(&noisy, &region, 0);
        }
        collect(&noisy, &region, &background, found);
        for (int k = 0; k < FIGURES; ++k) {
            given[k] += !isnan(found[k].value);
            covered[k] += fabs(found[k].value - truths[k]) <= 1.959964 * found[k].uncertainty;
        }
    }
    print_message("%s:", s->name);
    for (int k = 0; k < FIGURES; ++k) {
        print_message(" %s %.1f %%", names[k], 100.0 * covered[k] / given[k]);
        if (given[k] < CASES) print_message(" of %d", given[k]);
        print_message(k < FIGURES - 1 ? "," : "\n");
    }
    /* A refusal misleads nobody: at most 5 % of all pictures do. Of those that are left, the ones
     * that came out too large are more. Cells of a uniformity that are no larger than the blur vary
     * less than is said. */
    const double most = (s->known || s->render == 0 ? 0.95 + margin : 0.96 + margin) *
                        CASES; /* skewed estimates of noise and error add up */
    for (int k = 0; k < FIGURES; ++k)
        if (given[k] - covered[k] > (0.05 + margin) * CASES ||
            (s->f_number == 0 && given[k] == CASES && covered[k] > most))
            fail_msg("%s: %s: %d of %d intervals hold the truth", s->name, names[k], covered[k],
                     given[k]);
    mcv_roi_free(&region);
    mcv_roi_free(&background);
    release(&clean);
    release(&noisy);
    release(&silent);
    release(&unblurred);
}

static const char polygon[] = "5,5,36,10,38,50,8,45"; /* overlaps the wide background */

static void test_coverage(void **state) {
    static const scenery sceneries[] = {
        {"shaded and textured", polygon, "30,10,40,40", 1, 12, true, 0, 0, 0},
        {"shaded, noise estimated", polygon, "30,10,40,40", 1, 0, false, 0, 0, 0},
        {"even", "2,5,36,50", "42,10,36,40", 0, 0, true, 0, 0, 0},
        {"even, noise estimated", "2,5,36,50", "42,10,36,40", 0, 0, false, 0, 0, 0},
        {"faint texture", "2,5,36,50", "42,10,36,40", 0, 1, true, 0, 0, 0},
        {"few pixels", "4,4,16,12", "50,20,16,12", 0, 0, true, 0, 0, 0},
        {"36 pixels, noise estimated", "4,4,6,6", "50,20,6,6", 0, 0, false, 0, 0, 0},
        {"64 pixels, noise estimated", "4,4,8,8", "50,20,8,8", 0, 0, false, 0, 0, 0},
        {"64 shaded pixels, noise estimated", "4,4,8,8", "50,20,8,8", 1, 0, false, 0, 0, 0},
        {"64 pixels of a slope, noise estimated", "4,4,8,8", "50,20,8,8", 4, 0, false, 0, 0, 0},
        {"64 textured pixels, noise estimated", "4,4,8,8", "50,20,8,8", 1, 2, false, 0, 0, 0},
        {"100 pixels, noise estimated", "4,4,10,10", "50,20,10,10", 0, 0, false, 0, 0, 0},
        {"256 pixels, noise estimated", "4,4,16,16", "50,20,16,16", 0, 0, false, 0, 0, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof sceneries / sizeof sceneries[0]; ++i)
        check_coverage(sceneries + i);
}

/*
 * The error of the render, of some samples a pixel, is in none of the figures, but in their
 * uncertainties. `camera` -1 is none at all. A signal as fine as the lens' blur is spread by less
 * than is said, so there is none here.
 */
static void test_coverage_with_render(void **state) {
    static const char left[] = "2,5,36,50", right[] = "42,10,36,40";
    static const scenery sceneries[] = {
        {"textured, render alone", polygon, "30,10,40,40", 1, 12, true, -1, 2, 0},
        {"textured, more error than texture", left, right, 1, 12, true, -1, 8, 0},
        {"even, error 1/4 of the noise", left, right, 0, 0, true, 3, 1.5, 0},
        {"even, error as the noise", left, right, 0, 0, true, 3, 3, 0},
        {"even, error twice the noise", left, right, 0, 0, true, 3, 6, 0},
        {"even, error three times the noise", left, right, 0, 0, true, 3, 9, 0},
        {"shaded, error as the noise", left, right, 1, 0, true, 3, 3, 0},
        {"even, blurred", "12,12,24,36", "44,12,24,36", 0, 0, true, 3, 6, 8},
        {"shaded, blurred", "12,12,24,36", "44,12,24,36", 1, 0, true, 3, 6, 8},
        {"even, noise estimated", left, right, 0, 0, false, 3, 3, 0},
        {"even, blurred, noise estimated", "12,12,24,36", "44,12,24,36", 0, 0, false, 3, 3, 8},
        {"144 pixels, error as the noise", "4,4,12,12", "50,20,12,12", 0, 0, true, 3, 3, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof sceneries / sizeof sceneries[0]; ++i)
        check_coverage(sceneries + i);
}

/* One pixel has a mean, and nothing else. */
static void test_one_pixel(void **state) {
    mcv_readings r = make();
    (void)state;
    for (size_t i = 0; i < PLANE; ++i) {
        r.values.pixels[i] = 7;
        r.deviation.pixels[i] = 0.5F;
    }
    mcv_roi region = parse(&r, "3,4,1,1");
    const mcv_roi_figures f = mcv_roi_measure(&r, &region);
    assert_true(f.mean.value == 7 && f.mean.uncertainty == 0.5);
    assert_true(isnan(f.deviation.value) && isnan(f.rms_contrast.value) && isnan(f.snr.value) &&
                isnan(f.uniformity.value));
    mcv_roi_free(&region);
    release(&r);
}

/* The median of N = 4500 differences, of which some twelve share noise, has a standard error of
 * about 1.2 √(12/N) = 6 % at most; 8 % allowed. */
static void test_noise_estimate(void **state) {
    mcv_readings r = make();
    mcv_roi region = parse(&r, "0,0,80,60");
    (void)state;
    for (uint32_t i = 0; i < PLANE; ++i) {
        mcv_noise noise = mcv_noise_begin(5, 0, i);
        const double x = i % WIDTH;
        r.values.pixels[i] =
            (float)(50 + x + 0.02 * x * x + (x > 33 ? 100 : 0) + 4 * mcv_noise_normal(&noise));
    }
    const double found = mcv_roi_estimate_noise(&r, &region, 0);
    if (fabs(found / 4 - 1) > 0.08) fail_msg("noise of 4 is estimated as %g", found);
    assert_true(r.deviation.pixels[100] == (float)found);
    for (uint32_t i = 0; i < PLANE; ++i) r.values.pixels[i] = 7;
    assert_true(mcv_roi_estimate_noise(&r, &region, 0.25) == 0.25);
    mcv_roi_free(&region);
    mcv_roi narrow = parse(&r, "0,0,80,2");
    assert_true(isnan(mcv_roi_estimate_noise(&r, &narrow, 0)));
    mcv_roi_free(&narrow);
    release(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_belongs), cmocka_unit_test(test_bad_regions),
        cmocka_unit_test(test_coverage),     cmocka_unit_test(test_coverage_with_render),
        cmocka_unit_test(test_one_pixel),    cmocka_unit_test(test_noise_estimate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
