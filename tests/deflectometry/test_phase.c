/* SPDX-License-Identifier: Apache-2.0 */
/* The parts of deflectometry alone: phases and their noise, unwrapping, heights from slopes, the
 * best period of fringes. */
#include "test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/noise.h"
#include "deflectometry/fringes.h"
#include "deflectometry/height.h"

/* Differences of angles, and of places that wrap. */
static double apart(double a, double b, double period) { return fabs(remainder(a - b, period)); }

static void test_phase_is_decoded(void **state) {
    (void)state;
    for (uint32_t steps = 3; steps <= 9; ++steps)
        for (int i = 0; i < 40; ++i) {
            double values[9];
            const double phase = 0.16 * i;
            for (uint32_t k = 0; k < steps; ++k)
                values[k] = 5 + 2 * cos(phase - 2 * M_PI * k / steps);
            const mcv_fringe f = mcv_fringe_decode(values, steps);
            assert_true(apart(f.phase, phase, 2 * M_PI) < 1e-14 * 10);
            assert_float_equal(f.modulation, 2, 1e-13);
            assert_float_equal(f.mean, 5, 1e-13);
        }
}

/* u(φ) = √(2/N) u(I)/B. The deviation of n = 20000 phases has the standard error 1/√(2n) = 0.5 %;
 * the formula leaves out (u/B)² = 0.3 % at most. 3 % are asked. */
static void test_noise_of_phases(void **state) {
    (void)state;
    enum { COUNT = 20000 };
    static const uint32_t steps[] = {3, 4, 8};
    for (int i = 0; i < 3; ++i) {
        mcv_noise noise = mcv_noise_begin(7, (uint32_t)i, 1);
        const double u = 0.05, b = 0.9;
        double sum = 0;
        for (int n = 0; n < COUNT; ++n) {
            double values[8];
            const double phase = 2 * M_PI * n / COUNT;
            for (uint32_t k = 0; k < steps[i]; ++k)
                values[k] =
                    1 + b * cos(phase - 2 * M_PI * k / steps[i]) + u * mcv_noise_normal(&noise);
            const double error =
                remainder(mcv_fringe_decode(values, steps[i]).phase - phase, 2 * M_PI);
            sum += error * error;
        }
        const double ratio = sqrt(sum / COUNT) / mcv_fringe_deviation(steps[i], u, b);
        print_message("N = %u: deviation of the phase over √(2/N) u/B: %.4f\n", steps[i], ratio);
        assert_float_equal(ratio, 1, 0.03);
    }
}

/* Both ways find each place, with errors of phases below what they bear: the beat of P = 12 periods
 * an error of π/(P + P - 1) in each phase, a Gray code any half period read as its neighbour. What
 * an error moves off the screen wraps. */
static void test_periods_are_told_apart(void **state) {
    (void)state;
    const double periods = 12, most = 0.9 * M_PI / (2 * periods - 1);
    for (int i = 0; i < 997; ++i) {
        const double place = periods * (i + 0.5) / 997, phase = 2 * M_PI * place,
                     fewer = phase * (periods - 1) / periods;
        for (int sign = -1; sign <= 1; ++sign) {
            const double error = sign * most;
            const double found =
                mcv_unwrap_heterodyne(fmod(phase + error + 2 * M_PI, 2 * M_PI),
                                      fmod(fewer - error + 2 * M_PI, 2 * M_PI), periods);
            if (apart(found, place + error / (2 * M_PI), periods) > 1e-9 || found < 0 ||
                found > periods)
                fail_msg("place %g, error %g: %g", place, error, found);
            const double half = floor(2 * place), into = 2 * place - half;
            /* A neighbour is read near its edge only: within half of a half period. */
            if ((sign < 0 && into > 0.4) || (sign > 0 && into < 0.6)) continue;
            const uint32_t read = (uint32_t)fmin(fmax(half + sign, 0), 2 * periods - 1);
            assert_true(apart(mcv_unwrap_gray(fmod(phase, 2 * M_PI), read, periods), place,
                              periods) < 1e-9);
        }
    }
}

/* --- heights --- */

enum { WIDTH = 37, HEIGHT = 23, COUNT = WIDTH * HEIGHT };

/* The mean slope of two points of a parabola is that of the way between them, whatever the places:
 * the heights are exact. A column of gaps makes two parts of the map; each has the mean 0. The
 * solution stops at 1e-12 of the right side, times the condition of 2000 pixels, 1e3. */
static void test_heights_of_a_saddle(void **state) {
    (void)state;
    static bool valid[COUNT];
    static double x[COUNT], y[COUNT], p[COUNT], q[COUNT], z[COUNT], truth[COUNT];
    double means[2] = {0, 0}, counts[2] = {0, 0}, residual;
    mcv_error error = {""};
    for (int i = 0; i < COUNT; ++i) {
        const int column = i % WIDTH, row = i / WIDTH, part = column > 20;
        x[i] = 1e-3 * (column + 0.1 * sin(row) + 0.004 * column * row);
        y[i] = 1e-3 * (-1.3 * row + 0.2 * cos(column));
        p[i] = 3e-2 + 2 * 1.5 * x[i] - 0.7 * y[i];
        q[i] = -1e-2 - 0.7 * x[i] - 2 * 2.2 * y[i];
        truth[i] =
            3e-2 * x[i] - 1e-2 * y[i] + 1.5 * x[i] * x[i] - 0.7 * x[i] * y[i] - 2.2 * y[i] * y[i];
        valid[i] = column != 20 && (column + 2 * row) % 31 != 0;
        if (!valid[i]) p[i] = q[i] = x[i] = y[i] = NAN;
        if (!valid[i]) continue;
        means[part] += truth[i];
        ++counts[part];
    }
    const mcv_slope_map map = {WIDTH, HEIGHT, valid, x, y, p, q};
    assert_int_equal(mcv_heights_integrate(&map, z, &residual, &error), MCV_OK);
    for (int i = 0; i < COUNT; ++i) {
        const int part = i % WIDTH > 20;
        const double expected = valid[i] ? truth[i] - means[part] / counts[part] : 0;
        if (!(fabs(z[i] - expected) <= 1e-9 * 1e-3))
            fail_msg("pixel %d: %.12g, expected %.12g", i, z[i], expected);
    }
    assert_true(residual < 1e-12);
}

/* --- the best period --- */

/*
 * A pixel that sees an even disc of the diameter c: the contrast is 2 J1(πc/T)/(πc/T), and
 * T/contrast is least where J1 has its maximum: at 1.8412, T = 1.7063 c, contrast 0.6320. A box of
 * the width c has sin(x)/x with x = πc/T: T = 2 c and 2/π. The disc has 200 pixels: its share of
 * each is exact at their middles up to 1/200² or so. The least is flat: T is found to 1e-3.
 */
static void test_best_period(void **state) {
    (void)state;
    enum { LENGTH = 1024, WIDE = 200 };
    for (int disc = 0; disc < 2; ++disc) {
        static uint32_t columns[WIDE];
        static double values[WIDE];
        static float by[2 * WIDE];
        uint64_t begins[2] = {0, WIDE};
        const bool valid = true;
        double contrast;
        for (uint32_t i = 0; i < WIDE; ++i) {
            const double at = 2 * (i + 0.5) / WIDE - 1;
            columns[i] = 5 + 300 + i;
            values[i] = disc ? sqrt(1 - at * at) : 1;
            by[2 * i] = by[2 * i + 1] = (float)values[i];
        }
        const mcv_matrix matrix = {.width = 1,
                                   .height = 1,
                                   .channels = 1,
                                   .replicates = 2,
                                   .row_count = 1,
                                   .column_count = 5 + LENGTH,
                                   .row_begins = begins,
                                   .columns = columns,
                                   .values = values,
                                   .replicates_of = by};
        const double period = mcv_best_period(&matrix, 5, LENGTH, &valid, &contrast);
        print_message("%s: best period %.4f of its width, contrast %.4f\n", disc ? "disc" : "box",
                      period / WIDE, contrast);
        assert_float_equal(period / WIDE, disc ? M_PI / 1.8411838 : 2, 2e-3);
        assert_float_equal(contrast, disc ? 0.63204 : 2 / M_PI, 2e-3);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_phase_is_decoded),
        cmocka_unit_test(test_noise_of_phases),
        cmocka_unit_test(test_periods_are_told_apart),
        cmocka_unit_test(test_heights_of_a_saddle),
        cmocka_unit_test(test_best_period),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
