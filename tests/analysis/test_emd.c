/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* The Earth Mover's Distance against what is known of it in closed form, all assignments of few
 * masses, and its own certificate. */
#include "test.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/emd.h"
#include "truths.h"

enum { MAX_BINS = 1024 };

static uint64_t random_state = 1;

static uint32_t random_bits(void) {
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(random_state >> 32);
}

static double random_number(void) { return (random_bits() + 0.5) * 0x1p-32; }
static uint32_t random_below(uint32_t n) { return random_bits() % n; }

static mcv_emd *new_emd(uint32_t columns, uint32_t rows) {
    mcv_emd *emd;
    mcv_error error = {""};
    if (mcv_emd_new(&emd, columns, rows, &error) != MCV_OK) fail_msg("%s", error.text);
    return emd;
}

/* Written out again, not the library's: column and row of bins a and b. */
static double cost(uint32_t columns, uint32_t rows, uint32_t a, uint32_t b) {
    const int across = (int)(a % columns) - (int)(b % columns),
              down = (int)(a / columns) - (int)(b / columns);
    const double x = (double)across / columns, y = (double)down / rows;
    return sqrt(x * x + y * y);
}

/*
 * What a distance may err by. A plan is left when no reduced cost is below -ε/4 (bins + 3)² max(c),
 * so it costs at most so much per unit of mass too much; amounts are rounded to 2^-52 of the larger
 * sum, 2^-53 each, over at most max(c); sums of `bins` terms err by at most bins ε/2 of the mass.
 * All together below ε (bins + 3)² max(c) mass, for 3 bins or more.
 */
static double tolerance(const mcv_emd *emd, uint32_t bins, double mass) {
    return DBL_EPSILON * (bins + 3.0) * (bins + 3.0) * mcv_emd_max_cost(emd) * mass;
}

static void expect(const char *what, double value, double known, double within) {
    char name[96];
    snprintf(name, sizeof name, "T31 %s", what);
    note_truth(name, "program", fabs(value - known), within);
    if (!(fabs(value - known) <= within))
        fail_msg("%s: %.17g instead of %.17g, %.3g off; %.3g would be allowed", what, value, known,
                 value - known, within);
}

static double sum_of(const double *p, uint32_t bins) {
    double sum = 0;
    for (uint32_t i = 0; i < bins; ++i) sum += p[i];
    return sum;
}

/* Kinds of histograms: dense, sparse, small whole numbers with many ties and zeros, equal masses,
 * over 12 decades, a single bin. */
enum { KINDS = 6 };
static void fill(double *p, uint32_t bins, int kind) {
    const uint32_t lit = random_below(bins);
    for (uint32_t i = 0; i < bins; ++i) {
        const double u = random_number();
        const double values[KINDS] = {u, u < 0.9 ? 0 : u, random_below(3),
                                      1, exp2(-40 * u),   i == lit};
        p[i] = values[kind];
    }
}

/* --- closed forms
 * -----------------------------------------------------------------------------------------------
 */

static void test_two_deltas(void **state) {
    (void)state;
    enum { COLUMNS = 9, ROWS = 7, BINS = COLUMNS * ROWS };
    mcv_emd *emd = new_emd(COLUMNS, ROWS);
    double p[BINS] = {0}, q[BINS] = {0};
    for (uint32_t a = 0; a < BINS; ++a) {
        for (uint32_t b = 0; b < BINS; ++b) {
            p[a] = q[b] = 3;
            /* One arc: its cost, rounded a few times. */
            const double c = cost(COLUMNS, ROWS, a, b);
            expect("two deltas of mass 3, normalized",
                   mcv_emd_distance(emd, p, q, MCV_EMD_NORMALIZED, NULL), c, 4 * DBL_EPSILON * c);
            expect("two deltas of mass 3, mass", mcv_emd_distance(emd, p, q, MCV_EMD_MASS, NULL),
                   3 * c, 12 * DBL_EPSILON * c);
            q[b] = 1;
            expect("deltas of mass 3 and 1, mass", mcv_emd_distance(emd, p, q, MCV_EMD_MASS, NULL),
                   c + 0.5 * 2 * mcv_emd_max_cost(emd), 8 * DBL_EPSILON * mcv_emd_max_cost(emd));
            p[a] = q[b] = 0;
        }
    }
    mcv_emd_free(emd);
}

/* Any histogram shifted by a vector is as far as the vector is long. */
static void test_translation(void **state) {
    (void)state;
    enum { SIDE = 9, BINS = SIDE * SIDE };
    mcv_emd *emd = new_emd(SIDE, SIDE);
    for (int n = 0; n < 2000; ++n) {
        double source[BINS], p[BINS] = {0}, q[BINS] = {0};
        const uint32_t right = random_below(SIDE), down = random_below(SIDE);
        fill(source, BINS, n % KINDS);
        for (uint32_t k = 0; k + down < SIDE; ++k) {
            for (uint32_t j = 0; j + right < SIDE; ++j) {
                p[k * SIDE + j] = source[k * SIDE + j];
                q[(k + down) * SIDE + j + right] = source[k * SIDE + j];
            }
        }
        const double mass = sum_of(p, BINS), shift = hypot(right, down) / SIDE;
        if (mass > 0)
            expect("translation, normalized", mcv_emd_distance(emd, p, q, MCV_EMD_NORMALIZED, NULL),
                   shift, tolerance(emd, BINS, 1));
        expect("translation, mass", mcv_emd_distance(emd, p, q, MCV_EMD_MASS, NULL), mass * shift,
               tolerance(emd, BINS, mass));
    }
    mcv_emd_free(emd);
}

/* On a line the distance is the area between the distribution functions. */
static void test_line(void **state) {
    (void)state;
    enum { BINS = 31 };
    mcv_emd *across = new_emd(BINS, 1), *down = new_emd(1, BINS);
    for (int n = 0; n < 500; ++n) {
        double p[BINS], q[BINS], difference = 0, area = 0;
        fill(p, BINS, n % KINDS);
        fill(q, BINS, n / KINDS % KINDS);
        const double sum_p = sum_of(p, BINS), sum_q = sum_of(q, BINS);
        if (sum_p == 0 || sum_q == 0) continue;
        for (uint32_t i = 0; i < BINS; ++i) {
            difference += p[i] / sum_p - q[i] / sum_q;
            area += fabs(difference) / BINS;
        }
        expect("a line of columns", mcv_emd_distance(across, p, q, MCV_EMD_NORMALIZED, NULL), area,
               tolerance(across, BINS, 1));
        expect("a line of rows", mcv_emd_distance(down, p, q, MCV_EMD_NORMALIZED, NULL), area,
               tolerance(down, BINS, 1));
    }
    mcv_emd_free(across);
    mcv_emd_free(down);
}

static void test_mass_term(void **state) {
    (void)state;
    enum { SIDE = 9, BINS = SIDE * SIDE };
    mcv_emd *emd = new_emd(SIDE, SIDE);
    const double dark[BINS] = {0};
    const double diagonal = hypot(8.0 / 9, 8.0 / 9);
    expect("max(c)", mcv_emd_max_cost(emd), diagonal, 2 * DBL_EPSILON);
    for (int n = 0; n < 600; ++n) {
        double p[BINS], q[BINS], more = 0;
        fill(p, BINS, n % KINDS);
        fill(q, BINS, n / KINDS % KINDS);
        for (uint32_t i = 0; i < BINS; ++i) {
            more += q[i];
            q[i] += p[i];
        }
        const double mass = sum_of(p, BINS);
        /* Nothing has to move; the rounding of the sums and of q alone is left. */
        const double within = BINS * DBL_EPSILON * diagonal * (mass + more);
        expect("light added, mass", mcv_emd_distance(emd, p, q, MCV_EMD_MASS, NULL),
               0.5 * diagonal * more, within);
        expect("light taken away, mass", mcv_emd_distance(emd, q, p, MCV_EMD_MASS, NULL),
               0.5 * diagonal * more, within);
        expect("all light taken away, mass", mcv_emd_distance(emd, p, dark, MCV_EMD_MASS, NULL),
               0.5 * diagonal * mass, within);
        if (mass == 0) continue;
        expect("all light taken away, normalized",
               mcv_emd_distance(emd, p, dark, MCV_EMD_NORMALIZED, NULL), diagonal, 2 * DBL_EPSILON);
        expect("light from nothing, normalized",
               mcv_emd_distance(emd, dark, p, MCV_EMD_NORMALIZED, NULL), diagonal, 2 * DBL_EPSILON);
        for (uint32_t i = 0; i < BINS; ++i) q[i] = 7 * p[i];
        /* Only the rounding of 7 p is left to be moved. */
        expect("seven times the light, normalized",
               mcv_emd_distance(emd, p, q, MCV_EMD_NORMALIZED, NULL), 0,
               BINS * DBL_EPSILON * diagonal);
    }
    expect("dark and dark, normalized", mcv_emd_distance(emd, dark, dark, MCV_EMD_NORMALIZED, NULL),
           0, 0);
    expect("dark and dark, mass", mcv_emd_distance(emd, dark, dark, MCV_EMD_MASS, NULL), 0, 0);
    mcv_emd_free(emd);
}

/* --- a metric
 * ---------------------------------------------------------------------------------------------------
 */

static void test_metric(void **state) {
    (void)state;
    enum { COLUMNS = 9, ROWS = 8, BINS = COLUMNS * ROWS };
    mcv_emd *emd = new_emd(COLUMNS, ROWS);
    for (int n = 0; n < 2000; ++n) {
        double h[3][BINS], mass = 1;
        for (int i = 0; i < 3; ++i) {
            fill(h[i], BINS, (int)random_below(KINDS));
            h[i][random_below(BINS)] += 1; /* never empty */
            mass = fmax(mass, sum_of(h[i], BINS));
        }
        for (int form = MCV_EMD_NORMALIZED; form <= MCV_EMD_MASS; ++form) {
            const double scale = form == MCV_EMD_MASS ? mass : 1,
                         within = tolerance(emd, BINS, scale);
            const double pq = mcv_emd_distance(emd, h[0], h[1], form, NULL),
                         qp = mcv_emd_distance(emd, h[1], h[0], form, NULL);
            const double qr = mcv_emd_distance(emd, h[1], h[2], form, NULL),
                         pr = mcv_emd_distance(emd, h[0], h[2], form, NULL);
            expect("symmetry", pq, qp, 2 * within);
            if (pr > pq + qr + 3 * within)
                fail_msg("triangle inequality: %.17g > %.17g + %.17g", pr, pq, qr);
            expect("zero for equal histograms", mcv_emd_distance(emd, h[0], h[0], form, NULL), 0,
                   0);
            if (memcmp(h[0], h[1], sizeof h[0]) != 0 && form == MCV_EMD_MASS && !(pq > 0))
                fail_msg("0 for different histograms");
        }
        /* The centres of mass move by no more than the light does. */
        double shift[2] = {0, 0};
        const double sums[2] = {sum_of(h[0], BINS), sum_of(h[1], BINS)};
        for (uint32_t i = 0; i < BINS; ++i) {
            const double d = h[1][i] / sums[1] - h[0][i] / sums[0];
            const uint32_t column = i % COLUMNS, row = i / COLUMNS;
            shift[0] += d * column / COLUMNS;
            shift[1] += d * row / ROWS;
        }
        const double moved = mcv_emd_distance(emd, h[0], h[1], MCV_EMD_NORMALIZED, NULL);
        if (moved < hypot(shift[0], shift[1]) - tolerance(emd, BINS, 1))
            fail_msg("%.17g is less than the way of the centre of mass, %.17g", moved,
                     hypot(shift[0], shift[1]));
    }
    mcv_emd_free(emd);
}

/* --- brute force
 * ------------------------------------------------------------------------------------------------
 */

enum { MOST = 7 };

/* The least cost of giving each of the first `count` sources a sink of its own. */
static double assign(const double (*costs)[MOST], int count, int sinks, unsigned taken,
                     int source) {
    double least = INFINITY;
    if (source == count) return 0;
    for (int t = 0; t < sinks; ++t)
        if (!(taken >> t & 1))
            least = fmin(least, costs[source][t] +
                                    assign(costs, count, sinks, taken | 1u << t, source + 1));
    return least;
}

/* Up to 7 unit masses on each side, in any bins: the best plan of unit masses moves them whole. */
static void test_all_assignments(void **state) {
    (void)state;
    enum { COLUMNS = 5, ROWS = 6, BINS = COLUMNS * ROWS };
    mcv_emd *emd = new_emd(COLUMNS, ROWS);
    for (int n = 0; n < 600; ++n) {
        double p[BINS] = {0}, q[BINS] = {0}, costs[MOST][MOST] = {{0}};
        uint32_t from[MOST], to[MOST];
        const int many = 1 + (int)random_below(MOST), few = 1 + (int)random_below((uint32_t)many);
        for (int i = 0; i < few; ++i) p[from[i] = random_below(BINS)] += 1;
        for (int i = 0; i < many; ++i) q[to[i] = random_below(BINS)] += 1;
        for (int i = 0; i < few; ++i)
            for (int k = 0; k < many; ++k) costs[i][k] = cost(COLUMNS, ROWS, from[i], to[k]);
        const double known = assign(costs, few, many, 0, 0),
                     penalty = 0.5 * mcv_emd_max_cost(emd) * (many - few);
        const double within = tolerance(emd, BINS, many);
        expect("few to many", mcv_emd_distance(emd, p, q, MCV_EMD_MASS, NULL), known + penalty,
               within);
        expect("many to few", mcv_emd_distance(emd, q, p, MCV_EMD_MASS, NULL), known + penalty,
               within);
        if (few == many)
            expect("normalized", mcv_emd_distance(emd, p, q, MCV_EMD_NORMALIZED, NULL), known / few,
                   within);
    }
    mcv_emd_free(emd);
}

/* --- the certificate
 * -------------------------------------------------------------------------------------------- */

/*
 * Weak duality proves the distance without any knowledge of how it was found: no potential that
 * changes by at most c from bin to bin can give more than the cheapest plan, and the plan that was
 * found costs what this one gives.
 */
static void expect_certificate(mcv_emd *emd, uint32_t columns, uint32_t rows, const double *p,
                               const double *q, mcv_emd_form form) {
    const uint32_t bins = columns * rows;
    const bool normalized = form == MCV_EMD_NORMALIZED;
    const double sum_p = sum_of(p, bins), sum_q = sum_of(q, bins);
    if (normalized && (sum_p == 0 || sum_q == 0)) return;
    double f[MAX_BINS], low = INFINITY, high = -INFINITY, given = 0, surplus = 0, moved = 0;
    const double distance = mcv_emd_distance(emd, p, q, form, f);
    for (uint32_t i = 0; i < bins; ++i) {
        const double d = normalized ? q[i] / sum_q - p[i] / sum_p : q[i] - p[i];
        low = fmin(low, f[i]);
        high = fmax(high, f[i]);
        given += f[i] * d;
        surplus += d;
        moved += fabs(d);
        for (uint32_t k = 0; k < bins; ++k) {
            /* f is of the order of max(c), rounded once or twice. */
            const double steep = fabs(f[i] - f[k]) - cost(columns, rows, i, k);
            if (steep > 16 * DBL_EPSILON * mcv_emd_max_cost(emd))
                fail_msg("%u x %u bins: the potential is too steep by %.3g between bins %u and %u",
                         columns, rows, steep, i, k);
        }
    }
    given -= surplus * (surplus > 0 ? high : low);
    if (!normalized) given += 0.5 * mcv_emd_max_cost(emd) * fabs(surplus);
    expect("the certificate", distance, given, tolerance(emd, bins, moved));
}

static void test_certificate(void **state) {
    (void)state;
    const uint32_t sizes[][3] = {{9, 9, 1500}, {1, 1, 50},  {1, 9, 300},
                                 {16, 3, 300}, {2, 2, 300}, {32, 32, 2}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; ++s) {
        const uint32_t columns = sizes[s][0], rows = sizes[s][1];
        mcv_emd *emd = new_emd(columns, rows);
        for (uint32_t n = 0; n < sizes[s][2]; ++n) {
            double p[MAX_BINS], q[MAX_BINS];
            fill(p, columns * rows, (int)(n % KINDS));
            fill(q, columns * rows, (int)(n / KINDS % KINDS));
            expect_certificate(emd, columns, rows, p, q, n & 1 ? MCV_EMD_MASS : MCV_EMD_NORMALIZED);
        }
        /* As degenerate as can be: a chessboard, whose fields are equal. */
        double white[MAX_BINS], black[MAX_BINS];
        for (uint32_t i = 0; i < columns * rows; ++i)
            white[i] = 1 - (black[i] = (i % columns + i / columns) % 2);
        expect_certificate(emd, columns, rows, white, black, MCV_EMD_MASS);
        expect_certificate(emd, columns, rows, white, black, MCV_EMD_NORMALIZED);
        mcv_emd_free(emd);
    }
}

static void test_bad_sizes(void **state) {
    (void)state;
    const uint32_t sizes[][2] = {{0, 9}, {9, 0}, {33, 32}, {65536, 65536}};
    for (size_t s = 0; s < sizeof sizes / sizeof sizes[0]; ++s) {
        mcv_emd *emd;
        mcv_error error = {""};
        assert_int_equal(mcv_emd_new(&emd, sizes[s][0], sizes[s][1], &error), MCV_BAD_INPUT);
        assert_null(emd);
        assert_non_null(strstr(error.text, "1 to 1024 bins"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_two_deltas),  cmocka_unit_test(test_translation),
        cmocka_unit_test(test_line),        cmocka_unit_test(test_mass_term),
        cmocka_unit_test(test_metric),      cmocka_unit_test(test_all_assignments),
        cmocka_unit_test(test_certificate), cmocka_unit_test(test_bad_sizes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
