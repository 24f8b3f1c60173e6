/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label slow */
/* Sobol' indices against SALib, a library of others, where `./run deps peers` has put it. */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "uncertainty/propagation.h"

enum { TRIALS = 4000, PARAMETERS = 3, POINTS = PARAMETERS + 2 };

static const char python[] = MCV_SOURCE_DIR "/build/peers/bin/python";

/* Of Ishigami and Homma, at our points; in the order of SALib. */
static void make_values(const mcv_propagation *p, double values[][2], double *theirs) {
    for (size_t i = 0; i < (size_t)TRIALS * POINTS; ++i) {
        const size_t trial = i / POINTS, at = i % POINTS,
                     place = at == 0   ? 0
                             : at == 1 ? PARAMETERS + 1
                                       : at - 1;
        double x[MCV_DESIGN_PARAMETERS];
        uint32_t offset;
        mcv_propagation_point(p, i, 5, x, &offset);
        values[i][0] = sin(x[0]) + 7 * sin(x[1]) * sin(x[1]) + 0.1 * pow(x[2], 4) * sin(x[0]);
        values[i][1] = 0;
        theirs[trial * POINTS + place] = values[i][0];
    }
}

static void read_theirs(const double *values, double found[][2]) {
    char command[512];
    FILE *file = fopen("sobol.bin", "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(values, sizeof *values, (size_t)TRIALS * POINTS, file),
                     (size_t)TRIALS * POINTS);
    assert_int_equal(fclose(file), 0);
    snprintf(command, sizeof command, "%s %s/tests/peers/sobol_peer.py sobol.bin %d", python,
             MCV_SOURCE_DIR, PARAMETERS);
    FILE *peer = popen(command, "r");
    assert_non_null(peer);
    assert_int_equal(fread(found, 2 * sizeof(double), PARAMETERS, peer), PARAMETERS);
    assert_int_equal(pclose(peer), 0);
}

/* The same estimators; we subtract the mean of A and B, they that of all. The difference is that
 * of the means, of the order of σ/√n, times the mean of A_i - A, as small: some 1/n of the
 * variance. */
static void test_against_salib(void **state) {
    static double values[TRIALS * POINTS][2], theirs[TRIALS * POINTS];
    char command[512];
    double found[PARAMETERS][2];
    mcv_tolerances t = {.count = PARAMETERS};
    mcv_propagated ours;
    mcv_error error;
    (void)state;
    snprintf(command, sizeof command, "%s -c 'import SALib' 2>/dev/null", python);
    if (access(python, X_OK) != 0 || system(command) != 0) {
        puts("SALib is not there: `./run deps peers` installs it");
        skip();
    }
    for (size_t i = 0; i < PARAMETERS; ++i) {
        t.of[i] = (mcv_distribution){MCV_DISTRIBUTION_UNIFORM, 0, M_PI};
        t.correlation[i][i] = t.factor[i][i] = 1;
    }
    const mcv_propagation p = {&t, 0, TRIALS, true};
    make_values(&p, values, theirs);
    read_theirs(theirs, found);
    assert_int_equal(mcv_propagate(&p, values[0], 2, &ours, &error), MCV_OK);
    for (size_t i = 0; i < PARAMETERS; ++i) {
        const mcv_effect *e = ours.effects + i;
        if (!(fabs(e->first.value - found[i][0]) < 10.0 / TRIALS) ||
            !(fabs(e->total.value - found[i][1]) < 10.0 / TRIALS))
            fail_msg("parameter %zu: first %.5f, total %.5f by ours; %.5f, %.5f by SALib", i,
                     e->first.value, e->total.value, found[i][0], found[i][1]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_salib)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
