/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers on an experiment's page: the units that were typed, and uncertainties in brackets. */
#include "test.h"

#include "experiment/units.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void check_unit(mcv_shown_unit unit, const char *name, double si, double shown) {
    if (strcmp(unit.name, name) != 0 || !(fabs(si * unit.per_si - shown) <= 1e-15 * fabs(shown)))
        fail_msg("%g is %g %s, not %g %s", si, si * unit.per_si, unit.name, shown, name);
}

static mcv_shown_unit of_parameter(const char *item) {
    const mcv_parameter p = {.item = item, .path_length = (int)strcspn(item, "=")};
    return mcv_unit_of_parameter(&p);
}

static void test_parameters(void **state) {
    (void)state;
    check_unit(of_parameter("emitters/a/halfAngle=0.1deg..2deg:8:log"), "°", M_PI / 180, 1);
    check_unit(of_parameter("nodes/back/distance=80mm,90mm"), "mm", 0.08, 80);
    check_unit(of_parameter("nodes/back/distance=0.08,90mm"), "mm", 0.08, 80); /* the first unit */
    check_unit(of_parameter("a/b=1 um..2 um:3"), "µm", 1e-6, 1);
    check_unit(of_parameter("a/b=1µm,2µm"), "µm", 1e-6, 1);
    check_unit(of_parameter("a/b=1inch"), "inch", 0.0254, 1);
    check_unit(of_parameter("sensors/c/fNumber=4,8,16"), "", 8, 8);
    check_unit(of_parameter("sensors/c/fNumber=1e0..1e1:3:log"), "", 8, 8);
    const mcv_parameter tie = {.item = "a/b=2*c+10mm", .path_length = 3, .expression = "2*c+10mm"};
    check_unit(mcv_unit_of_parameter(&tie), "", 8, 8); /* an expression's unit is not known */
}

static mcv_metric_units units_of(const char *values) {
    return (mcv_metric_units){.values = values, .step = "m"};
}

static void test_metrics(void **state) {
    (void)state;
    check_unit(mcv_unit_of_metric("left.position", units_of("DN"), 1), "pixels", 3, 3);
    check_unit(mcv_unit_of_metric("u(left.position)", units_of("DN"), 1), "pixels", 3, 3);
    check_unit(mcv_unit_of_metric("bore.diameter_length", units_of("DN"), 0.012), "mm", 0.012, 12);
    check_unit(mcv_unit_of_metric("bore.roundness_length", units_of("DN"), 2e-6), "µm", 2e-6, 2);
    check_unit(mcv_unit_of_metric("right.length", units_of("DN"), 2), "m", 2, 2);
    check_unit(mcv_unit_of_metric("tilt", units_of("DN"), 1), "°", M_PI, 180);
    check_unit(mcv_unit_of_metric("mtf50", units_of("DN"), 1), "cycles/pixel", 0.25, 0.25);
    check_unit(mcv_unit_of_metric("dent.mean", units_of("DN"), 1), "DN", 7, 7);
    check_unit(mcv_unit_of_metric("mean", units_of("W/m²"), 1), "W/m²", 7, 7);
    check_unit(mcv_unit_of_metric("dent.contrast_to_noise", units_of("DN"), 1), "", 7, 7);
    check_unit(mcv_unit_of_metric("a.position-b.position", units_of("DN"), 1), "", 7, 7);
    check_unit(mcv_unit_of_metric("plate.bound", units_of("DN"), 2e-6), "µm", 2e-6, 2);
    check_unit(mcv_unit_of_metric("mean*2", units_of("DN"), 1), "", 7, 7);
}

static void check_words(double value, double uncertainty, const char *wanted) {
    char words[48];
    mcv_value_words(value, uncertainty, words);
    if (strcmp(words, wanted) != 0)
        fail_msg("%g and %g are \"%s\", not \"%s\"", value, uncertainty, words, wanted);
}

/* By hand: the last two digits of the value are those of the uncertainty. */
static void test_values(void **state) {
    (void)state;
    check_words(12.3456, 0.0021, "12.3456(21)");
    check_words(12.3456, 0.00996, "12.346(10)"); /* 0.00996 is 0.010 to two digits */
    check_words(-0.5, 0.25, "-0.50(25)");
    check_words(12.3, 4.2, "12.3(42)");
    check_words(123, 42, "123(42)");
    check_words(12.3, 42, "12 ± 42"); /* larger than the value */
    check_words(1234, 420, "1234 ± 4.2e+02");
    check_words(1.5e-5, 2e-6, "1.5e-05 ± 2e-06");
    check_words(1.5, 0, "1.5");
    check_words(1.5, NAN, "1.5");
    check_words(NAN, 1, "");
}

static void test_exact(void **state) {
    static const double values[] = {0.1, 1.0 / 3, 0.0057848135508536, 8, 1e-300, -2.5};
    char words[32];
    (void)state;
    for (size_t i = 0; i < sizeof values / sizeof values[0]; ++i) {
        mcv_exact_words(values[i], words);
        assert_true(strtod(words, NULL) == values[i]);
    }
    mcv_exact_words(0.1, words);
    assert_string_equal(words, "0.1");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parameters),
        cmocka_unit_test(test_metrics),
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_exact),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
