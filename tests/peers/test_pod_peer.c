/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* The probability of detection against SciPy and statsmodels, where `./run deps peers` has put
 * them. */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "analysis/noise.h"
#include "statistics/pod.h"

enum { COUNT = 80 };

#define PYTHON MCV_SOURCE_DIR "/build/peers/bin/python"

static double sizes[COUNT], values[COUNT];

static void make(int kind, uint64_t number) {
    mcv_noise noise = mcv_noise_begin(21, (uint32_t)kind, number);
    for (size_t i = 0; i < COUNT; ++i) {
        sizes[i] = 0.5 + 3 * mcv_noise_uniform(&noise);
        values[i] = kind == 2 ? mcv_noise_uniform(&noise) < 1 / (1 + exp(-3 * (sizes[i] - 1.5)))
                              : 1 + 2 * sizes[i] + mcv_noise_normal(&noise);
    }
}

/* What the peer prints; returns how many numbers. */
static int ask_peer(int kind, const mcv_pod_data *data, double *numbers, int most) {
    static const char path[] = "test_pod_peer.bin";
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    const double head[4] = {kind, data->threshold, data->low, data->high};
    assert_int_equal(fwrite(head, sizeof head, 1, file), 1);
    for (size_t i = 0; i < COUNT; ++i) {
        const double pair[2] = {sizes[i], values[i]};
        assert_int_equal(fwrite(pair, sizeof pair, 1, file), 1);
    }
    assert_int_equal(fclose(file), 0);
    FILE *peer = popen(PYTHON " " MCV_SOURCE_DIR "/tests/peers/pod_peer.py test_pod_peer.bin", "r");
    assert_non_null(peer);
    char text[64];
    int count = 0;
    while (count < most && fgets(text, sizeof text, peer)) numbers[count++] = strtod(text, NULL);
    assert_int_equal(pclose(peer), 0);
    unlink(path);
    return count;
}

/* Both solve the same equations to about 1e-8. */
static void compare(const char *what, double ours, double theirs) {
    if (!(fabs(ours - theirs) <= 1e-6 * (1e-3 + fabs(theirs))))
        fail_msg("%s: %.12g by ours, %.12g by the peer", what, ours, theirs);
}

static void compare_one(int kind, uint64_t number) {
    mcv_pod_data data = {.sizes = sizes,
                         .signals = kind == 2 ? NULL : values,
                         .hits = kind == 2 ? values : NULL,
                         .count = COUNT,
                         .threshold = 4,
                         .low = kind == 1 ? 2.5 : NAN,
                         .high = kind == 1 ? 6.5 : NAN,
                         .size_scale = MCV_POD_LINEAR,
                         .signal_scale = MCV_POD_LINEAR,
                         .confidence = 0.95};
    double theirs[8];
    mcv_error error = {""};
    mcv_pod pod;
    make(kind, number);
    if (mcv_pod_fit(&data, &pod, &error) != MCV_OK) fail_msg("%s", error.text);
    const int count = ask_peer(kind, &data, theirs, 8);
    assert_int_equal(count, kind == 0 ? 8 : 4);
    compare("intercept", kind == 2 ? pod.hit_miss.intercept : pod.response.intercept, theirs[0]);
    compare("slope", kind == 2 ? pod.hit_miss.slope : pod.response.slope, theirs[1]);
    if (kind < 2) compare("scatter", pod.response.scatter, theirs[2]);
    if (kind < 2) compare("likelihood", pod.response.log_likelihood, theirs[3]);
    if (kind == 2) compare("likelihood", pod.hit_miss.log_likelihood, theirs[2]);
    if (kind != 1) compare("a90/95", pod.a90.high, theirs[kind == 2 ? 3 : 4]);
    if (kind == 0) compare("linear", pod.checks.linear, theirs[5]);
    if (kind == 0) compare("even", pod.checks.even, theirs[6]);
    if (kind == 0) compare("normal", pod.checks.normal, theirs[7]);
    mcv_pod_free(&pod);
}

static void test_against_peers(void **state) {
    (void)state;
    if (access(PYTHON, X_OK) != 0 ||
        system(PYTHON " -c 'import scipy, statsmodels' 2>/dev/null") != 0) {
        puts("SciPy and statsmodels are not there: `./run deps peers` installs them");
        skip();
    }
    for (int kind = 0; kind < 3; ++kind)
        for (uint64_t number = 0; number < 5; ++number) compare_one(kind, number);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_peers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
