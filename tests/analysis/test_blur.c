/* SPDX-License-Identifier: Apache-2.0 */
/* The lens MTF: Fourier transforms against their sums, gratings against the modulation, noise
 * against its propagation. */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "analysis/blur.h"
#include "analysis/fft.h"
#include "analysis/noise.h"

/* Against the sum itself, whose own rounding is about n units in the last place of values up to √n.
 */
static void test_fft_is_the_sum(void **state) {
    static const size_t lengths[] = {1, 2, 3, 4, 5, 6, 8, 30, 45, 64, 100, 243, 360};
    static double in[2 * 360 * MCV_FFT_LINES], values[2 * 360 * MCV_FFT_LINES],
        work[2 * 360 * MCV_FFT_LINES];
    (void)state;
    for (size_t i = 0; i < sizeof in / sizeof in[0]; ++i) in[i] = sin(1.7 * (double)i * (double)i);
    for (size_t l = 0; l < sizeof lengths / sizeof lengths[0]; ++l) {
        const size_t n = lengths[l];
        double *roots = mcv_fft_roots(n);
        assert_int_equal(mcv_fft_length(n), n);
        memcpy(values, in, sizeof in);
        const double *out = mcv_fft(values, work, n, roots);
        for (size_t k = 0; k < n * MCV_FFT_LINES; ++k) {
            const size_t line = k % MCV_FFT_LINES,
                         at = 2 * (k / MCV_FFT_LINES) * MCV_FFT_LINES + line;
            double re = 0, im = 0;
            for (size_t j = 0; j < n; ++j) {
                const double angle = -2 * M_PI * (double)(j * (k / MCV_FFT_LINES) % n) / (double)n;
                const double *x = in + 2 * j * MCV_FFT_LINES + line;
                re += x[0] * cos(angle) - x[MCV_FFT_LINES] * sin(angle);
                im += x[0] * sin(angle) + x[MCV_FFT_LINES] * cos(angle);
            }
            const double off = hypot(out[at] - re, out[at + MCV_FFT_LINES] - im);
            if (off > 4 * (double)n * 0x1p-52)
                fail_msg("length %zu, line %zu, coefficient %zu is %g off", n, line,
                         k / MCV_FFT_LINES, off);
        }
        free(roots);
    }
    assert_int_equal(mcv_fft_length(7), 8);
    assert_int_equal(mcv_fft_length(2577), 2592);
}

enum { SIDE = 200 };
static const double pitch[2] = {3.45e-6, 5e-6};

static mcv_lens_mtf diffraction(double f_number) {
    return (mcv_lens_mtf){.f_number = f_number, .wavelength = 550e-9};
}

/*
 * A grating keeps its phase and its modulation falls by the MTF. Beyond the border stands another
 * pattern, at most 0.5 off the grating on average. The MTF begins as 1 - 4/π λN ν, so the line
 * spread function ends as 2 λN/(π³ x²): beyond 90 pixels on both sides lie 4 λN/(90 π³) = 1.9e-3 of
 * the light, which makes 1e-3.
 */
static void test_gratings(void **state) {
    static const double waves[][2] = {{20, 0}, {0, 30}, {50, 40}, {90, -70}, {100, 0}};
    (void)state;
    for (size_t w = 0; w < sizeof waves / sizeof waves[0]; ++w) {
        const mcv_lens_mtf lens = diffraction(8), mtf[3] = {lens, lens, lens};
        const double fx = waves[w][0] / SIDE, fy = waves[w][1] / SIDE;
        const double expected = mcv_lens_modulation(&lens, hypot(fx / pitch[0], fy / pitch[1]));
        mcv_image image;
        mcv_error error = {""};
        assert_int_equal(mcv_image_new(&image, SIDE, SIDE, 1, &error), MCV_OK);
        for (int y = 0; y < SIDE; ++y)
            for (int x = 0; x < SIDE; ++x)
                image.pixels[y * SIDE + x] = (float)(1 + 0.5 * cos(2 * M_PI * (fx * x + fy * y)));
        assert_int_equal(mcv_blur(&image, NULL, mtf, pitch, NULL, &error), MCV_OK);
        for (int y = 90; y < 110; ++y)
            for (int x = 90; x < 110; ++x) {
                const double truth = 1 + 0.5 * expected * cos(2 * M_PI * (fx * x + fy * y));
                if (fabs(image.pixels[y * SIDE + x] - truth) > 1e-3)
                    fail_msg("wave %g, %g: pixel %d, %d is %g instead of %g", waves[w][0],
                             waves[w][1], x, y, (double)image.pixels[y * SIDE + x], truth);
            }
        mcv_image_free(&image);
    }
    const mcv_lens_mtf lens = diffraction(8);
    assert_true(mcv_lens_modulation(&lens, 0) == 1);
    assert_true(mcv_lens_modulation(&lens, 1 / (550e-9 * 8)) == 0);
    /* Goodman's value at half the cut-off: 2/π (π/3 - √3/4). */
    assert_true(fabs(mcv_lens_modulation(&lens, 0.5 / (550e-9 * 8)) -
                     2 / M_PI * (M_PI / 3 - sqrt(3) / 4)) < 1e-15);
}

/* A uniform image stays as it is, to the rounding of float. */
static void test_uniform(void **state) {
    const mcv_lens_mtf lens = diffraction(16), mtf[3] = {lens, lens, lens};
    mcv_image image;
    mcv_error error = {""};
    (void)state;
    assert_int_equal(mcv_image_new(&image, 33, 57, 3, &error), MCV_OK);
    for (int i = 0; i < 3 * 33 * 57; ++i) image.pixels[i] = 7.25F;
    assert_int_equal(mcv_blur(&image, NULL, mtf, pitch, NULL, &error), MCV_OK);
    for (int i = 0; i < 3 * 33 * 57; ++i)
        if (fabs(image.pixels[i] - 7.25) > 7.25 * 0x1p-23)
            fail_msg("value %d is %g", i, (double)image.pixels[i]);
    mcv_image_free(&image);
}

/* The spread of 400 noisy images against the propagated standard error; a variance of so few has a
 * standard error of √(2/399) of it. */
static void test_noise_is_propagated(void **state) {
    enum { SMALL = 24, IMAGES = 400, AT = 12 * SMALL + 12 };
    const mcv_lens_mtf lens = diffraction(8), mtf[3] = {lens, lens, lens};
    mcv_image image, deviation;
    mcv_error error = {""};
    double sum = 0, squares = 0;
    (void)state;
    assert_int_equal(mcv_image_new(&image, SMALL, SMALL, 1, &error), MCV_OK);
    assert_int_equal(mcv_image_new(&deviation, SMALL, SMALL, 1, &error), MCV_OK);
    for (uint32_t k = 0; k <= IMAGES; ++k) {
        for (uint32_t i = 0; i < SMALL * SMALL; ++i) {
            mcv_noise noise = mcv_noise_begin(k, 0, i);
            image.pixels[i] = (float)(100 + mcv_noise_normal(&noise));
            deviation.pixels[i] = 1;
        }
        assert_int_equal(
            mcv_blur(&image, k == IMAGES ? &deviation : NULL, mtf, pitch, NULL, &error), MCV_OK);
        if (k == IMAGES) break;
        sum += image.pixels[AT];
        squares += (double)image.pixels[AT] * image.pixels[AT];
    }
    const double variance = (squares - sum * sum / IMAGES) / (IMAGES - 1),
                 stated = pow(deviation.pixels[AT], 2);
    if (fabs(variance / stated - 1) > 4 * sqrt(2.0 / (IMAGES - 1)))
        fail_msg("variance %g, stated %g", variance, stated);
    assert_true(stated < 0.6); /* a lens that blurs also averages */
    mcv_image_free(&image);
    mcv_image_free(&deviation);
}

static void write_text(const char *text) {
    FILE *file = fopen("test_blur.csv", "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static void expect_refused(const char *text, const char *part) {
    mcv_mtf_row *rows;
    size_t count;
    mcv_error error = {""};
    write_text(text);
    assert_int_equal(mcv_mtf_read("test_blur.csv", &rows, &count, &error), MCV_BAD_INPUT);
    if (!strstr(error.text, part) || !strstr(error.text, "test_blur.csv"))
        fail_msg("\"%s\" is missing in: %s", part, error.text);
}

static void test_tables(void **state) {
    mcv_mtf_row *rows;
    size_t count;
    mcv_error error = {""};
    (void)state;
    write_text("# lp/mm, modulation\n0, 1\n\n50\t0.6\n100; 0.3\n");
    if (mcv_mtf_read("test_blur.csv", &rows, &count, &error) != MCV_OK) fail_msg("%s", error.text);
    assert_int_equal(count, 3);
    const mcv_lens_mtf lens = {.rows = rows, .row_count = count};
    static const double at[][2] = {{0, 1},       {25e3, 0.8},  {50e3, 0.6},
                                   {75e3, 0.45}, {100e3, 0.3}, {200e3, 0.3}};
    for (int i = 0; i < 6; ++i)
        assert_true(fabs(mcv_lens_modulation(&lens, at[i][0]) - at[i][1]) < 1e-12);
    free(rows);
    expect_refused("0, 1\n", "at least 2");
    expect_refused("10, 1\n20, 0.5\n", "line 1");
    expect_refused("0, 1\n50, 0.6\n40, 0.5\n", "line 3");
    expect_refused("0, 1\n50, 1.6\n", "1.6");
    expect_refused("0, 1\n50, abc\n", "line 2");
    expect_refused("0, 1\n50, 0.5, 3\n", "line 2");
    unlink("test_blur.csv");
    assert_int_equal(mcv_mtf_read("test_blur.csv", &rows, &count, &error), MCV_BAD_INPUT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fft_is_the_sum), cmocka_unit_test(test_gratings),
        cmocka_unit_test(test_uniform),        cmocka_unit_test(test_noise_is_propagated),
        cmocka_unit_test(test_tables),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
