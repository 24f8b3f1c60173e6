/* SPDX-License-Identifier: Apache-2.0 */
/* Speckle belongs to the part's surface and moves with it. */
/* ctest: label truth */
#include "scene_builder.h"
#include "truths.h"

#include "analysis/speckle.h"

#include <math.h>
#include <stdlib.h>

static const double wavelength = 660e-9, f_number = 8;

enum { PLATE = 96, Q = 4 };

/* Places of a plate that is tilted by 60° and moved by so many pixels to the left; a pixel sees
 * λN across the tilt. */
static void lay_plate(mcv_image *places, double moved, double number) {
    const size_t side = PLATE + 1, plane = side * side;
    const double pixel = wavelength * f_number;
    BUILD(mcv_image_new(places, (uint32_t)side, (uint32_t)side, 4, &builder_error));
    for (size_t row = 0; row < side; ++row)
        for (size_t column = 0; column < side; ++column) {
            const double along = pixel * ((double)column + moved);
            float *at = places->pixels + row * side + column;
            at[0] = (float)along;
            at[plane] = (float)(pixel * (double)row);
            at[2 * plane] = (float)(along * tan(M_PI / 3));
            at[3 * plane] = (float)number;
        }
}

/* Light of 1 on a plate with its speckle, for 4 seeds; the caller frees it. */
static void light_plates(double moved, double number, uint32_t exposure, float *lights[4]) {
    const double pitch = wavelength * f_number / Q;
    const size_t pixels = PLATE * PLATE, fine = pixels * Q * Q;
    mcv_image places;
    lay_plate(&places, moved, number);
    const mcv_surface_noise surface = {.places = &places, .edge = wavelength * f_number / 6};
    float *laser = malloc(fine * sizeof *laser);
    assert_non_null(laser);
    for (size_t i = 0; i < fine; ++i) laser[i] = 1;
    for (uint32_t seed = 0; seed < 4; ++seed) {
        const mcv_speckle speckle = {.f_number = f_number,
                                     .wavelength = wavelength,
                                     .aperture = {.shape = MCV_APERTURE_DISC},
                                     .pitch = {pitch, pitch},
                                     .polarization = 1,
                                     .patterns = 1,
                                     .seed = seed,
                                     .exposure = exposure,
                                     .surface = &surface};
        lights[seed] = malloc(pixels * sizeof *lights[seed]);
        assert_non_null(lights[seed]);
        for (size_t i = 0; i < pixels; ++i) lights[seed][i] = 1;
        BUILD(mcv_speckle_add(&speckle, laser, Q, PLATE, PLATE, lights[seed], &builder_error));
    }
    free(laser);
    mcv_image_free(&places);
}

/* µ of the disc. */
static double field(double s) { return s > 0 ? 2 * j1(M_PI * s) / (M_PI * s) : 1; }

/* The covariance of pixels of λN that lie so many λN apart, over the disc's variance. */
static double pixel_covariance(double apart) {
    enum { STEPS = 200 };
    double sum = 0, variance = 0;
    for (int i = -STEPS; i < STEPS; ++i)
        for (int j = -STEPS; j < STEPS; ++j) {
            const double x = (i + 0.5) / STEPS, y = (j + 0.5) / STEPS,
                         weight = (1 - fabs(x)) * (1 - fabs(y));
            sum += weight * pow(field(hypot(x + apart, y)), 2);
            variance += weight * pow(field(hypot(x, y)), 2);
        }
    return sum / variance;
}

/*
 * Speckle moves with the surface. On a plate that is seen at 60° it has the contrast of the film's
 * own. A plate that has moved by three pixels shows the same values three pixels aside. Moved by a
 * part of a pixel its values correlate as pixels of the same distance do, and another surface has
 * other ones. Some 4 · 9000 λ²N² leave 0.01 of the variance, and 4.5 of that are 0.05; cells that
 * count in the middle of their sub-pixel, λN/8 beside themselves at most, take up to 0.03 more off.
 */
static void test_surface_moves(void **state) {
    (void)state;
    static const struct {
        double moved, number;
        int aside;
        double expected;
    } cases[] = {{3, 5, 3, 1}, {0.3, 5, 0, NAN}, {0.7, 5, 0, NAN}, {1.4, 5, 1, NAN}, {0, 6, 0, 0}};
    float *still[4], *moved[4];
    light_plates(0, 5, 0, still);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        double products = 0, squares = 0, count = 0;
        light_plates(cases[i].moved, cases[i].number, 1, moved);
        for (int seed = 0; seed < 4; ++seed)
            for (int row = 8; row < PLATE - 8; ++row)
                for (int column = 8; column < PLATE - 8; ++column) {
                    const double here = (double)still[seed][row * PLATE + column] - 1;
                    products +=
                        here * ((double)moved[seed][row * PLATE + column - cases[i].aside] - 1);
                    squares += here * here;
                    ++count;
                }
        for (int seed = 0; seed < 4; ++seed) free(moved[seed]);
        const double contrast = sqrt(squares / count), seen = products / squares,
                     expected = isnan(cases[i].expected)
                                    ? pixel_covariance(cases[i].moved - cases[i].aside)
                                    : cases[i].expected,
                     within = i == 0 ? 0.001 : 0.08;
        print_message("moved by %g pixels: correlation %.4f, expected %.4f; contrast %.4f\n",
                      cases[i].moved, seen, expected, contrast);
        note_truth("T29 speckle of a part that moves: correlation", "program",
                   fabs(seen - expected), 0.08);
        if (!(fabs(seen - expected) <= within))
            fail_msg("moved by %g pixels: correlation %g, expected %g", cases[i].moved, seen,
                     expected);
        if (!(fabs(contrast / 0.711 - 1) <= 0.02)) fail_msg("contrast %g", contrast);
    }
    for (int seed = 0; seed < 4; ++seed) free(still[seed]);
}

/*
 * What sees no surface has numbers of the film, 0 as the surface's: others in each exposure of a
 * part that moves, so that errors of its profiles are independent. Some 4 · 9200 λ²N² leave 0.01 of
 * the variance, and 4.5 of that are 0.05.
 */
static void test_film_in_each_exposure(void **state) {
    (void)state;
    float *first[4], *again[4], *next[4];
    double products = 0, squares = 0;
    light_plates(0, 0, 0, first);
    light_plates(3, 0, 0, again);
    light_plates(3, 0, 1, next);
    for (int seed = 0; seed < 4; ++seed) {
        for (int i = 0; i < PLATE * PLATE; ++i) {
            const double here = (double)first[seed][i] - 1;
            products += here * ((double)next[seed][i] - 1);
            squares += here * here;
            if (first[seed][i] != again[seed][i]) fail_msg("pixel %d differs in one exposure", i);
        }
        free(first[seed]);
        free(again[seed]);
        free(next[seed]);
    }
    if (!(fabs(products / squares) <= 0.05))
        fail_msg("two exposures of the film correlate by %g, expected 0", products / squares);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_surface_moves),
                                       cmocka_unit_test(test_film_in_each_exposure)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
