/* SPDX-License-Identifier: Apache-2.0 */
#include "test.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "film/film.h"

/* A value whose sum depends on the order of adding: uniform bits, exponents spread over 2^±64, far
 * more than a double holds. */
static double scattered(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return ldexp((double)(*state >> 8) / 16777216.0 - 0.25, (int)(*state >> 25) - 64);
}

static void test_tree_sum_is_the_same_for_every_split(void **state) {
    (void)state;
    enum { COUNT = 1024, STRIDE = 3 };
    static double values[COUNT * STRIDE];
    uint32_t seed = 1;
    double in_order = 0;
    for (int i = 0; i < COUNT * STRIDE; ++i) values[i] = scattered(&seed);
    for (size_t i = 0; i < COUNT; ++i) in_order += values[i * STRIDE];
    const double whole = mcv_pairwise_sum(values, COUNT, STRIDE);
    /* Any order is within n u of the sum of magnitudes; the data are such that the bits do differ,
     * else the test says nothing. */
    assert_true(whole != in_order);
    for (size_t block = 1; block <= COUNT; block *= 2) {
        double blocks[COUNT];
        for (size_t i = 0; i < COUNT / block; ++i)
            blocks[i] = mcv_pairwise_sum(values + i * block * STRIDE, block, STRIDE);
        const double sum = mcv_pairwise_sum(blocks, COUNT / block, 1);
        if (sum != whole) fail_msg("blocks of %zu: %.17g instead of %.17g", block, sum, whole);
    }
}

static void test_merge_of_rounds_equals_the_whole(void **state) {
    (void)state;
    enum { SAMPLES = 64, REPLICATES = 4, PIXELS = 6 };
    static double values[REPLICATES * PIXELS * SAMPLES];
    uint32_t seed = 2;
    for (int i = 0; i < REPLICATES * PIXELS * SAMPLES; ++i) values[i] = scattered(&seed);

    mcv_error error = {""};
    mcv_film film;
    assert_int_equal(mcv_film_new(&film, 3, 2, 1, REPLICATES, &error), MCV_OK);
    /* Rounds as a renderer makes them: [0, 1), [1, 2), [2, 4), [4, 8) … */
    for (size_t first = 0; first < SAMPLES; first = first ? 2 * first : 1) {
        const size_t count = first ? first : 1;
        mcv_film round;
        assert_int_equal(mcv_film_new(&round, 3, 2, 1, REPLICATES, &error), MCV_OK);
        round.samples = count;
        for (int i = 0; i < REPLICATES * PIXELS; ++i)
            round.sums[i] = mcv_pairwise_sum(values + (size_t)i * SAMPLES + first, count, 1);
        assert_int_equal(mcv_film_merge(&film, &round, &error), MCV_OK);
        mcv_film_free(&round);
    }
    assert_int_equal(film.samples, SAMPLES);
    for (int i = 0; i < REPLICATES * PIXELS; ++i) {
        const double whole = mcv_pairwise_sum(values + (size_t)i * SAMPLES, SAMPLES, 1);
        if (film.sums[i] != whole)
            fail_msg("place %d: %.17g instead of %.17g", i, film.sums[i], whole);
    }
    mcv_film_free(&film);
}

/* What light paths bring counts beside the camera paths' sums, in its unit, and films are merged
 * with it. */
static void test_splats_are_added(void **state) {
    (void)state;
    const double camera[2] = {3, 5};
    mcv_error error = {""};
    mcv_film films[2];
    for (int i = 0; i < 2; ++i) {
        assert_int_equal(mcv_film_new(&films[i], 1, 1, 1, 2, &error), MCV_OK);
        assert_int_equal(mcv_film_take_splats(&films[i], 0.25, &error), MCV_OK);
        films[i].splats[0] = 4, films[i].splats[1] = 6;
        mcv_film_add(&films[i], camera, 8);
    }
    assert_true(films[0].sums[0] == 4 && films[0].sums[1] == 6.5);
    /* Only films of as many samples are merged. */
    assert_int_equal(mcv_film_merge(&films[0], &films[1], &error), MCV_OK);
    assert_int_equal(films[0].samples, 16);
    assert_true(films[0].sums[0] == 8 && films[0].sums[1] == 13);
    for (int i = 0; i < 2; ++i) mcv_film_free(&films[i]);
}

static void test_merge_refuses_what_does_not_fit(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_film a, b;
    assert_int_equal(mcv_film_new(&a, 2, 2, 1, 4, &error), MCV_OK);
    assert_int_equal(mcv_film_new(&b, 2, 3, 1, 4, &error), MCV_OK);
    assert_int_equal(mcv_film_merge(&a, &b, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "2 x 3"));
    mcv_film_free(&b);
    assert_int_equal(mcv_film_new(&b, 2, 2, 1, 4, &error), MCV_OK);
    a.samples = 8;
    b.samples = 4;
    assert_int_equal(mcv_film_merge(&a, &b, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "8 and 4 samples"));
    mcv_film_free(&a);
    mcv_film_free(&b);
}

static void test_develop_gives_mean_and_standard_error(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_film film;
    assert_int_equal(mcv_film_new(&film, 2, 1, 1, 4, &error), MCV_OK);
    film.samples = 2;
    /* Replicate means 1 2 3 4: mean 2.5, variance 5/3 with 3 degrees of freedom, SE = √(5/12). The
     * other pixel is 3 without error. */
    for (size_t r = 0; r < 4; ++r) {
        film.sums[2 * r] = 2 * ((double)r + 1);
        film.sums[2 * r + 1] = 6;
    }
    mcv_image mean, standard_error;
    assert_int_equal(mcv_film_develop(&film, &mean, &standard_error, &error), MCV_OK);
    assert_true(mean.pixels[0] == 2.5f && mean.pixels[1] == 3.0f);
    /* One rounding to float and few in double. */
    assert_true(fabs(standard_error.pixels[0] - sqrt(5.0 / 12.0)) <= FLT_EPSILON);
    assert_true(standard_error.pixels[1] == 0.0f);
    /* √((5/12 + 0) / 2) / 2.75; about ten roundings in double. */
    const double expected = sqrt(5.0 / 24.0) / 2.75;
    assert_true(fabs(mcv_film_relative_error(&film) - expected) <= 10 * DBL_EPSILON * expected);
    assert_true(fabs(mcv_film_mean(&film) - 2.75) <= 10 * DBL_EPSILON * 2.75);
    mcv_image_free(&mean);
    mcv_image_free(&standard_error);
    mcv_film_free(&film);
}

/* 40 pixels whose two replicates are 1 ± d: d is the standard error, and the mean is 1. Without the
 * 16 largest, in any order, the sum of squares is that of the other 24. A single replicate and a
 * black image are as for all pixels. */
static void test_error_without_the_worst(void **state) {
    enum { PIXELS = 40 };
    mcv_error error = {""};
    mcv_film film;
    double squares = 0;
    (void)state;
    assert_int_equal(mcv_film_new(&film, PIXELS, 1, 1, 2, &error), MCV_OK);
    film.samples = 1;
    for (int i = 0; i < PIXELS; ++i) {
        const int rank = i * 17 % PIXELS; /* each of 0 to 39, once */
        const double d = rank / 64.0;
        film.sums[i] = 1 + d;
        film.sums[PIXELS + i] = 1 - d;
        if (rank < PIXELS - MCV_FILM_WORST) squares += d * d;
    }
    const double expected = sqrt(squares / PIXELS);
    assert_true(fabs(mcv_film_error_of_rest(&film) - expected) <= 1e-13 * expected);
    for (int i = 0; i < PIXELS; ++i) film.sums[i] = film.sums[PIXELS + i] = i < 5 ? 2 : 1;
    film.sums[7] = 3;
    assert_true(mcv_film_relative_error(&film) > 0 && mcv_film_error_of_rest(&film) == 0);
    mcv_film_free(&film);
    assert_int_equal(mcv_film_new(&film, PIXELS, 1, 1, 1, &error), MCV_OK);
    film.samples = 1;
    film.sums[0] = 1;
    assert_true(isnan(mcv_film_error_of_rest(&film)));
    mcv_film_free(&film);
}

static void test_develop_at_the_edges(void **state) {
    (void)state;
    mcv_error error = {""};
    mcv_film film;
    mcv_image mean, standard_error;
    assert_int_equal(mcv_film_new(&film, 1, 1, 1, 1, &error), MCV_OK);
    assert_int_equal(mcv_film_develop(&film, &mean, NULL, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "no samples"));
    film.samples = 1;
    film.sums[0] = 5;
    assert_int_equal(mcv_film_develop(&film, &mean, &standard_error, &error), MCV_OK);
    assert_true(mean.pixels[0] == 5.0f && isnan(standard_error.pixels[0]) &&
                isnan(mcv_film_relative_error(&film)));
    mcv_image_free(&mean);
    mcv_image_free(&standard_error);
    mcv_film_free(&film);

    assert_int_equal(mcv_film_new(&film, 1, 1, 1, 2, &error), MCV_OK);
    film.samples = 1;
    assert_true(mcv_film_relative_error(&film) == 0);
    film.sums[0] = 1;
    film.sums[1] = -1;
    assert_true(isinf(mcv_film_relative_error(&film)));
    mcv_film_free(&film);

    assert_int_equal(mcv_film_new(&film, 0, 4, 1, 4, &error), MCV_USAGE);
    assert_int_equal(mcv_film_new(&film, 4, 4, 1, MCV_MAX_REPLICATES + 1, &error), MCV_USAGE);
    assert_int_equal(mcv_film_new(&film, UINT32_MAX, UINT32_MAX, 3, 4, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "GB"));
    assert_null(film.sums);
}

/*
 * The standard error is right when (mean - truth)/SE follows Student's t with R - 1 = 3 degrees of
 * freedom: |t| < 3.1824 in 95 % of all pixels.
 */
static void test_standard_error_covers_the_truth(void **state) {
    (void)state;
    enum { PIXELS = 20000, REPLICATES = 4 };
    mcv_error error = {""};
    mcv_film film;
    assert_int_equal(mcv_film_new(&film, PIXELS, 1, 1, REPLICATES, &error), MCV_OK);
    film.samples = 1;
    uint64_t bits = 88172645463325252u;
    for (int i = 0; i < PIXELS * REPLICATES; ++i) {
        double normal = -6; /* the sum of twelve uniforms less 6: variance 1, near enough to normal
                               for the bound below */
        for (int k = 0; k < 12; ++k) {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            normal += (double)(bits >> 11) * 0x1p-53;
        }
        film.sums[i] = 10 + normal;
    }
    mcv_image mean, standard_error;
    assert_int_equal(mcv_film_develop(&film, &mean, &standard_error, &error), MCV_OK);
    int covered = 0;
    for (int i = 0; i < PIXELS; ++i)
        covered += fabs(mean.pixels[i] - 10.0) < 3.1824 * standard_error.pixels[i];
    /* Binomial: SD √(0.95 0.05 / 20000) = 0.0015; five of them. The normal quantile 1.96 would give
     * 0.855. */
    const double share = (double)covered / PIXELS;
    if (fabs(share - 0.95) > 0.0077)
        fail_msg("the 95 %% interval covers the truth in %.2f %% of %d pixels", 100 * share,
                 PIXELS);
    mcv_image_free(&mean);
    mcv_image_free(&standard_error);
    mcv_film_free(&film);
}

/*
 * Two replicates, three channels: in the first pixel all are off by the same cause, in the second
 * only two, against each other. Covariances of pairs (deviations 1, 2, 3): 2 + 3 + 6 = 11, and -2
 * of (1, 2, 0); products 11 and 2. Each replicate is off to the other side.
 */
static void test_channels_share_their_error(void **state) {
    static const double off[2][3] = {{1, 2, 3}, {1, -2, 0}};
    mcv_film film, grey;
    mcv_error error = {""};
    (void)state;
    assert_int_equal(mcv_film_new(&film, 2, 1, 3, 2, &error), MCV_OK);
    film.samples = 1;
    assert_true(mcv_film_channel_correlation(&film) == 1); /* no error at all */
    for (int r = 0; r < 2; ++r)
        for (int c = 0; c < 3; ++c)
            for (int i = 0; i < 2; ++i)
                film.sums[(r * 3 + c) * 2 + i] = 10 + (r ? 1 : -1) * off[i][c];
    const double found = mcv_film_channel_correlation(&film);
    if (fabs(found - (11.0 - 2) / (11 + 2)) > 1e-12) fail_msg("correlation %.17g", found);
    /* Channels that are multiples of each other correlate by 1, and rounding adds nothing to that:
     * files with more are refused. */
    for (int k = 0; k < 1000; ++k) {
        for (int i = 0; i < 2 * 3 * 2; ++i)
            film.sums[i] = (1 + 0.7 * (i / 2 % 3)) * (1 + sin(k + 2 * (i / 6) + i % 2));
        const double shared = mcv_film_channel_correlation(&film);
        if (!(shared <= 1 && shared > 1 - 1e-12)) fail_msg("film %d: correlation %.17g", k, shared);
    }
    mcv_film_free(&film);
    assert_int_equal(mcv_film_new(&grey, 2, 1, 1, 2, &error), MCV_OK);
    grey.sums[0] = 1;
    assert_true(mcv_film_channel_correlation(&grey) == 1);
    mcv_film_free(&grey);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_tree_sum_is_the_same_for_every_split),
        cmocka_unit_test(test_merge_of_rounds_equals_the_whole),
        cmocka_unit_test(test_splats_are_added),
        cmocka_unit_test(test_merge_refuses_what_does_not_fit),
        cmocka_unit_test(test_develop_gives_mean_and_standard_error),
        cmocka_unit_test(test_channels_share_their_error),
        cmocka_unit_test(test_error_without_the_worst),
        cmocka_unit_test(test_develop_at_the_edges),
        cmocka_unit_test(test_standard_error_covers_the_truth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
