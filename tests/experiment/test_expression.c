/* SPDX-License-Identifier: Apache-2.0 */
/* Arithmetic in names, and the sets of parameters that designs make. */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/design.h"
#include "experiment/expression.h"

static mcv_result look_up(void *user, const char *name, mcv_quantity *quantity, mcv_error *error) {
    (void)user;
    if (strcmp(name, "a") == 0) *quantity = (mcv_quantity){3, 0.1};
    if (strcmp(name, "part.b_2") == 0) *quantity = (mcv_quantity){4, 0.2};
    return isnan(quantity->value) ? mcv_fail(error, MCV_USAGE, "there is no %s", name) : MCV_OK;
}

static void test_values(void **state) {
    static const struct {
        const char *text;
        double value, uncertainty;
    } cases[] = {
        {"1 + 2*3", 7, 0},
        {"-2^2", -4, 0},
        {"2^3^2", 512, 0},
        {"(1+2)*3 - 4/8", 8.5, 0},
        {"10 - 4 - 3", 3, 0},
        {"2mm + 3e2um", 2.3e-3, 0},
        {"90deg - pi/2", 0, 0},
        {"1.5 < 2 && 3 >= 3", 1, 0},
        {"1 > 2 || 0 != 0", 0, 0},
        {"max(2, min(5, 3)) + abs(-1)", 4, 0},
        {"sqrt(16) * exp(0) * log(1)", 0, 0},
        {"a", 3, 0.1},
        {"a - a", 0, 0}, /* the same noise */
        {"2 * a + 1", 7, 0.2},
        {"a + part.b_2", 7, 0.3}, /* the bound: 0.1 + 0.2 */
        {"a * part.b_2", 12, 0.1 * 4 + 0.2 * 3},
        {"u(part.b_2) / 2", 0.1, 0},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_error error = {""};
        mcv_quantity value;
        if (mcv_expression_evaluate(cases[i].text, look_up, NULL, &value, &error) != MCV_OK)
            fail_msg("%s: %s", cases[i].text, error.text);
        /* A few roundings of numbers below 600. */
        if (!(fabs(value.value - cases[i].value) <= 1e-12 &&
              fabs(value.uncertainty - cases[i].uncertainty) <= 1e-12))
            fail_msg("%s: %.17g ± %.17g", cases[i].text, value.value, value.uncertainty);
    }
}

static void test_wrong_text(void **state) {
    static const char *const texts[] = {"",        "1 +",    "(1",    "1)",      "2 3",
                                        "nothing", "max(1)", "f(2)",  "2parsec", "u(2)",
                                        "u(a",     "a..",    "1 ? 2", "min(1,2"};
    char deep[512];
    mcv_error error;
    mcv_quantity value;
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        error.text[0] = '\0';
        if (mcv_expression_evaluate(texts[i], look_up, NULL, &value, &error) != MCV_USAGE)
            fail_msg("\"%s\" is taken", texts[i]);
        assert_true(error.text[0]);
    }
    memset(deep, '(', sizeof deep - 1);
    deep[sizeof deep - 1] = '\0';
    assert_int_equal(mcv_expression_evaluate(deep, look_up, NULL, &value, &error), MCV_USAGE);
}

static mcv_levels levels_of(const char *text) {
    mcv_levels levels;
    mcv_error error = {""};
    if (mcv_levels_parse(text, &levels, &error) != MCV_OK) fail_msg("%s", error.text);
    return levels;
}

static void test_grid_and_list(void **state) {
    mcv_levels levels[] = {levels_of("1..3:3"), levels_of("1mm..100mm:3:log")};
    static const double truth[9][2] = {{1, 1e-3}, {1, 1e-2}, {1, 0.1},  {2, 1e-3}, {2, 1e-2},
                                       {2, 0.1},  {3, 1e-3}, {3, 1e-2}, {3, 0.1}};
    mcv_error error = {""};
    double *values;
    size_t sets;
    (void)state;
    assert_int_equal(mcv_design_make(MCV_DESIGN_GRID, levels, 2, 0, 0, &values, &sets, &error),
                     MCV_OK);
    assert_int_equal(sets, 9);
    for (int i = 0; i < 18; ++i)
        assert_true(fabs(values[i] - truth[i / 2][i % 2]) <= 1e-15 * truth[i / 2][i % 2] * 4);
    free(values);
    assert_int_equal(mcv_design_make(MCV_DESIGN_LIST, levels, 2, 0, 0, &values, &sets, &error),
                     MCV_OK);
    assert_int_equal(sets, 3);
    assert_true(values[0] == 1 && values[2] == 2 && values[4] == 3 && values[5] == 0.1);
    free(values);
    mcv_levels other[] = {levels_of("1,2"), levels_of("5")};
    assert_int_equal(mcv_design_make(MCV_DESIGN_LIST, other, 2, 0, 0, &values, &sets, &error),
                     MCV_USAGE);
    mcv_levels_free(other);
    mcv_levels_free(other + 1);
}

/* Each interval of 1/64 of each parameter holds one of 64 points: of a Latin hypercube by making,
 * of Sobol' points as nets. */
static void test_strata(void **state) {
    static const int designs[] = {MCV_DESIGN_LHS, MCV_DESIGN_SOBOL};
    enum { POINTS = 64 };
    mcv_levels levels[MCV_DESIGN_PARAMETERS];
    mcv_error error = {""};
    (void)state;
    for (int p = 0; p < MCV_DESIGN_PARAMETERS; ++p) levels[p] = levels_of("0..1");
    for (int d = 0; d < 2; ++d)
        for (uint32_t seed = 0; seed < 3; ++seed) {
            double *values;
            size_t sets;
            assert_int_equal(mcv_design_make(designs[d], levels, MCV_DESIGN_PARAMETERS, POINTS,
                                             seed, &values, &sets, &error),
                             MCV_OK);
            assert_int_equal(sets, POINTS);
            for (int p = 0; p < MCV_DESIGN_PARAMETERS; ++p) {
                uint64_t met = 0;
                for (int i = 0; i < POINTS; ++i)
                    met |= (uint64_t)1 << (int)(values[i * MCV_DESIGN_PARAMETERS + p] * POINTS);
                if (met != UINT64_MAX) fail_msg("design %d, parameter %d: strata are empty", d, p);
            }
            /* The first two parameters of Sobol' points: one point in each of 8 x 8 cells. */
            uint64_t cells = 0;
            for (int i = 0; i < POINTS; ++i)
                cells |= (uint64_t)1 << ((int)(values[i * MCV_DESIGN_PARAMETERS] * 8) * 8 +
                                         (int)(values[i * MCV_DESIGN_PARAMETERS + 1] * 8));
            if (designs[d] == MCV_DESIGN_SOBOL && cells != UINT64_MAX)
                fail_msg("the Sobol' points are no (0,2)-net");
            free(values);
        }
}

static void test_wrong_levels(void **state) {
    static const char *const texts[] = {"",       "1..",        "..2:3",  "1..2:0",
                                        "1..2:x", "1..2:3:lin", "1,,2",   "0..1:3:log",
                                        "nan",    "1..inf:2",   "1 apple"};
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        mcv_levels levels;
        mcv_error error = {""};
        if (mcv_levels_parse(texts[i], &levels, &error) != MCV_USAGE)
            fail_msg("\"%s\" is taken", texts[i]);
    }
    mcv_levels many[] = {levels_of("0..1:2000"), levels_of("0..1:2000")}, open = levels_of("0..1");
    double *values;
    size_t sets;
    mcv_error error = {""};
    assert_int_equal(mcv_design_make(MCV_DESIGN_GRID, many, 2, 0, 0, &values, &sets, &error),
                     MCV_USAGE);
    assert_int_equal(mcv_design_make(MCV_DESIGN_GRID, &open, 1, 0, 0, &values, &sets, &error),
                     MCV_USAGE);
    assert_int_equal(mcv_design_make(MCV_DESIGN_SOBOL, &open, 1, 0, 0, &values, &sets, &error),
                     MCV_USAGE);
    assert_int_equal(mcv_design_make(MCV_DESIGN_LIST, many, 1, 3, 0, &values, &sets, &error),
                     MCV_USAGE);
    assert_non_null(strstr(error.text, "--points 3"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),        cmocka_unit_test(test_wrong_text),
        cmocka_unit_test(test_grid_and_list), cmocka_unit_test(test_strata),
        cmocka_unit_test(test_wrong_levels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
