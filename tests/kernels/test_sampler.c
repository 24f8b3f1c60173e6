/* SPDX-License-Identifier: Apache-2.0 */
/* The device's random numbers: every use has a pair of its own, pairs are nets, and no two of them
 * know of each other. */
#include "elements.h"

enum {
    USES = 3,
    SENSOR = USES
}; /* of a surface, as in kernels/path/sampler.h; else one of the sensor's */

typedef struct draw {
    uint32_t number;
    float x, y;
} draw;

/* cases: stream, sample, depth, use */
static void draw_pairs(size_t count, const uint32_t *cases, draw *draws) {
    run_elements("draw_pairs", MCV_SENSOR_PINHOLE, NULL, 0, count, cases, 4 * sizeof *cases * count,
                 draws, sizeof *draws * count);
}

static int compare_numbers(const void *a, const void *b) {
    const uint32_t x = ((const draw *)a)->number, y = ((const draw *)b)->number;
    return (x > y) - (x < y);
}

static void test_every_use_has_a_pair_of_its_own(void **state) {
    enum { DEPTHS = 64, SENSORS = 2, COUNT = 256 }; /* a multiple of 64 */
    static uint32_t cases[4 * COUNT];
    static draw draws[COUNT];
    size_t count = 0;
    (void)state;
    for (uint32_t depth = 0; depth < DEPTHS; ++depth)
        for (uint32_t use = 0; use < USES; ++use)
            memcpy(cases + 4 * count++, (uint32_t[4]){1, 0, depth, use}, 4 * sizeof *cases);
    for (uint32_t k = 0; k < SENSORS; ++k)
        memcpy(cases + 4 * count++, (uint32_t[4]){1, 0, k, SENSOR}, 4 * sizeof *cases);
    draw_pairs(COUNT, cases, draws);
    qsort(draws, count, sizeof *draws, compare_numbers);
    for (size_t i = 1; i < count; ++i)
        if (draws[i].number == draws[i - 1].number)
            fail_msg("two uses share the pair %u", draws[i].number);
}

/*
 * The samples [0, 2^m) of each pair are a (0, m, 2)-net: every interval of 2^-j x 2^-(m - j) holds
 * exactly one of them. Exact: all numbers are multiples of 2^-24.
 */
static void test_points_are_a_net(void **state) {
    enum { M = 12, POINTS = 1 << M, STREAMS = 4 };
    static uint32_t cases[4 * POINTS];
    static draw draws[POINTS];
    static unsigned char held[POINTS];
    (void)state;
    for (uint32_t stream = 0; stream < STREAMS; ++stream) {
        for (uint32_t i = 0; i < POINTS; ++i)
            memcpy(cases + 4 * i, (uint32_t[4]){stream * 7919u, i, stream, stream % USES},
                   4 * sizeof *cases);
        draw_pairs(POINTS, cases, draws);
        for (int j = 0; j <= M; ++j) {
            memset(held, 0, sizeof held);
            for (uint32_t i = 0; i < POINTS; ++i) {
                const uint32_t column = (uint32_t)ldexpf(draws[i].x, j),
                               row = (uint32_t)ldexpf(draws[i].y, M - j);
                if (held[(row << j) + column]++)
                    fail_msg("stream %u: two points lie in one interval of 2^-%d x 2^-%d", stream,
                             j, M - j);
            }
        }
    }
}

/*
 * Of two pairs, or two streams, the same samples have no correlation: of n independent numbers it
 * is 0 with a standard deviation of 1/√n. Nets spread less than that. 5 of them: 6e-7 each.
 */
static void test_pairs_do_not_know_of_each_other(void **state) {
    enum { POINTS = 1 << 12, PAIRS = 8 };
    static uint32_t cases[4 * POINTS * PAIRS];
    static draw draws[POINTS * PAIRS];
    double worst = 0;
    (void)state;
    for (uint32_t p = 0; p < PAIRS; ++p)
        for (uint32_t i = 0; i < POINTS; ++i)
            memcpy(cases + 4 * (p * POINTS + i), (uint32_t[4]){p / 6, i, p % 6 / USES, p % USES},
                   4 * sizeof *cases);
    draw_pairs(POINTS * PAIRS, cases, draws);
    for (int a = 0; a < 2 * PAIRS; ++a)
        for (int b = 0; b < a; ++b) {
            double sum = 0;
            for (int i = 0; i < POINTS; ++i) {
                const draw *first = draws + a / 2 * POINTS + i,
                           *second = draws + b / 2 * POINTS + i;
                sum += ((double)(a % 2 ? first->y : first->x) - 0.5) *
                       ((double)(b % 2 ? second->y : second->x) - 0.5);
            }
            worst = fmax(worst, fabs(12 * sum / POINTS));
        }
    print_message("  largest correlation %.3g of %.3g\n", worst, 5 / sqrt(POINTS));
    assert_true(worst <= 5 / sqrt(POINTS));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_use_has_a_pair_of_its_own),
        cmocka_unit_test(test_points_are_a_net),
        cmocka_unit_test(test_pairs_do_not_know_of_each_other),
    };
    element_features = MCV_FEATURE_BIT(LIGHT_TRACING); /* the program of test_elements */
    return cmocka_run_group_tests(tests, open_device, close_device);
}
