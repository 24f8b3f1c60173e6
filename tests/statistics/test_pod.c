/* SPDX-License-Identifier: Apache-2.0 */
/* Probability of detection: closed forms, symmetry, separation, and when there is no number. */
#include "test.h"

#include <math.h>
#include <string.h>

#include "analysis/noise.h"
#include "statistics/distributions.h"
#include "statistics/pod.h"

enum { COUNT = 240 };

static double sizes[COUNT], values[COUNT];

static mcv_pod_data signals(size_t count, double threshold) {
    return (mcv_pod_data){.sizes = sizes,
                          .signals = values,
                          .count = count,
                          .threshold = threshold,
                          .low = NAN,
                          .high = NAN,
                          .size_scale = MCV_POD_LINEAR,
                          .signal_scale = MCV_POD_LINEAR,
                          .confidence = 0.95};
}

static mcv_pod_data hits(size_t count) {
    return (mcv_pod_data){.sizes = sizes,
                          .hits = values,
                          .count = count,
                          .size_scale = MCV_POD_LINEAR,
                          .confidence = 0.95};
}

static mcv_pod fit(const mcv_pod_data *data) {
    mcv_error error = {""};
    mcv_pod pod;
    if (mcv_pod_fit(data, &pod, &error) != MCV_OK) fail_msg("%s", error.text);
    return pod;
}

static void expect(const char *what, double found, double truth, double most) {
    if (!(fabs(found - truth) <= most)) fail_msg("%s: %.12g, must be %.12g", what, found, truth);
}

/* y = x ± s: each size has one signal above and one below, so that the line is known exactly. POD =
 * Φ((a - threshold)/s), s with n - 2 degrees of freedom. */
static void make_line(size_t count, double scatter) {
    for (size_t i = 0; i < count; ++i) {
        sizes[i] = 1 + (double)(i / 2);
        values[i] = sizes[i] + (i % 2 ? scatter : -scatter);
    }
}

static void test_line(void **state) {
    (void)state;
    make_line(40, 2);
    const mcv_pod_data data = signals(40, 8);
    mcv_pod pod = fit(&data);
    const double s = 2 * sqrt(40.0 / 38);
    expect("intercept", pod.response.intercept, 0, 1e-12);
    expect("slope", pod.response.slope, 1, 1e-13);
    expect("scatter", pod.response.scatter, s, 1e-12);
    expect("a50", pod.a50.value, 8, 1e-9);
    expect("a90", pod.a90.value, 8 + mcv_normal_quantile(0.9) * s, 1e-9);
    for (double a = 1; a <= 20; ++a)
        expect("POD", mcv_pod_at(&pod, a).value, mcv_normal_cdf((a - 8) / s), 1e-12);
    /* A bound of a POD and that of a size are one. */
    expect("lower bound at a90/95", mcv_pod_at(&pod, pod.a90.high).low, 0.9, 1e-7);
    expect("upper bound at the lower size", mcv_pod_at(&pod, pod.a90.low).high, 0.9, 1e-7);
    assert_true(pod.a90.low < pod.a90.value && pod.a90.value < pod.a90.high);
    mcv_pod_free(&pod);
}

/* a90/95 near the middle of the sizes and far from it: numbers by SciPy's noncentral t. */
static void test_far_from_the_mean(void **state) {
    (void)state;
    make_line(40, 2);
    mcv_pod_data data = signals(40, 8);
    mcv_pod pod = fit(&data);
    expect("a90/95, near", pod.a90.high, 11.4964950885, 1e-8);
    mcv_pod_free(&pod);
    data.threshold = 13;
    pod = fit(&data);
    expect("a90/95, far", pod.a90.high, 16.6947134146, 1e-8);
    mcv_pod_free(&pod);
}

/* Other units of sizes and signals are the same experiment. */
static void test_units(void **state) {
    (void)state;
    make_line(40, 2);
    const mcv_pod_data data = signals(40, 8);
    mcv_pod pod = fit(&data);
    const double bound = pod.a90.high;
    mcv_pod_free(&pod);
    for (size_t i = 0; i < 40; ++i) {
        sizes[i] *= 1e-6;
        values[i] = 300 + 1e4 * values[i];
    }
    const mcv_pod_data scaled = signals(40, 300 + 8e4);
    pod = fit(&scaled);
    expect("a90/95 in micrometres", pod.a90.high * 1e6, bound, 1e-8);
    mcv_pod_free(&pod);
}

/* Limits that no signal reaches change nothing but the way to the bound: the bootstrap of 999
 * resamples instead of the noncentral t. Its quantile's standard error is √(0.05 0.95/999) =
 * 0.7 % of probability, 0.07 deviations of the bound's; four of these are 0.28. */
static void test_bootstrap(void **state) {
    (void)state;
    make_line(40, 2);
    const mcv_pod_data data = signals(40, 8);
    mcv_pod pod = fit(&data);
    mcv_pod_data limited = data;
    limited.low = -0.9; /* the smallest signal is -1 */
    mcv_pod same = fit(&limited);
    assert_int_equal(same.response.lost, 1);
    const double deviation = (pod.a90.high - pod.a90.low) / (2 * mcv_normal_quantile(0.95));
    expect("slope", same.response.slope, 1, 0.01); /* a tenth of one residual at the end */
    expect("a90/95", same.a90.high, pod.a90.high, 0.28 * deviation);
    mcv_pod_free(&same);
    mcv_pod_free(&pod);
}

/* Signals above 15 are saturated: the line is that of the others and of the tail. Turned upside
 * down they are lost ones below -15, with the line turned. */
static void test_saturated(void **state) {
    (void)state;
    make_line(40, 2);
    mcv_pod_data data = signals(40, 8);
    data.high = 15;
    mcv_pod pod = fit(&data);
    assert_int_equal(pod.response.saturated, 12);
    /* Clipped at 15 a line of least squares would have a slope of 0.80. */
    expect("slope", pod.response.slope, 1, 0.05);
    const double slope = pod.response.slope, intercept = pod.response.intercept;
    mcv_pod_free(&pod);
    for (size_t i = 0; i < 40; ++i) values[i] = -values[i];
    data.high = NAN;
    data.low = -15;
    pod = fit(&data);
    assert_int_equal(pod.response.lost, 12);
    expect("turned slope", pod.response.slope, -slope, 1e-9);
    expect("turned intercept", pod.response.intercept, -intercept, 1e-8);
    mcv_pod_free(&pod);
}

/* Hits and misses about the middle: both turned around give the curve turned around. */
static void test_hits(void **state) {
    (void)state;
    static const int found[13] = {0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 10}; /* of ten each */
    size_t n = 0;
    for (int i = 0; i < 13; ++i)
        for (int k = 0; k < 10; ++k) {
            sizes[n] = i + 1;
            values[n++] = k < found[i];
        }
    const mcv_pod_data data = hits(n);
    mcv_pod pod = fit(&data);
    expect("a50", pod.a50.value, 7, 1e-6);
    expect("turned", mcv_pod_at(&pod, 9).value, 1 - mcv_pod_at(&pod, 5).value, 1e-9);
    expect("turned bounds", mcv_pod_at(&pod, 9).low, 1 - mcv_pod_at(&pod, 5).high, 1e-6);
    expect("lower bound at a90/95", mcv_pod_at(&pod, pod.a90.high).low, 0.9, 1e-6);
    /* The score: hits are as many as the curve expects, and at the same mean size. */
    double sum = 0, moment = 0;
    for (size_t i = 0; i < n; ++i) {
        sum += values[i] - mcv_pod_at(&pod, sizes[i]).value;
        moment += sizes[i] * (values[i] - mcv_pod_at(&pod, sizes[i]).value);
    }
    expect("score", sum, 0, 1e-6);
    expect("score of sizes", moment, 0, 1e-5);
    mcv_pod_free(&pod);
}

/* One size parts misses from hits: Firth's curve is finite, and its middle is there. */
static void test_separation(void **state) {
    (void)state;
    for (size_t i = 0; i < 40; ++i) {
        sizes[i] = (double)(i + 1);
        values[i] = i >= 20;
    }
    const mcv_pod_data data = hits(40);
    mcv_pod pod = fit(&data);
    assert_true(pod.hit_miss.penalised);
    assert_true(isfinite(pod.hit_miss.slope) && pod.hit_miss.slope > 0);
    expect("a50", pod.a50.value, 20.5, 1e-6);
    assert_int_equal(pod.a90.high_known, MCV_POD_FOUND);
    assert_true(pod.a90.high > pod.a90.value && pod.a90.high < 40);
    mcv_pod_free(&pod);
    values[25] = 0; /* no separation any more */
    pod = fit(&data);
    assert_false(pod.hit_miss.penalised);
    mcv_pod_free(&pod);
}

static void expect_unknown(const mcv_pod_data *data, mcv_pod_known known) {
    mcv_pod pod = fit(data);
    assert_int_equal(pod.a90.high_known, known);
    assert_true(known == MCV_POD_SMALLER || isnan(pod.a90.high));
    mcv_pod_free(&pod);
}

static void test_no_number(void **state) {
    (void)state;
    make_line(40, 2);
    mcv_pod_data data = signals(40, 19.5);
    expect_unknown(&data, MCV_POD_LARGER);
    data.threshold = -100;
    expect_unknown(&data, MCV_POD_SMALLER);
    for (size_t i = 0; i < 40; ++i) values[i] = -values[i];
    data.threshold = -8;
    expect_unknown(&data, MCV_POD_FALLING);
    for (size_t i = 0; i < 40; ++i) values[i] = i >= 37;
    values[20] = 1;
    data = hits(40);
    expect_unknown(&data, MCV_POD_TOO_FEW); /* four hits */
}

static void expect_refused(const mcv_pod_data *data, const char *words) {
    mcv_error error = {""};
    mcv_pod pod;
    assert_int_equal(mcv_pod_fit(data, &pod, &error), MCV_BAD_INPUT);
    if (!strstr(error.text, words)) fail_msg("\"%s\" does not say \"%s\"", error.text, words);
    mcv_pod_free(&pod);
}

static void test_bad_input(void **state) {
    (void)state;
    make_line(40, 2);
    mcv_pod_data data = signals(9, 8);
    expect_refused(&data, "too few");
    data = signals(40, 8);
    values[3] = NAN;
    expect_refused(&data, "signal 4");
    make_line(40, 0);
    expect_refused(&data, "without any scatter");
    make_line(40, 2);
    data.low = 15;
    data.high = 15.5;
    expect_refused(&data, "too few for a line");
    data = signals(40, 8);
    data.signal_scale = MCV_POD_LOG; /* the smallest signal is -1 */
    expect_refused(&data, "above 0");
    sizes[5] = -1;
    expect_refused(&data, "size 6");
    for (size_t i = 0; i < 40; ++i) sizes[i] = 3;
    data = signals(40, 8);
    expect_refused(&data, "one size");
    for (size_t i = 0; i < 40; ++i) sizes[i] = (double)(1 + i), values[i] = 1;
    data = hits(40);
    expect_unknown(&data, MCV_POD_TOO_FEW);
    mcv_pod pod = fit(&data);
    assert_true(!pod.fitted && isnan(mcv_pod_at(&pod, 3).value));
    mcv_pod_free(&pod);
    values[1] = 0.5;
    expect_refused(&data, "hit 2");
}

/* The scales in which data were made are those that are chosen. */
static void test_scales(void **state) {
    (void)state;
    for (int k = 0; k < 4; ++k) {
        mcv_noise noise = mcv_noise_begin(3, 0, (uint64_t)k);
        for (size_t i = 0; i < COUNT; ++i) {
            sizes[i] = 0.2 * pow(50, ((double)i + 0.5) / COUNT);
            const double x = k & 1 ? 3 * log(sizes[i]) : sizes[i];
            const double y = x + 0.4 * mcv_noise_normal(&noise);
            values[i] = k & 2 ? exp(y) : 20 + y;
        }
        mcv_pod_data data = signals(COUNT, 21);
        data.size_scale = data.signal_scale = MCV_POD_AUTO;
        mcv_pod pod = fit(&data);
        if (pod.log_size != ((k & 1) != 0) || pod.log_signal != ((k & 2) != 0))
            fail_msg("made with %d, taken for %d %d", k, pod.log_size, pod.log_signal);
        /* Nothing is wrong with them. */
        assert_true(pod.checks.linear > 1e-3 && pod.checks.even > 1e-3);
        assert_true(pod.checks.normal > 1e-3);
        mcv_pod_free(&pod);
    }
}

/* Checks see what is planted: a bend, a scatter that grows, residuals with a long tail. */
static void test_checks(void **state) {
    (void)state;
    for (int k = 0; k < 3; ++k) {
        mcv_noise noise = mcv_noise_begin(4, 0, (uint64_t)k);
        for (size_t i = 0; i < COUNT; ++i) {
            const double x = 0.2 + 0.04 * (double)i, e = mcv_noise_normal(&noise);
            sizes[i] = x;
            values[i] = k == 0 ? x * x + e : k == 1 ? x + x * e : x + exp(e);
        }
        const mcv_pod_data data = signals(COUNT, 5);
        mcv_pod pod = fit(&data);
        const double p[3] = {pod.checks.linear, pod.checks.even, pod.checks.normal};
        if (!(p[k] < 1e-4)) fail_msg("fault %d has p = %g", k, p[k]);
        mcv_pod_free(&pod);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_line),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_bootstrap),
        cmocka_unit_test(test_hits),
        cmocka_unit_test(test_separation),
        cmocka_unit_test(test_no_number),
        cmocka_unit_test(test_bad_input),
        cmocka_unit_test(test_scales),
        cmocka_unit_test(test_checks),
        cmocka_unit_test(test_saturated),
        cmocka_unit_test(test_far_from_the_mean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
