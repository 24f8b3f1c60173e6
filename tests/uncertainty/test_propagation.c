/* SPDX-License-Identifier: Apache-2.0 */
/* Tolerances to a metric, with metrics that are functions in closed form. */
#include "test.h"

#define CASES 2000
#include "coverage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/noise.h"
#include "uncertainty/propagation.h"

#define TEXTS(...) \
    ((mcv_texts){(const char *const[]){__VA_ARGS__}, \
                 sizeof((const char *const[]){__VA_ARGS__}) / sizeof(char *)})
static const mcv_texts no_texts = {NULL, 0};

/* Tolerances of the parameters a, b, c … with these distributions. */
static mcv_result read(const char *const *distributions, size_t count, mcv_texts correlate,
                       mcv_tolerances *tolerances, mcv_error *error) {
    static char items[MCV_DESIGN_PARAMETERS][64];
    mcv_plan plan = {.varied = count, .count = count};
    for (size_t i = 0; i < count; ++i) {
        snprintf(items[i], sizeof items[i], "%c=%s", (char)('a' + i), distributions[i]);
        plan.parameters[i] = (mcv_parameter){.item = items[i], .path_length = 1};
        plan.parameters[i].name[0] = (char)('a' + i);
    }
    return mcv_tolerances_read(&plan, correlate, tolerances, error);
}

static void read_well(const char *const *distributions, size_t count, mcv_texts correlate,
                      mcv_tolerances *tolerances) {
    mcv_error error;
    if (read(distributions, count, correlate, tolerances, &error) != MCV_OK)
        fail_msg("%s", error.text);
}

static void test_says_what_is_wrong(void **state) {
    const struct {
        const char *distributions[3];
        mcv_texts correlate;
        const char *words;
    } cases[] = {
        {{"gauss(1)"}, {NULL, 0}, "must be normal(U), uniform(A) or triangular(A)"},
        {{"normal"}, {NULL, 0}, "must be normal(U)"},
        {{"normal()"}, {NULL, 0}, "must be normal(U)"},
        {{"normal(1"}, {NULL, 0}, "must be normal(U)"},
        {{"normal(1)x"}, {NULL, 0}, "must be normal(U)"},
        {{"normal(1,2,3)"}, {NULL, 0}, "must be normal(U)"},
        {{"normal(nan)"}, {NULL, 0}, "must be normal(U)"},
        {{"uniform(1parsec)"}, {NULL, 0}, "must be normal(U)"},
        {{"uniform(0)"}, {NULL, 0}, "wider than 0"},
        {{"normal(2,-1)"}, {NULL, 0}, "wider than 0"},
        {{"normal(1)", "normal(1)"}, TEXTS("a=0.5"), "must be A,B=R"},
        {{"normal(1)", "normal(1)"}, TEXTS("a,b"), "must be A,B=R"},
        {{"normal(1)", "normal(1)"}, TEXTS("a,b=1"), "between -1 and 1"},
        {{"normal(1)", "normal(1)"}, TEXTS("a,b=0.5x"), "must be A,B=R"},
        {{"normal(1)", "normal(1)"}, TEXTS("a,c=0.5"), "two different tolerances"},
        {{"normal(1)", "normal(1)"}, TEXTS("a,a=0.5"), "two different tolerances"},
        {{"normal(1)", "uniform(1)"}, TEXTS("a,b=0.98"), "so closely correlated"},
        {{"normal(1)", "normal(1)", "normal(1)"},
         TEXTS("a,b=0.9", "b,c=0.9", "a,c=-0.9"),
         "all of these coefficients together"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_tolerances t;
        mcv_error error = {""};
        size_t count = 0;
        while (count < 3 && cases[i].distributions[count]) ++count;
        const mcv_result result =
            read(cases[i].distributions, count, cases[i].correlate, &t, &error);
        if (result != MCV_USAGE || !strstr(error.text, cases[i].words))
            fail_msg("case %zu: %d: %s", i, (int)result, error.text);
    }
}

/* The mean of a function of a draw, over the scores' density by the trapezoidal rule. */
static double expect(const mcv_distribution *d, double (*of)(const mcv_distribution *, double)) {
    double sum = 0;
    const double step = 1.0 / 1024;
    for (double z = -9; z <= 9; z += step)
        sum += of(d, mcv_distribution_at(d, z)) * exp(-z * z / 2) * step / sqrt(2 * M_PI);
    return sum;
}
static double itself(const mcv_distribution *d, double x) {
    (void)d;
    return x;
}
static double squared(const mcv_distribution *d, double x) {
    return (x - d->centre) * (x - d->centre);
}
/* Kurtosis: 3, 9/5 and 12/5. */
static double fourth(const mcv_distribution *d, double x) { return pow(x - d->centre, 4); }

static void test_distributions(void **state) {
    static const struct {
        const char *text;
        double deviation, kurtosis;
    } cases[] = {{"normal(0.5,2mm)", 2e-3, 3},
                 {"uniform(-3,0.3)", 0.3 / 1.7320508075688772, 1.8},
                 {"triangular(1e3,6)", 2.449489742783178, 2.4}};
    (void)state;
    for (size_t i = 0; i < 3; ++i) {
        mcv_distribution d;
        mcv_error error;
        assert_int_equal(mcv_distribution_parse(cases[i].text, &d, &error), MCV_OK);
        const double u = mcv_distribution_deviation(&d), mean = expect(&d, itself);
        /* The rule's error: step² times the jump of the integrand's slope at z = 0, 1e-6. */
        assert_true(fabs(u - cases[i].deviation) < 1e-12 * u);
        if (!(fabs(mean - d.centre) < 1e-5 * u) ||
            !(fabs(expect(&d, squared) / (u * u) - 1) < 1e-5) ||
            !(fabs(expect(&d, fourth) / pow(u, 4) - cases[i].kurtosis) < 1e-4))
            fail_msg("%s: mean %.9g, variance %.9g, kurtosis %.9g", cases[i].text, mean,
                     expect(&d, squared), expect(&d, fourth) / pow(u, 4));
    }
}

/* Coefficients of draws are those that were given: of n draws their standard deviation is at most
 * (1 - r²)/√n for normal ones, and of the order of 1/√n for all. */
static void test_correlated_draws(void **state) {
    static const char *const kinds[] = {"normal(1,2)", "uniform(0,2)", "triangular(5,0.1)"};
    enum { DRAWS = 100000 };
    mcv_tolerances t;
    double sums[3] = {0}, products[3][3] = {{0}}, scores[3], values[3];
    (void)state;
    read_well(kinds, 3, TEXTS("a,b=0.6", "b,c=-0.5", "a,c=0.2"), &t);
    /* The score r' of a normal and an even distribution: E[x (2 Φ(r' x + …) - 1)] √3 = r' √(3/π).
     */
    if (!(fabs(t.factor[1][0] - 0.6 * sqrt(M_PI / 3)) < 1e-9))
        fail_msg("scores of 0.6: %.12g", t.factor[1][0]);
    mcv_noise noise = mcv_noise_begin(7, 0, 0);
    for (int i = 0; i < DRAWS; ++i) {
        for (int k = 0; k < 3; ++k) scores[k] = mcv_noise_normal(&noise);
        mcv_tolerances_draw(&t, scores, values);
        for (int k = 0; k < 3; ++k) {
            const double x = (values[k] - t.of[k].centre) / mcv_distribution_deviation(t.of + k);
            values[k] = x;
            sums[k] += x / DRAWS;
            for (int j = 0; j <= k; ++j) products[k][j] += x * values[j] / DRAWS;
        }
    }
    const double margin_of_draws = 4 / sqrt(DRAWS);
    for (int k = 0; k < 3; ++k) {
        assert_true(fabs(sums[k]) < margin_of_draws);
        for (int j = 0; j <= k; ++j)
            if (!(fabs(products[k][j] - t.correlation[k][j]) < 1.5 * margin_of_draws))
                fail_msg("%d,%d: %g, not %g", k, j, products[k][j], t.correlation[k][j]);
    }
}

/* --- metrics --- */

typedef double metric(const double *x);
static double linear(const double *x) { return 5 + 3 * x[0] - 2 * x[1] + 0.5 * x[2]; }
static double product(const double *x) { return x[0] * x[1]; }
static double square(const double *x) { return x[0] * x[0]; }
static double ishigami(const double *x) {
    return sin(x[0]) + 7 * sin(x[1]) * sin(x[1]) + 0.1 * pow(x[2], 4) * sin(x[0]);
}

/* How a render's noise is made: of all that share a seed, and of each point. */
typedef struct noises {
    double common, own;
} noises;

static mcv_propagated propagate(const mcv_propagation *p, metric *of, noises u, uint32_t seed) {
    const size_t count = mcv_propagation_points(p);
    double *points = malloc(count * 2 * sizeof *points);
    mcv_propagated found;
    mcv_error error;
    assert_non_null(points);
    for (size_t i = 0; i < count; ++i) {
        double x[MCV_DESIGN_PARAMETERS];
        uint32_t offset;
        mcv_propagation_point(p, i, seed, x, &offset);
        mcv_noise shared = mcv_noise_begin(seed + 1, 17, offset),
                  own = mcv_noise_begin(seed + 1, 18, i);
        points[2 * i] =
            of(x) + u.common * mcv_noise_normal(&shared) + u.own * mcv_noise_normal(&own);
        points[2 * i + 1] = hypot(u.common, u.own);
    }
    assert_int_equal(mcv_propagate(p, points, 2, &found, &error), MCV_OK);
    free(points);
    return found;
}

static void assert_near(double value, double truth, double tolerance, const char *what) {
    if (!(fabs(value - truth) <= tolerance))
        fail_msg("%s: %.10g, not %.10g within %g", what, value, truth, tolerance);
}

static void test_a_linear_metric(void **state) {
    static const char *const kinds[] = {"normal(10,0.1)", "uniform(0,0.3)", "triangular(-1,0.2)"};
    mcv_tolerances t;
    (void)state;
    for (int correlated = 0; correlated < 2; ++correlated) {
        const double r = correlated ? 0.5 : 0;
        read_well(kinds, 3, correlated ? TEXTS("a,b=0.5") : no_texts, &t);
        const mcv_propagation p = {&t, 2, 4000, false};
        const mcv_propagated f = propagate(&p, linear, (noises){0, 0}, 3);
        const double c[3] = {0.3, -0.6 / sqrt(3), 0.1 / sqrt(6)},
                     u = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2] + 2 * r * c[0] * c[1]);
        for (int i = 0; i < 3; ++i) assert_near(f.effects[i].effect, c[i], 1e-12, "an effect");
        assert_near(f.nominal, 34.5, 1e-12, "the nominal value");
        assert_near(f.linear.value, u, 1e-12, "GUM");
        /* The standard deviation of n values: u √((kurtosis - 1)/4n), at most u/√(2n) here. */
        assert_near(f.deviation.value, u, 4 * u / sqrt(8000), "Monte Carlo");
        assert_near(f.mean, 34.5, 4 * u / sqrt(4000), "the mean");
        assert_near(f.effects[0].share + f.effects[1].share + f.effects[2].share, 1, 1e-9,
                    "all shares");
        assert_true(f.order[0] == 1 && f.order[1] == 0 && f.order[2] == 2);
        assert_false(f.nonlinear || f.interacts || f.effects[0].curved);
    }
}

/* GUM sees nothing of it at (0, 0); the flag must be raised. */
static void test_a_product_is_flagged(void **state) {
    static const char *const kinds[] = {"normal(0,0.2)", "normal(0,0.5)"};
    mcv_tolerances t;
    (void)state;
    read_well(kinds, 2, no_texts, &t);
    const mcv_propagation both = {&t, 4, 4000, false}, first = {&t, 4, 0, false};
    mcv_propagated f = propagate(&both, product, (noises){1e-3, 1e-4}, 5);
    /* Of a product of normal numbers the kurtosis is 9: u √(8/4n). */
    assert_near(f.deviation.value, 0.1, 4 * 0.1 * sqrt(2.0 / 4000), "Monte Carlo");
    assert_true(f.linear.value < 1e-3 && f.linear.high < 2e-3);
    assert_true(f.interacts && f.nonlinear);
    f = propagate(&first, product, (noises){1e-3, 1e-4}, 6);
    assert_true(f.interacts && f.nonlinear && isnan(f.deviation.value));
}

static void test_a_square(void **state) {
    static const char *const kinds[] = {"normal(0,1)"};
    mcv_tolerances t;
    (void)state;
    read_well(kinds, 1, no_texts, &t);
    const mcv_propagation p = {&t, 2, 20000, false};
    const mcv_propagated f = propagate(&p, square, (noises){0, 0}, 11);
    /* χ² of one degree of freedom: mean 1, variance 2, kurtosis 15, 2.5 % and 97.5 % quantiles
     * 0.000982 and 5.0239, whose density there is 0.0145. */
    assert_near(f.mean, 1, 4 * sqrt(2.0 / 20000), "mean");
    assert_near(f.deviation.value, M_SQRT2, 4 * M_SQRT2 * sqrt(14.0 / 80000), "deviation");
    assert_near(f.high, 5.0239, 4 * sqrt(0.025 * 0.975 / 20000) / 0.0145, "97.5 %");
    assert_near(f.low, 0.000982, 3e-4, "2.5 %");
    assert_true(f.nonlinear && f.effects[0].curved && !f.effects[0].resolved);
}

/* x² + y² is curved in each, and nothing interacts; with (x + y)² it does: 2 x y. */
static double squares(const double *x) { return x[0] * x[0] + x[1] * x[1]; }
static double square_of_sum(const double *x) { return (x[0] + x[1]) * (x[0] + x[1]); }

static void test_curvature_is_no_interaction(void **state) {
    static const char *const kinds[] = {"normal(0,1)", "normal(0,0.7)"};
    mcv_tolerances t;
    (void)state;
    read_well(kinds, 2, no_texts, &t);
    const mcv_propagation p = {&t, 3, 0, false};
    mcv_propagated f = propagate(&p, squares, (noises){0, 0}, 12);
    assert_true(f.effects[0].curved && f.effects[1].curved && !f.interacts);
    f = propagate(&p, square_of_sum, (noises){0, 0}, 12);
    assert_true(f.effects[0].curved && f.effects[1].curved && f.interacts);
}

/* Without noise and with noise that carries a quarter of the variance: the indices are of the
 * parameters alone. (Ishigami and Homma 1990; a = 7, b = 0.1.) */
static void test_indices_of_ishigami(void **state) {
    static const char *const kinds[] = {"uniform(0,3.141592653589793)",
                                        "uniform(0,3.141592653589793)",
                                        "uniform(0,3.141592653589793)"};
    static const double first[3] = {0.313905, 0.442411, 0},
                        total[3] = {0.557589, 0.442411, 0.243684};
    const double variance = 13.844588;
    mcv_tolerances t;
    (void)state;
    read_well(kinds, 3, no_texts, &t);
    for (int noisy = 0; noisy < 2; ++noisy) {
        const mcv_propagation p = {&t, 0, 10000, true};
        const mcv_propagated f =
            propagate(&p, ishigami, (noises){0, noisy ? sqrt(variance / 3) : 0}, 23);
        assert_near(f.deviation.value, sqrt(variance), 0.05, "deviation");
        assert_near(f.mean, 3.5, 4 * 3.72 * sqrt(4.0 / 3) / sqrt(20000), "mean");
        for (int i = 0; i < 3; ++i) {
            const mcv_effect *e = f.effects + i;
            const double sigmas = 2; /* half a 95 % interval, doubled */
            assert_near(e->first.value, first[i], sigmas * (e->first.high - e->first.value), "S");
            assert_near(e->total.value, total[i], sigmas * (e->total.high - e->total.value), "T");
            assert_true(e->first.high - e->first.value < 0.06);
            assert_true(e->total.high - e->total.value < 0.06);
        }
        assert_true(f.order[0] == 0 && f.order[1] == 1 && f.order[2] == 2);
    }
}

/* --- coverage --- */

typedef struct tally {
    const char *what;
    size_t held, all;
} tally;

static void count(tally *t, mcv_bounded found, double truth) {
    ++t->all;
    t->held += found.low <= truth && truth <= found.high;
}

static void assert_held(const tally *t) {
    const double share = (double)t->held / (double)t->all;
    print_message("%s: %.1f %% of %zu\n", t->what, 100 * share, t->all);
    if (!(fabs(share - 0.95) <= margin))
        fail_msg("%s: the truth is within %.1f %% of the 95 %% intervals", t->what, 100 * share);
}

/*
 * Variances of the first order are right on average: the renders' noise, here 0.3 of each, is taken
 * off. An effect, half of a difference, has the variance s² = 0.045, and what is not taken off
 * would be 3 s²/5 = 0.027. One variance is known to 0.09, the root of 4 u² s²/5 + 2 · 3 s⁴/(5 · 4),
 * the mean of all to 0.002; a variance below 0, which is counted as 0, is beyond 2.3 deviations and
 * adds 0.0003.
 */
static void test_noise_is_no_variance(void **state) {
    static const char *const kinds[] = {"normal(10,0.1)", "uniform(0,0.3)", "triangular(-1,0.2)"};
    const double u2 = 0.09 + 0.12 + 0.01 / 6;
    double mean = 0;
    mcv_tolerances t;
    (void)state;
    read_well(kinds, 3, no_texts, &t);
    for (uint32_t i = 0; i < CASES; ++i) {
        const mcv_propagation p = {&t, 5, 0, false};
        const mcv_propagated f = propagate(&p, linear, (noises){0.5, 0.3}, 9000 + i);
        mean += f.linear.value * f.linear.value / CASES;
    }
    assert_near(mean, u2, 4 * 0.09 / sqrt(CASES) + 0.0003, "mean variance of the first order");
}

/* Noise as large as the parameters' own deviation in the trials, and as the smallest effect in the
 * first order. */
static void test_coverage(void **state) {
    static const char *const kinds[] = {"normal(10,0.1)", "uniform(0,0.3)", "triangular(-1,0.2)"};
    tally deviation = {"deviation", 0, 0}, first_order = {"first order", 0, 0},
          nominal = {"nominal", 0, 0}, effect = {"effect", 0, 0}, within = {"interval", 0, 0},
          loud = {"first order of little", 0, 0};
    const double c[3] = {0.3, -0.6 / sqrt(3), 0.1 / sqrt(6)},
                 u = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    mcv_tolerances t;
    (void)state;
    read_well(kinds, 3, no_texts, &t);
    for (uint32_t i = 0; i < CASES; ++i) {
        const mcv_propagation p = {&t, 5, 200, false};
        mcv_propagated f = propagate(&p, linear, (noises){0.5, 0.1}, 1000 + i);
        const double half = 2.776445 * f.nominal_error, /* Student's t of 4 degrees of freedom */
            one = 2.776445 * f.effects[0].effect_error;
        count(&deviation, f.deviation, u);
        count(&first_order, f.linear, u);
        count(&nominal, (mcv_bounded){0, f.nominal - half, f.nominal + half}, 34.5);
        count(&effect, (mcv_bounded){0, f.effects[0].effect - one, f.effects[0].effect + one},
              c[0]);
        mcv_noise noise = mcv_noise_begin(99, 5, i);
        double scores[3], x[3];
        for (int k = 0; k < 3; ++k) scores[k] = mcv_noise_normal(&noise);
        mcv_tolerances_draw(&t, scores, x);
        count(&within, (mcv_bounded){0, f.low, f.high}, linear(x));
        f = propagate(&p, linear, (noises){0.5, 2}, 5000 + i);
        count(&loud, f.linear, u);
    }
    assert_held(&deviation);
    assert_held(&first_order);
    assert_held(&nominal);
    assert_held(&effect);
    assert_held(&within);
    assert_true((double)loud.held / (double)loud.all > 0.95 - margin);
}

static void test_coverage_of_indices(void **state) {
    static const char *const kinds[] = {"uniform(0,3.141592653589793)",
                                        "uniform(0,3.141592653589793)",
                                        "uniform(0,3.141592653589793)"};
    tally first = {"first", 0, 0}, total = {"total", 0, 0}, deviation = {"deviation", 0, 0};
    mcv_tolerances t;
    (void)state;
    read_well(kinds, 3, no_texts, &t);
    for (uint32_t i = 0; i < CASES; ++i) {
        const mcv_propagation p = {&t, 0, 200, true};
        const mcv_propagated f = propagate(&p, ishigami, (noises){0, 1.5}, 7000 + i);
        count(&first, f.effects[0].first, 0.313905);
        count(&total, f.effects[1].total, 0.442411);
        count(&deviation, f.deviation, sqrt(13.844588));
    }
    assert_held(&first);
    assert_held(&total);
    assert_held(&deviation);
}

/* A failed point takes its repeat or its trial with it, no more. */
static void test_failed_points(void **state) {
    static const char *const kinds[] = {"normal(10,0.1)"};
    enum { REPEATS = 3, TRIALS = 12, POINTS = 3 * REPEATS + TRIALS };
    double points[2 * POINTS];
    mcv_tolerances t;
    mcv_propagated f;
    mcv_error error;
    (void)state;
    read_well(kinds, 1, no_texts, &t);
    const mcv_propagation p = {&t, REPEATS, TRIALS, false};
    assert_int_equal(mcv_propagation_points(&p), POINTS);
    for (size_t i = 0; i < POINTS; ++i) {
        uint32_t offset;
        double x;
        mcv_propagation_point(&p, i, 0, &x, &offset);
        points[2 * i] = i == 4 || i == 3 * REPEATS + 7 ? NAN : 2 * x;
        points[2 * i + 1] = 0;
    }
    assert_int_equal(mcv_propagate(&p, points, 2, &f, &error), MCV_OK);
    assert_true(f.repeats == REPEATS - 1 && f.trials == TRIALS - 1);
    assert_near(f.linear.value, 0.2, 1e-12, "GUM");
    for (size_t i = 0; i < POINTS; ++i) points[2 * i] = NAN;
    assert_int_equal(mcv_propagate(&p, points, 2, &f, &error), MCV_OK);
    assert_true(f.repeats == 0 && f.trials == 0 && isnan(f.mean) && isnan(f.linear.value));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_says_what_is_wrong),
                                       cmocka_unit_test(test_distributions),
                                       cmocka_unit_test(test_correlated_draws),
                                       cmocka_unit_test(test_a_linear_metric),
                                       cmocka_unit_test(test_a_product_is_flagged),
                                       cmocka_unit_test(test_a_square),
                                       cmocka_unit_test(test_indices_of_ishigami),
                                       cmocka_unit_test(test_coverage),
                                       cmocka_unit_test(test_coverage_of_indices),
                                       cmocka_unit_test(test_failed_points),
                                       cmocka_unit_test(test_curvature_is_no_interaction),
                                       cmocka_unit_test(test_noise_is_no_variance)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
