/* SPDX-License-Identifier: Apache-2.0 */
/* Distributions and rates against tables: numbers of SciPy 1.17 and statsmodels 0.15. */
#include "test.h"

#include <math.h>

#include "analysis/statistics.h"
#include "statistics/distributions.h"
#include "statistics/rate.h"

static void expect(const char *what, double found, double truth, double most) {
    if (!(fabs(found - truth) <= most)) fail_msg("%s: %.15g, must be %.15g", what, found, truth);
}

static void test_noncentral_t(void **state) {
    static const double cases[][4] = {
        /* t, freedom, noncentrality, P */
        {0.5, 8, 0, 0.684731962222},     {2, 8, 1, 0.799879140786},
        {1, 38, -0.5, 0.931070659687},   {10, 38, 8.105, 0.886500804897},
        {25, 98, 24, 0.674172450199},    {-1, 20, 1.5, 0.006986537385},
        {150, 300, 145, 0.783287704729}, {1.5, 1000, 3, 0.066867870611}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        expect("noncentral t", mcv_noncentral_t_cdf(cases[i][0], cases[i][1], cases[i][2]),
               cases[i][3], 1e-9);
    /* Without noncentrality it is Student's t. */
    for (double t = 0.1; t < 8; t *= 2)
        expect("central t", mcv_noncentral_t_cdf(t, 17, 0), 1 - mcv_student_two_sided(t, 17) / 2,
               1e-11);
}

static void test_normal(void **state) {
    static const double cases[][2] = {{0.9, 1.281551565544600},
                                      {0.95, 1.644853626951472},
                                      {0.001, -3.090232306167813},
                                      {0.999999, 4.753424308817087},
                                      {1e-12, -7.034483825301131}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        expect("normal quantile", mcv_normal_quantile(cases[i][0]), cases[i][1], 1e-9);
    assert_true(mcv_normal_quantile(0.5) == 0 || fabs(mcv_normal_quantile(0.5)) < 1e-15);
    assert_true(isinf(mcv_normal_quantile(1)) && isinf(mcv_normal_quantile(0)));
    assert_true(isnan(mcv_normal_quantile(-0.1)) && isnan(mcv_normal_quantile(NAN)));
}

static void test_wilson(void **state) {
    static const struct {
        uint64_t hits, trials;
        double low, high, clopper;
    } cases[] = {{0, 10, 0, 0.277532799863, 0},
                 {5, 10, 0.236593090513, 0.763406909487, 0.222441101008},
                 {59, 61, 0.888105095805, 0.990962109602, 0.900365119806},
                 {240, 240, 0.984246080058, 1, 0.987595361950}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const mcv_interval w = mcv_wilson((double)cases[i].hits, (double)cases[i].trials, 0.95);
        expect("Wilson, low", w.low, cases[i].low, 1e-11);
        expect("Wilson, high", w.high, cases[i].high, 1e-11);
        expect("Clopper and Pearson", mcv_clopper_pearson_low(cases[i].hits, cases[i].trials, 0.95),
               cases[i].clopper, 1e-11);
    }
    expect("no trials", mcv_wilson(0, 0, 0.95).high, 1, 0);
}

/* Hits that prove a POD of 90 % with a confidence of 95 %: the classic demonstrations. */
static void test_demonstrations(void **state) {
    static const struct {
        uint64_t hits, trials;
        double chance; /* of so many hits where the POD is 90 % */
    } cases[] = {{29, 29, 0.0471}, {45, 46, 0.0480}, {59, 61, 0.0491}};
    (void)state;
    for (size_t i = 0; i < 3; ++i) {
        expect("chance", mcv_binomial_upper(cases[i].hits, cases[i].trials, 0.9), cases[i].chance,
               5e-5);
        assert_true(mcv_clopper_pearson_low(cases[i].hits, cases[i].trials, 0.95) > 0.9);
        assert_true(mcv_clopper_pearson_low(cases[i].hits - 1, cases[i].trials, 0.95) < 0.9);
    }
}

/* How often an interval holds its chance, exactly, as a sum over all outcomes. Averaged over the
 * chances it is what is said, within 1 %. For one chance it jumps, because hits are whole numbers:
 * by the tails of a few outcomes, which together are the 5 % that may be missed; from 0.1 to 0.9 it
 * stays above 90 %. */
static void test_wilson_coverage(void **state) {
    (void)state;
    for (uint64_t n = 10; n <= 240; n *= 2) {
        double mean = 0, least = 1;
        enum { CHANCES = 999 };
        for (int i = 1; i <= CHANCES; ++i) {
            const double p = (double)i / (CHANCES + 1);
            double covered = 0;
            for (uint64_t k = 0; k <= n; ++k) {
                const mcv_interval w = mcv_wilson((double)k, (double)n, 0.95);
                if (p >= w.low && p <= w.high)
                    covered += mcv_binomial_upper(k, n, p) - mcv_binomial_upper(k + 1, n, p);
            }
            mean += covered / CHANCES;
            if (p >= 0.1 && p <= 0.9) least = fmin(least, covered);
        }
        if (!(fabs(mean - 0.95) < 0.01 && least > 0.90))
            fail_msg("%d trials: Wilson covers %.4f on average, %.4f at least", (int)n, mean,
                     least);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_noncentral_t),    cmocka_unit_test(test_normal),
        cmocka_unit_test(test_wilson),          cmocka_unit_test(test_demonstrations),
        cmocka_unit_test(test_wilson_coverage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
