/* SPDX-License-Identifier: Apache-2.0 */
/* mcvisi uncertainty: a scene whose metric is known in closed form, its files, and bad input. */
#include "experiment_files.h"

#include <math.h>

/* A panel that fills the view of a pinhole camera: each pixel has its radiance, without noise. */
static const char scene[] = PANEL_SCENE("[12,8]", "0.0001", "[4,4]", "2.5");

#define STUDY "uncertainty s.gltf --metric mean --spp 4 "
#define RADIANCE "--tolerance 'emitters/panel/radiance=normal(0.1)' "

static void assert_near(double value, double truth, double tolerance, const char *what) {
    if (!(fabs(value - truth) <= tolerance))
        fail_msg("%s: %.10g, not %.10g within %g", what, value, truth, tolerance);
}

/* The mean is the radiance: its standard uncertainty is that of the tolerance. A shift of the
 * camera along its view does nothing. */
static void test_the_radiance(void **state) {
    (void)state;
    json_t *report = program_json(
        STUDY RADIANCE "--tolerance 'nodes/camera/shiftZ=uniform(1mm)' --trials 100 --json");
    assert_near(number_at(report, "metrics/mean/first_order/centre/value"), 2.5, 1e-6, "centre");
    /* Pixels are float32. */
    assert_near(number_at(report, "metrics/mean/first_order/uncertainty/value"), 0.1, 1e-6, "GUM");
    assert_near(number_at(report, "metrics/mean/monte_carlo/uncertainty/value"), 0.1,
                4 * 0.1 / sqrt(200), "Monte Carlo");
    assert_true(number_at(report, "metrics/mean/monte_carlo/uncertainty/interval/0") < 0.1);
    assert_true(number_at(report, "metrics/mean/monte_carlo/uncertainty/interval/1") > 0.1);
    assert_string_equal(json_string_value(value_at(report, "metrics/mean/effects/0/parameter")),
                        "radiance");
    assert_near(number_at(report, "metrics/mean/effects/0/share"), 1, 1e-5, "share");
    assert_near(number_at(report, "metrics/mean/effects/1/effect/value"), 0, 1e-6,
                "a shift's effect");
    assert_true(json_is_false(value_at(report, "metrics/mean/nonlinear")));
    /* 4 repeats of the centre, 2 · 2 steps and 2 · 2 of all together; 100 trials. */
    assert_near(number_at(report, "rows"), 4 * 9 + 100, 0, "rows");
    json_decref(report);
    const char *page = read_whole("s-uncertainty.html");
    assert_non_null(strstr(page, "Uncertainty of s.gltf"));
    assert_non_null(strstr(page, "The largest contribution is that of radiance"));
    assert_non_null(strstr(page, "data:image/png;base64,"));
    assert_non_null(strstr(page, "only the tolerances that are listed below vary"));
}

/* What is tied to a tolerance follows it: 300 · 0.1 mm. From a file, first order only. */
static void test_a_tie_follows(void **state) {
    (void)state;
    write_file("e.json",
               "{\"rig\": \"s.gltf\", \"tolerance\": \"sensors/cam/imageDistance="
               "normal(10mm,0.1mm)\", \"tie\": \"emitters/panel/radiance=300*imageDistance\", "
               "\"metric\": \"mean\", \"spp\": 4, \"trials\": 0}");
    json_t *report = program_json("uncertainty e.json --json");
    assert_near(number_at(report, "metrics/mean/first_order/uncertainty/value"), 0.03, 1e-6, "GUM");
    assert_null(json_object_get(value_at(report, "metrics/mean"), "monte_carlo"));
    json_decref(report);
    assert_int_equal(system("test -s e-uncertainty.csv -a -s e-uncertainty.json -a -s "
                            "e-uncertainty.html"),
                     0);
}

/* The table is continued, and what it has is not rendered again; the report is the same. */
static void test_resumes(void **state) {
    (void)state;
    json_t *first = program_json(STUDY RADIANCE "--trials 20 --indices --json");
    assert_int_equal(system("head -30 s-uncertainty.csv >part.csv && cp part.csv "
                            "s-uncertainty.csv"),
                     0);
    json_t *second = program_json(STUDY RADIANCE "--trials 20 --indices --resume --json");
    /* A table has ten digits. */
    const char *const same[] = {"first_order/uncertainty/value", "monte_carlo/uncertainty/value",
                                "monte_carlo/interval/0", "monte_carlo/mean/uncertainty"};
    for (size_t i = 0; i < sizeof same / sizeof same[0]; ++i) {
        char path[64];
        snprintf(path, sizeof path, "metrics/mean/%s", same[i]);
        assert_near(number_at(second, path), number_at(first, path), 1e-8, path);
    }
    /* One parameter: both indices are 1. */
    assert_near(number_at(second, "metrics/mean/effects/0/total_index/value"), 1, 0.7, "T");
    json_decref(first);
    json_decref(second);
    assert_int_equal(system("head -30 s-uncertainty.csv | cmp - part.csv"), 0);
}

static void test_bad_input(void **state) {
    (void)state;
    program_fails(STUDY, 2, "as in --tolerance 'nodes/part/turnX=normal(0.5deg)'");
    program_fails(STUDY "--tolerance 'emitters/panel/radiance=gauss(1)'", 2,
                  "must be normal(U), uniform(A) or triangular(A)");
    program_fails(STUDY "--tolerance emitters/panel/radiance", 2, "must be PATH=");
    program_fails(STUDY "--tolerance 'emitters/panel/radianse=normal(1)'", 3,
                  "did you mean \"radiance\"");
    program_fails(STUDY "--tolerance 'emitters/panel/type=normal(1)'", 3, "is no number");
    program_fails(STUDY "--tolerance 'sensors/cam/lensDiameter=normal(1mm)'", 3, "give the centre");
    program_fails(STUDY RADIANCE "--correlate radiance,radiance=0.5", 2, "two different");
    program_fails(STUDY RADIANCE "--repeats 1", 2, "--repeats 1: must be 2 or more");
    program_fails(STUDY RADIANCE "--trials 3", 2, "--trials 3: must be 10 or more");
    program_fails(STUDY RADIANCE "--repeats 0 --trials 0", 2, "nothing to do");
    program_fails(STUDY RADIANCE "--trials 0 --indices", 2, "--indices needs --trials");
    program_fails("uncertainty s.gltf " RADIANCE "--spp 4", 2, "--metric is missing");
}

int main(void) {
    const struct CMUnitTest tests[] = {FRESH(test_the_radiance, scene),
                                       FRESH(test_a_tie_follows, scene), FRESH(test_resumes, scene),
                                       FRESH(test_bad_input, scene)};
    return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
