/* SPDX-License-Identifier: Apache-2.0 */
/* Patterns of inverse schlieren for made-up matrices whose patterns are known. */
#include "test.h"

#include "transport/inverse.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Pixel i is lit by element 2 i of a projector with twice as many, and by nothing else. */
enum { PIXELS = 6, ELEMENTS = 12, REPLICATES = 4 };

static mcv_error error;
static mcv_element_group projector = {.emitter = "projector", .width = ELEMENTS, .height = 1};
static uint64_t begins[PIXELS + 1];
static uint32_t columns[PIXELS];
static double values[PIXELS];
static float replicates_of[PIXELS * REPLICATES];

/* Element 2 i brings 2 + i; the first one differs by replicate. */
static double brings(int pixel, int replicate, bool noisy) {
    return 2 + pixel + (noisy && pixel == 1 ? replicate - 1.5 : 0) / 8;
}

static mcv_matrix matrix_of(bool noisy) {
    for (int i = 0; i < PIXELS; ++i) {
        begins[i + 1] = (uint64_t)i + 1;
        columns[i] = (uint32_t)(2 * i);
        values[i] = 0;
        for (int r = 0; r < REPLICATES; ++r) {
            replicates_of[i * REPLICATES + r] = (float)brings(i, r, noisy);
            values[i] += brings(i, r, noisy) / REPLICATES;
        }
    }
    return (mcv_matrix){.width = PIXELS,
                        .height = 1,
                        .channels = 1,
                        .replicates = REPLICATES,
                        .kept = 1,
                        .groups = &projector,
                        .group_count = 1,
                        .element_count = ELEMENTS,
                        .column_count = ELEMENTS,
                        .row_count = PIXELS,
                        .row_begins = begins,
                        .columns = columns,
                        .values = values,
                        .replicates_of = replicates_of};
}

static void find(const mcv_matrix *m, mcv_inverse inverse, mcv_image *pattern,
                 mcv_image *deviation) {
    inverse.group = &projector;
    if (mcv_inverse_pattern(m, &inverse, pattern, deviation, &error) != MCV_OK)
        fail_msg("%s", error.text);
}

/* Tᵀ w with w = 1/(T Tᵀ 1) is c/c² here, and least squares find T x = 1: both are 1/c of the
 * darkest pixel's 1/2. The descent ends at the root of the rounding. */
static void test_even_images(void **state) {
    static const mcv_inverse ways[] = {{.method = MCV_INVERSE_REPLAY},
                                       {.method = MCV_INVERSE_LEAST_SQUARES}};
    (void)state;
    mcv_matrix m = matrix_of(false);
    for (int way = 0; way < 2; ++way) {
        mcv_image pattern, deviation;
        find(&m, ways[way], &pattern, &deviation);
        for (int e = 0; e < ELEMENTS; ++e) {
            const double expected = e % 2 ? 0 : 2.0 / (2 + e / 2);
            if (!(fabs((double)pattern.pixels[e] - expected) <= 1e-6))
                fail_msg("way %d, element %d: %g, must be %g", way, e, (double)pattern.pixels[e],
                         expected);
            assert_true((double)deviation.pixels[e] <= 1e-6);
        }
        mcv_image_free(&pattern);
        mcv_image_free(&deviation);
    }
}

/* Of one pixel x = c/(c² + µ), with µ the damping times the mean of the squares, 27.8 (4 … 49). */
static void test_damping(void **state) {
    mcv_image pattern, deviation;
    double mean = 0;
    (void)state;
    mcv_matrix m = matrix_of(false);
    for (int i = 0; i < PIXELS; ++i) mean += pow(2 + i, 2) / PIXELS;
    find(&m, (mcv_inverse){.method = MCV_INVERSE_LEAST_SQUARES, .damping = 0.5}, &pattern,
         &deviation);
    double most = 0, expected[PIXELS];
    for (int i = 0; i < PIXELS; ++i) {
        expected[i] = (2 + i) / (pow(2 + i, 2) + 0.5 * mean);
        most = fmax(most, expected[i]);
    }
    for (int i = 0; i < PIXELS; ++i)
        assert_true(fabs((double)pattern.pixels[2 * i] - expected[i] / most) <= 1e-6);
    mcv_image_free(&pattern);
    mcv_image_free(&deviation);
}

/* A pattern of 4 bits has codes of 1/15, and is off by half of one; the dark field is the rest. */
static void test_bits_and_dark_field(void **state) {
    mcv_image exact, coarse, dark, deviation;
    (void)state;
    mcv_matrix m = matrix_of(false);
    find(&m, (mcv_inverse){.bits = 0}, &exact, &deviation);
    mcv_image_free(&deviation);
    find(&m, (mcv_inverse){.bits = 4}, &coarse, &deviation);
    mcv_image_free(&deviation);
    find(&m, (mcv_inverse){.dark = true}, &dark, &deviation);
    for (int e = 0; e < ELEMENTS; ++e) {
        const double code = 15 * (double)coarse.pixels[e];
        assert_true(fabs(code - rint(code)) <= 1e-6);
        assert_true(fabs((double)coarse.pixels[e] - (double)exact.pixels[e]) <= 0.5 / 15 + 1e-7);
        assert_true(dark.pixels[e] == (e % 2 ? 1 : 0));
    }
    mcv_image_free(&exact);
    mcv_image_free(&coarse);
    mcv_image_free(&dark);
    mcv_image_free(&deviation);
}

/* x₁ = 2/c of a noisy c, of which each pattern leaves out a replicate. */
static void test_errors_come_from_replicates(void **state) {
    mcv_image pattern, deviation;
    double without[REPLICATES], mean = 0, squares = 0;
    (void)state;
    mcv_matrix m = matrix_of(true);
    find(&m, (mcv_inverse){.bits = 0}, &pattern, &deviation);
    for (int out = 0; out < REPLICATES; ++out) {
        double sum = 0;
        for (int r = 0; r < REPLICATES; ++r)
            if (r != out) sum += brings(1, r, true);
        without[out] = 2 / (sum / (REPLICATES - 1));
        mean += without[out] / REPLICATES;
    }
    for (int out = 0; out < REPLICATES; ++out) squares += pow(without[out] - mean, 2);
    /* Floats of the replicates. */
    assert_true(fabs((double)deviation.pixels[2] - sqrt(squares * 3 / 4)) <= 1e-6);
    assert_true(deviation.pixels[4] == 0);
    mcv_image_free(&pattern);
    mcv_image_free(&deviation);
    m.replicates = 1;
    find(&m, (mcv_inverse){.bits = 0}, &pattern, &deviation);
    assert_true(isnan(deviation.pixels[2]));
    mcv_image_free(&pattern);
    mcv_image_free(&deviation);
    memset(replicates_of, 0, sizeof replicates_of);
    const mcv_inverse inverse = {.group = &projector};
    assert_int_equal(mcv_inverse_pattern(&m, &inverse, &pattern, &deviation, &error),
                     MCV_BAD_INPUT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_even_images),
        cmocka_unit_test(test_damping),
        cmocka_unit_test(test_bits_and_dark_field),
        cmocka_unit_test(test_errors_come_from_replicates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
