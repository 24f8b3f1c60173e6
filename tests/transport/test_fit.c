/* SPDX-License-Identifier: Apache-2.0 */
/* Weights of emitters that make a wanted image, of made-up matrices whose best weights are known.
 */
#include "test.h"

#include "transport/fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 16, HEIGHT = 2, PIXELS = WIDTH * HEIGHT, MOST_LAMPS = 3, REPLICATES = 4 };

/*
 * The descent ends where the value of a quadratic is flat to the rounding of doubles: at a distance
 * of the root of 2^-52 in weights of the order of 1, times the root of the condition, below 100 for
 * these lamps.
 */
static const double flat = 1e-6;

static mcv_error error;

/* What a lamp brings to the pixel (x from -1 to 1, row) by a replicate. */
typedef double lamp_light(int lamp, double x, int row, int replicate);

static mcv_element_group groups[MOST_LAMPS];
static uint64_t begins[PIXELS + 1];
static uint32_t columns[PIXELS * MOST_LAMPS];
static double values[PIXELS * MOST_LAMPS];
static float replicates_of[PIXELS * MOST_LAMPS * REPLICATES];
static const float ones[MOST_LAMPS] = {1, 1, 1};

static double place(int column) { return (2 * column + 1.0) / WIDTH - 1; }

static mcv_matrix matrix_of(int lamps, lamp_light *light) {
    for (int e = 0; e < lamps; ++e)
        groups[e] = (mcv_element_group){.first = (uint32_t)e, .width = 1, .height = 1};
    for (int p = 0; p < PIXELS; ++p) {
        begins[p + 1] = (uint64_t)(p + 1) * (uint64_t)lamps;
        for (int e = 0; e < lamps; ++e) {
            const int i = p * lamps + e;
            columns[i] = (uint32_t)e;
            values[i] = 0;
            for (int r = 0; r < REPLICATES; ++r) {
                const double v = light(e, place(p % WIDTH), p / WIDTH, r);
                replicates_of[i * REPLICATES + r] = (float)v;
                values[i] += v / REPLICATES;
            }
        }
    }
    return (mcv_matrix){.width = WIDTH,
                        .height = HEIGHT,
                        .channels = 1,
                        .replicates = REPLICATES,
                        .kept = 1,
                        .groups = groups,
                        .group_count = (uint32_t)lamps,
                        .element_count = (uint32_t)lamps,
                        .column_count = (uint32_t)lamps,
                        .row_count = PIXELS,
                        .row_begins = begins,
                        .columns = columns,
                        .values = values,
                        .replicates_of = replicates_of};
}

static mcv_roi rows(int first, int count) {
    mcv_roi roi = {.width = WIDTH, .height = HEIGHT, .count = (uint64_t)count * WIDTH};
    roi.inside = calloc(PIXELS, 1);
    memset(roi.inside + (size_t)first * WIDTH, 1, (size_t)count * WIDTH);
    return roi;
}

static void expect(const char *what, const double *found, const double *expected, int count) {
    for (int e = 0; e < count; ++e)
        if (!(fabs(found[e] - expected[e]) <= flat))
            fail_msg("%s: weight %d is %.9g, must be %.9g", what, e, found[e], expected[e]);
}

static double mean_square(void) {
    double sum = 0;
    for (int i = 0; i < WIDTH; ++i) sum += place(i) * place(i) / WIDTH;
    return sum;
}

/* 1 + x and 2 (1 - x) make an even image together; x² disturbs it. */
static double crossed(int lamp, double x, int row, int replicate) {
    (void)row, (void)replicate;
    return lamp == 0 ? 1 + x : lamp == 1 ? 2 * (1 - x) : x * x;
}

/* Both rise, so that their difference would be best: the steeper one stays dark, the other one is
 * regressed, t mean(1 + x)/mean((1 + x)²). */
static double rising(int lamp, double x, int row, int replicate) {
    (void)row, (void)replicate;
    return 1 + (lamp + 1) * x / 2;
}

static void test_even_light(void **state) {
    double weights[MOST_LAMPS], errors[MOST_LAMPS];
    (void)state;
    mcv_roi all = rows(0, HEIGHT);
    mcv_matrix m = matrix_of(3, crossed);
    assert_int_equal(mcv_fit_uniform(&m, ones, &all, weights, errors, &error), MCV_OK);
    const double level = 3 + mean_square();
    expect("crossed", weights, (double[]){level / 2, level / 4, 0}, 3);
    for (int e = 0; e < 3; ++e) assert_true(errors[e] <= flat);
    m = matrix_of(2, rising);
    assert_int_equal(mcv_fit_uniform(&m, ones, &all, weights, errors, &error), MCV_OK);
    expect("rising", weights, (double[]){2 / (1 + mean_square() / 4), 0}, 2);
    free(all.inside);
}

/* Row 0 is the background: lamps 0 and 1 spread by 0.1 and 0.2 without correlation, and differ by 1
 * and 0.5 in row 1: weights as S⁻¹ d = (100, 12.5). Lamp 2 spreads alone. */
static double apart(int lamp, double x, int row, int replicate) {
    const int i = (int)lrint((x + 1) * WIDTH / 2 - 0.5);
    const double one = i % 2 ? 1 : -1, two = i / 2 % 2 ? 1 : -1, four = i / 4 % 2 ? 1 : -1;
    (void)replicate;
    if (lamp == 0) return row ? 2 : 1 + 0.1 * one;
    if (lamp == 1) return row ? 1.5 : 1 + 0.2 * two;
    return row ? 1 : 1 + 0.2 * four;
}

/* The same with the region darker than the background. */
static double darker(int lamp, double x, int row, int replicate) {
    const double light = apart(lamp, x, row, replicate);
    return row ? 2 - light : light;
}

static void test_contrast(void **state) {
    double weights[MOST_LAMPS], errors[MOST_LAMPS];
    (void)state;
    mcv_roi background = rows(0, 1), region = rows(1, 1);
    mcv_matrix m = matrix_of(3, apart);
    assert_int_equal(mcv_fit_contrast(&m, ones, &region, &background, weights, errors, &error),
                     MCV_OK);
    expect("brighter", weights, (double[]){1, 0.125, 0}, 3);
    m = matrix_of(3, darker);
    assert_int_equal(mcv_fit_contrast(&m, ones, &region, &background, weights, errors, &error),
                     MCV_OK);
    expect("darker", weights, (double[]){1, 0.125, 0}, 3);
    assert_int_equal(mcv_fit_contrast(&m, ones, &region, &region, weights, errors, &error),
                     MCV_BAD_INPUT);
    free(background.inside);
    free(region.inside);
}

/* Lamp 0 lights row 0 by 1 + r/8 in replicate r, lamp 1 row 1 by 2: the weights are t/a and t/2
 * with t = (a + 2)/2. The second is linear in a, so that its error is s/(4 √R). */
static double separate(int lamp, double x, int row, int replicate) {
    (void)x;
    return lamp != row ? 0 : lamp ? 2 : 1 + replicate / 8.0;
}

static void test_errors_come_from_replicates(void **state) {
    double weights[MOST_LAMPS], errors[MOST_LAMPS];
    (void)state;
    mcv_roi all = rows(0, HEIGHT);
    mcv_matrix m = matrix_of(2, separate);
    assert_int_equal(mcv_fit_uniform(&m, ones, &all, weights, errors, &error), MCV_OK);
    const double a = 1 + 1.5 / 8, t = (a + 2) / 2, deviation = sqrt(5.0 / 3) / 8;
    expect("separate", weights, (double[]){t / a, t / 2}, 2);
    expect("its error", errors + 1, (double[]){deviation / 4 / sqrt(REPLICATES)}, 1);
    assert_true(errors[0] > 0);
    m.replicates = 1;
    for (int i = 0; i < 2 * PIXELS; ++i) replicates_of[i] = (float)values[i];
    assert_int_equal(mcv_fit_uniform(&m, ones, &all, weights, errors, &error), MCV_OK);
    expect("one replicate", weights, (double[]){t / a, t / 2}, 2);
    assert_true(isnan(errors[0]));
    memset(replicates_of, 0, sizeof replicates_of);
    assert_int_equal(mcv_fit_uniform(&m, ones, &all, weights, errors, &error), MCV_BAD_INPUT);
    free(all.inside);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_even_light),
        cmocka_unit_test(test_contrast),
        cmocka_unit_test(test_errors_come_from_replicates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
