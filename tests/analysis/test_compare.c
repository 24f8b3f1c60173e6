/* SPDX-License-Identifier: Apache-2.0 */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/compare.h"
#include "analysis/statistics.h"
#include "io/colormap.h"

static void expect_near(double value, double expected, double relative, const char *what) {
    if (!(fabs(value - expected) <= relative * fabs(expected))) {
        fail_msg("%s is %.17g instead of %.17g: off by %.2g, allowed %.2g", what, value, expected,
                 value / expected - 1, relative);
    }
}

static void test_incomplete_beta(void **state) {
    (void)state;
    /* Closed forms: I_x(a, 1) = x^a, I_x(1, b) = 1 - (1-x)^b, I_x(1/2, 1/2) = 2/π asin √x, I_x(2,
     * 3) = 6x² - 8x³ + 3x⁴. */
    for (int i = 1; i < 20; ++i) {
        const double x = i / 20.0;
        expect_near(mcv_incomplete_beta(3.5, 1, x), pow(x, 3.5), 1e-13, "I_x(3.5, 1)");
        expect_near(mcv_incomplete_beta(1, 7, x), 1 - pow(1 - x, 7), 1e-13, "I_x(1, 7)");
        expect_near(mcv_incomplete_beta(0.5, 0.5, x), 2 / acos(-1) * asin(sqrt(x)), 1e-13,
                    "I_x(1/2, 1/2)");
        expect_near(mcv_incomplete_beta(2, 3, x), x * x * (6 + x * (-8 + 3 * x)), 1e-13,
                    "I_x(2, 3)");
    }
    assert_true(mcv_incomplete_beta(2, 3, 0) == 0 && mcv_incomplete_beta(2, 3, 1) == 1);
}

static void test_student(void **state) {
    (void)state;
    /* Freedom 1 is the Cauchy distribution, 2 has p = 1 - t/√(2 + t²), 4 a closed form too. */
    for (int i = 0; i < 13; ++i) {
        const double t = 0.01 * pow(3, i);
        expect_near(mcv_student_two_sided(t, 1), 2 / acos(-1) * atan(1 / t), 1e-12,
                    "p for freedom 1");
        expect_near(mcv_student_two_sided(-t, 2), 2 / (2 + t * t + t * sqrt(2 + t * t)), 1e-12,
                    "p for freedom 2");
    }
    /* Tabulated quantiles, to the digits printed (half a unit of the last). */
    const struct {
        double p, freedom, t, digits;
    } table[] = {{0.05, 3, 3.182446, 5e-7},  {0.05, 15, 2.131450, 5e-7},
                 {0.01, 7, 3.499483, 5e-7},  {0.001, 30, 3.645959, 5e-7},
                 {0.10, 5, 2.015048, 5e-7},  {0.01, 120, 2.617421, 5e-7},
                 {0.05, 1e7, 1.959964, 1e-6}};
    for (size_t i = 0; i < sizeof table / sizeof table[0]; ++i) {
        const double t = mcv_student_quantile(table[i].p, table[i].freedom);
        if (fabs(t - table[i].t) > table[i].digits)
            fail_msg("t(%g, %g) is %.8f instead of %.6f", table[i].p, table[i].freedom, t,
                     table[i].t);
        /* The quantile is one of neighbouring numbers; lgamma's error at 1e7 is the largest. */
        expect_near(mcv_student_two_sided(t, table[i].freedom), table[i].p, 1e-6,
                    "p of its quantile");
    }
    assert_true(mcv_student_two_sided(0, 5) == 1);
    assert_true(mcv_student_two_sided(INFINITY, 5) == 0);
}

static void test_counting_distributions(void **state) {
    (void)state;
    expect_near(mcv_binomial_upper(2, 3, 0.5), 0.5, 1e-13, "P(X >= 2) of 3 coins");
    expect_near(mcv_binomial_upper(1, 100, 0.01), 1 - pow(0.99, 100), 1e-12, "P(X >= 1) of 100");
    assert_true(mcv_binomial_upper(0, 100, 0.01) == 1);
    /* Mann-Whitney: 1, 2, 4, 7, 12 of the 252 orders of 5 and 5 have U <= 0 … 4; all 16 below all
     * 16: one of 32 choose 16. */
    const double cumulative[] = {1, 2, 4, 7, 12};
    double *five = mcv_mann_whitney(5, 5), *sixteen = mcv_mann_whitney(16, 16),
           *uneven = mcv_mann_whitney(3, 1);
    for (int u = 0; u < 5; ++u)
        expect_near(five[u], cumulative[u] / 252, 1e-14, "P(U <= u) of 5 and 5");
    expect_near(five[12], 0.5, 1e-14, "P(U <= 12) of 5 and 5");
    expect_near(sixteen[0], 1.0 / 601080390, 1e-13, "P(U = 0) of 16 and 16");
    for (int u = 0; u < 4; ++u)
        expect_near(uneven[u], (u + 1) / 4.0, 1e-14, "P(U <= u) of 3 and 1");
    free(five);
    free(sixteen);
    free(uneven);
    expect_near(mcv_sidak(1e-9, 1e6), 1e-3, 1e-3, "Šidák's p"); /* 1 - exp(-1e-3) */
    double even[100];
    for (int i = 0; i < 100; ++i) even[i] = (99 - i + 0.5) / 100;
    expect_near(mcv_smaller_than_uniform(even, 100), exp(-2 * 100 * 0.005 * 0.005), 1e-9,
                "KS of even steps");
    for (int i = 0; i < 100; ++i) even[i] /= 2; /* D = 1/2 + 1/400 */
    expect_near(mcv_smaller_than_uniform(even, 100), exp(-2 * 100 * 0.5025 * 0.5025), 1e-9,
                "KS of halved steps");
}

static uint64_t random_bits(uint64_t *state) { /* SplitMix64 (Steele, Lea and Flood 2014) */
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static double uniform(uint64_t *state) {
    return ((double)(random_bits(state) >> 11) + 0.5) * 0x1p-53;
}

static double normal(uint64_t *state) {
    return sqrt(-2 * log(uniform(state))) * cos(2 * acos(-1) * uniform(state));
}

enum { NORMAL, EDGES, SPARSE, BURSTS };

/*
 * A film of noise around a gradient from 1 to 2, with 1 sample: NORMAL (SD 5 %); EDGES: most pixels
 * without noise, every fourth one a few counts of sixteenths, as low-discrepancy samples on an edge
 * give; SPARSE: exponential bursts in one of eight samples; BURSTS: 100 times the background in one
 * of 300, as caustics give.
 */
static mcv_film make_film(uint32_t width, uint32_t height, uint32_t channels, uint32_t replicates,
                          int kind, uint64_t seed) {
    mcv_film film;
    mcv_error error = {""};
    if (mcv_film_new(&film, width, height, channels, replicates, &error) != MCV_OK)
        fail_msg("%s", error.text);
    film.samples = 1;
    const size_t count = (size_t)width * height * channels * replicates;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t column = (uint32_t)(i % width);
        const double truth = 1 + (double)column / width;
        if (kind == NORMAL) {
            film.sums[i] = truth * (1 + 0.05 * normal(&seed));
        } else if (kind == EDGES) {
            const double place = 8 + 4 * sin(0.7 * column); /* where the edge runs, in samples */
            film.sums[i] = column % 4 ? 1 : floor(place + uniform(&seed)) / 16;
        } else if (kind == BURSTS) {
            film.sums[i] = truth * (1 + 0.01 * normal(&seed)) +
                           (uniform(&seed) < 1.0 / 300 ? -100 * log(uniform(&seed)) : 0);
        } else {
            film.sums[i] = uniform(&seed) < 0.125 ? -8 * truth * log(uniform(&seed)) : 0;
        }
    }
    return film;
}

static mcv_comparison compare(const mcv_film *x, const mcv_film *y) {
    mcv_comparison c;
    mcv_error error = {""};
    if (mcv_compare_films(x, y, &c, &error) != MCV_OK) fail_msg("%s", error.text);
    return c;
}

/* Of n independent p-values the smallest is at most p with the probability 1 - (1 - p)^n; for small
 * ones n p, without cancellation. */
static void test_sidak(void **state) {
    (void)state;
    assert_true(fabs(mcv_sidak(0.5, 2) - 0.75) < 1e-15);
    assert_true(fabs(mcv_sidak(0.1, 10) - (1 - pow(0.9, 10))) < 1e-14);
    assert_true(fabs(mcv_sidak(1e-20, 3) / 3e-20 - 1) < 1e-14);
    assert_true(mcv_sidak(1, 5) == 1 && mcv_sidak(0, 5) == 0);
}

/*
 * Pairs of the same distribution. The verdict: at most 4 x 2.5e-4 of them are rejected, so that of
 * 300 pairs more than 3 are with a probability of 3e-4 (Poisson, 0.3). The p-values: p <= 0.05 in
 * at most 5 % of the cases; 300 pairs give 15 ± 3.8, five SDs are 34. Those of the image test are
 * uniform with normal noise, so there are at least 2 (fewer: probability 5e-6, Poisson).
 */
static void test_equal_pictures_are_accepted(void **state) {
    (void)state;
    enum { PAIRS = 300 };
    const char *const names[] = {"normal", "edges", "sparse", "bursts"};
    for (int kind = NORMAL; kind <= BURSTS; ++kind) {
        for (uint32_t replicates = 4; replicates <= 16; replicates *= 4) {
            int rejected = 0, small[4] = {0};
            char reason[512] = "";
            for (int i = 0; i < PAIRS; ++i) {
                const uint64_t seed =
                    1000003u * (uint64_t)(2 * i + 1) + (uint64_t)kind * 77 + replicates;
                mcv_film x = make_film(36, 32, 1, replicates, kind, seed << 20),
                         y = make_film(36, 32, 1, replicates, kind, seed << 20 ^ 0xabcdef);
                const mcv_comparison c = compare(&x, &y);
                rejected += c.different;
                if (c.different) snprintf(reason, sizeof reason, "%s", c.reason);
                small[0] += c.p_unit <= 0.05;
                small[1] += c.p_tiles <= 0.05;
                small[2] += c.p_count <= 0.05;
                small[3] += c.p_image <= 0.05;
                mcv_film_free(&x);
                mcv_film_free(&y);
            }
            print_message("%s, %u replicates: %d of %d rejected, p <= 0.05: unit %d, tiles %d, "
                          "count %d, image %d\n",
                          names[kind], replicates, rejected, PAIRS, small[0], small[1], small[2],
                          small[3]);
            if (rejected > 3)
                fail_msg("%s noise, %u replicates: %d of %d equal pairs rejected: %s", names[kind],
                         replicates, rejected, PAIRS, reason);
            for (int t = 0; t < 4; ++t) {
                if (small[t] > 34)
                    fail_msg(
                        "%s noise, %u replicates: test %d has p <= 0.05 in %d of %d equal pairs",
                        names[kind], replicates, t, small[t], PAIRS);
            }
            if (kind == NORMAL && small[3] < 2)
                fail_msg("image p-values are too large: %d of %d below 0.05", small[3], PAIRS);
        }
    }
}

/* Errors that each have to be found by the test meant for them, in all of ten seeds, far above what
 * is detectable. */
static void test_planted_errors_are_rejected(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 10; ++seed) {
        const mcv_film x = make_film(64, 64, 3, 16, NORMAL, seed);
        mcv_film y = make_film(64, 64, 3, 16, NORMAL, seed + 100);
        const size_t plane = (size_t)64 * 64, values = plane * 16 * 3;
        mcv_comparison c = compare(&x, &y);
        if (c.different) fail_msg("seed %d: equal pictures rejected: %s", (int)seed, c.reason);
        /* The image mean of 16 x 4096 samples of 5 % noise: SE 1.6 √2 0.05/256; times about 3.7
         * + 1.3 that is 0.1 %. */
        assert_true(c.detectable > 0.0005 && c.detectable < 0.002);

        for (size_t i = 0; i < values; ++i) y.sums[i] *= 1.01; /* 1 % more radiance */
        c = compare(&x, &y);
        if (!(c.different && c.p_image < MCV_COMPARE_ALPHA))
            fail_msg("seed %d: 1 %% more radiance is accepted: %s", (int)seed, c.reason);
        assert_non_null(strstr(c.reason, "image means"));
        for (size_t i = 0; i < values; ++i) y.sums[i] /= 1.01;

        const size_t at = (size_t)10 * 64 + 20;
        /* A single pixel in the second channel: 30 % of 5 %/√16 √2 is 17 SDs. */
        for (size_t r = 0; r < 16; ++r) y.sums[(r * 3 + 1) * plane + at] *= 1.3;
        c = compare(&x, &y);
        if (!(c.different && c.p_unit < MCV_COMPARE_ALPHA))
            fail_msg("seed %d: a wrong pixel is accepted: %s", (int)seed, c.reason);
        assert_int_equal(c.worst.channel, 1);
        assert_true(c.worst.column == 20 && c.worst.row == 10 && c.worst.width == 1);
        for (size_t r = 0; r < 16; ++r) y.sums[(r * 3 + 1) * plane + at] /= 1.3;

        /* A pattern without mean and in no tile beyond doubt: ± 0.25 %, a tile's SD being 0.05/√(16
         * x 64 x 3) √2 = 0.13 %. */
        for (size_t i = 0; i < values; ++i)
            y.sums[i] *= (i % 64 / 8 + i % plane / 64 / 8) % 2 ? 1.0025 : 0.9975;
        c = compare(&x, &y);
        if (!(c.different && fmin(c.p_tiles, c.p_count) < MCV_COMPARE_ALPHA))
            fail_msg("seed %d: a chequered error is accepted: %s", (int)seed, c.reason);
        mcv_film_free(&y);
        mcv_film image = x;
        mcv_film_free(&image);
    }
}

/* Where there is no noise there is nothing to wait for: equal is equal up to rounding, different is
 * different. */
static void test_pictures_without_noise(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_film x, y;
    assert_int_equal(mcv_film_new(&x, 20, 10, 1, 4, &error), MCV_OK);
    assert_int_equal(mcv_film_new(&y, 20, 10, 1, 4, &error), MCV_OK);
    x.samples = y.samples = 1;
    mcv_comparison c = compare(&x, &y); /* black */
    assert_false(c.different);
    for (int i = 0; i < 800; ++i) {
        x.sums[i] = 0.7;
        y.sums[i] = 0.7f;
    }
    c = compare(&x, &y); /* float32's rounding of 0.7 is 2e-8 */
    assert_false(c.different);
    c = compare(&x, &x);
    assert_false(c.different);
    for (int i = 0; i < 800; ++i) y.sums[i] = 0.7 * 1.00001;
    c = compare(&x, &y);
    assert_true(c.different && c.p_image == 0);
    assert_non_null(strstr(c.reason, "0.001 %"));
    mcv_film_free(&x);
    mcv_film_free(&y);
    x = make_film(16, 16, 3, 4, NORMAL, 1);
    c = compare(&x, &x); /* a picture equals itself */
    assert_false(c.different);
    mcv_film_free(&x);
}

static mcv_measured measure(const mcv_film *film, mcv_image *mean, mcv_image *deviation) {
    mcv_error error = {""};
    if (mcv_film_develop(film, mean, deviation, &error) != MCV_OK) fail_msg("%s", error.text);
    return (mcv_measured){.mean = mean, .error = deviation, .replicates = film->replicates};
}

/* The way over mean and error images: same bounds as above, for 100 pairs (5 ± 2.2 below 0.05, five
 * SDs: 16; 2 rejected: 5e-3, 4: 4e-6). */
static void test_images_with_errors(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_comparison c;
    int rejected = 0, small[4] = {0};
    for (uint64_t seed = 1; seed <= 100; ++seed) {
        mcv_film x = make_film(36, 32, 3, 8, NORMAL, seed << 8),
                 y = make_film(36, 32, 3, 8, NORMAL, seed << 8 ^ 0xff0000);
        mcv_image images[4];
        const mcv_measured mx = measure(&x, &images[0], &images[1]),
                           my = measure(&y, &images[2], &images[3]);
        assert_int_equal(mcv_compare_images(&mx, &my, &c, &error), MCV_OK);
        rejected += c.different;
        small[0] += c.p_unit <= 0.05;
        small[1] += c.p_tiles <= 0.05;
        small[2] += c.p_count <= 0.05;
        small[3] += c.p_image <= 0.05;
        if (seed == 1) {
            /* A border that is NaN in both is left out; in one alone it is a difference. */
            images[0].pixels[5] = NAN;
            assert_int_equal(mcv_compare_images(&mx, &my, &c, &error), MCV_OK);
            assert_true(c.different);
            assert_non_null(strstr(c.reason, "column 5, row 0"));
            images[2].pixels[5] = NAN;
            assert_int_equal(mcv_compare_images(&mx, &my, &c, &error), MCV_OK);
            if (c.different) fail_msg("%s", c.reason);
            for (int i = 0; i < 3 * 36 * 32; ++i) images[2].pixels[i] *= 1.01f;
            assert_int_equal(mcv_compare_images(&mx, &my, &c, &error), MCV_OK);
            assert_true(c.different && c.p_image < MCV_COMPARE_ALPHA);
        }
        for (int i = 0; i < 4; ++i) mcv_image_free(&images[i]);
        mcv_film_free(&x);
        mcv_film_free(&y);
    }
    print_message("images: %d of 100 rejected, p <= 0.05: unit %d, tiles %d, count %d, image %d\n",
                  rejected, small[0], small[1], small[2], small[3]);
    assert_true(rejected < 3);
    for (int t = 0; t < 4; ++t) assert_true(small[t] <= 16);
}

static void test_what_cannot_be_compared(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_comparison c;
    mcv_film x = make_film(8, 8, 1, 4, NORMAL, 1), y = make_film(8, 9, 1, 4, NORMAL, 1),
             one = make_film(8, 8, 1, 1, NORMAL, 1);
    assert_int_equal(mcv_compare_films(&x, &y, &c, &error), MCV_BAD_INPUT);
    assert_non_null(strstr(error.text, "8 x 9"));
    assert_int_equal(mcv_compare_films(&x, &one, &c, &error), MCV_BAD_INPUT);
    assert_non_null(strstr(error.text, "4 and 1 replicates"));
    x.samples = 0;
    assert_int_equal(mcv_compare_films(&x, &x, &c, &error), MCV_FAILED);
    mcv_film_free(&x);
    mcv_film_free(&y);
    mcv_film_free(&one);
}

/*
 * An edge of 32 pixels half covered: each of 4 replicates counts 7 or 8 of 16 samples, whose
 * weights differ by 1e-6. In one pixel of 128 all replicates of one picture count 7, all of the
 * other one 8; some pixel is such a one in 97 % of 15 pairs.
 */
static void test_edges_with_replicates_alike(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_comparison c;
    int alike = 0;
    for (uint64_t seed = 1; seed <= 15; ++seed) {
        mcv_film films[2];
        mcv_image images[4];
        mcv_measured sides[2];
        for (uint64_t s = 0; s < 2; ++s) {
            films[s] = make_film(32, 32, 1, 4, NORMAL, seed << 8 | s);
            films[s].samples = 16;
            for (int i = 0; i < 4 * 32 * 32; ++i) {
                const double chance = films[s].sums[i],
                             covered = i % 32 == 16  ? 7 + fmod(floor(1e6 * fabs(chance)), 2)
                                       : i % 32 < 16 ? 0
                                                     : 16;
                films[s].sums[i] = covered * (1 + 1e-6 * fmod(1e3 * fabs(chance), 1));
            }
            sides[s] = measure(&films[s], &images[2 * s], &images[2 * s + 1]);
        }
        for (int row = 0; row < 32; ++row) {
            const int i = 32 * row + 16;
            const float deviation = hypotf(images[1].pixels[i], images[3].pixels[i]);
            alike += fabsf(images[0].pixels[i] - images[2].pixels[i]) > 1000 * deviation;
        }
        assert_int_equal(mcv_compare_images(&sides[0], &sides[1], &c, &error), MCV_OK);
        if (c.different) fail_msg("pair %d of equal pictures: %s", (int)seed, c.reason);
        for (int i = 0; i < 4; ++i) mcv_image_free(&images[i]);
        for (int s = 0; s < 2; ++s) mcv_film_free(&films[s]);
    }
    print_message("edges: %d pixels with replicates alike that differ\n", alike);
    assert_true(alike > 0);
}

/* By hand: (4 - 1)/√(0.3² + 0.4²) = 6, of two channels (2 + 1)/√(0.6² + 0.8²) = 3; what has no
 * error is infinite, what is no number NaN. */
static void test_difference_in_standard_errors(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_image difference;
    float x[] = {4, 1, 2, NAN}, ex[] = {0.3F, 0.3F, 0, 0}, y[] = {1, 1, 3, 1},
          ey[] = {0.4F, 0, 0, 0};
    mcv_image images[] = {
        {4, 1, 1, x, NULL}, {4, 1, 1, ex, NULL}, {4, 1, 1, y, NULL}, {4, 1, 1, ey, NULL}};
    const mcv_measured mx = {&images[0], &images[1], 4}, my = {&images[2], &images[3], 4};
    assert_int_equal(mcv_compare_difference(&mx, &my, &difference, &error), MCV_OK);
    expect_near(difference.pixels[0], 6, 0x1p-22, "the difference"); /* four roundings to float */
    assert_true(difference.pixels[1] == 0 && difference.pixels[2] == -INFINITY &&
                isnan(difference.pixels[3]));
    mcv_image_free(&difference);

    float x2[] = {3, 5}, ex2[] = {0.3F, 0.3F}, y2[] = {1, 4}, ey2[] = {0.4F, 0.4F};
    mcv_image two[] = {
        {1, 1, 2, x2, NULL}, {1, 1, 2, ex2, NULL}, {1, 1, 2, y2, NULL}, {1, 1, 2, ey2, NULL}};
    const mcv_measured mx2 = {&two[0], &two[1], 4}, my2 = {&two[2], &two[3], 4};
    assert_int_equal(mcv_compare_difference(&mx2, &my2, &difference, &error), MCV_OK);
    expect_near(difference.pixels[0], 3, 0x1p-22, "the difference of two channels");
    mcv_image_free(&difference);
    assert_int_equal(mcv_compare_difference(&mx, &my2, &difference, &error), MCV_BAD_INPUT);

    /* Its colours: blue and red ends, white in the middle. */
    assert_int_equal(mcv_colormap_rgb(MCV_COLORMAP_DIVERGING, 0.5), 0xffffff);
    assert_int_equal(mcv_colormap_rgb(MCV_COLORMAP_DIVERGING, -1), 0x1e4ba5);
    assert_int_equal(mcv_colormap_rgb(MCV_COLORMAP_DIVERGING, 2), 0xaf1928);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_incomplete_beta),
        cmocka_unit_test(test_student),
        cmocka_unit_test(test_counting_distributions),
        cmocka_unit_test(test_sidak),
        cmocka_unit_test(test_equal_pictures_are_accepted),
        cmocka_unit_test(test_planted_errors_are_rejected),
        cmocka_unit_test(test_pictures_without_noise),
        cmocka_unit_test(test_images_with_errors),
        cmocka_unit_test(test_edges_with_replicates_alike),
        cmocka_unit_test(test_what_cannot_be_compared),
        cmocka_unit_test(test_difference_in_standard_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
