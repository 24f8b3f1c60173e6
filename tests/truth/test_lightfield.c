/* SPDX-License-Identifier: Apache-2.0 */
/* Views, plain image and Earth Mover's gradient of light field images whose every value is known,
 * and the contrast-to-noise ratio. */
#include "test.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "analysis/contrast.h"
#include "analysis/lightfield_file.h"
#include "analysis/noise.h"

static const char PATH[] = "test_lightfield.exr";

static void check(mcv_result result, const mcv_error *error) {
    if (result != MCV_OK) fail_msg("%s", error->text);
}

static mcv_image new_image(uint32_t width, uint32_t height, uint32_t channels) {
    mcv_image image;
    mcv_error error = {""};
    check(mcv_image_new(&image, width, height, channels, &error), &error);
    return image;
}

static float *pixel(const mcv_image *image, uint32_t channel, uint32_t column, uint32_t row) {
    return image->pixels + ((size_t)channel * image->height + row) * image->width + column;
}

/* --- views and the plain image
 * ---------------------------------------------------------------------------------- */

enum { M = 4, N = 3, J = 5, K = 2 };

/* Tells macro pixel, place and channel; a float holds it exactly, and sums of it. */
static float label(uint32_t c, uint32_t m, uint32_t n, uint32_t j, uint32_t k) {
    return (float)(1 + c + 3 * (m + M * (n + N * (j + J * k))));
}

static mcv_image labelled_image(void) {
    const mcv_image image = new_image(M * J, N * K, 3);
    for (uint32_t c = 0; c < 3; ++c)
        for (uint32_t y = 0; y < image.height; ++y)
            for (uint32_t x = 0; x < image.width; ++x)
                *pixel(&image, c, x, y) = label(c, x / J, y / K, x % J, y % K);
    return image;
}

static void test_views(void **state) {
    (void)state;
    mcv_image image = labelled_image(), views;
    mcv_error error = {""};
    check(mcv_light_field_views(&image, (const uint32_t[]){J, K}, &views, &error), &error);
    assert_int_equal(views.width, M * J);
    assert_int_equal(views.height, N * K);
    for (uint32_t c = 0; c < 3; ++c) {
        for (uint32_t y = 0; y < views.height; ++y) {
            for (uint32_t x = 0; x < views.width; ++x) {
                const float known = label(c, x % M, y % N, x / M, y / N),
                            value = *pixel(&views, c, x, y);
                if (value != known)
                    fail_msg("views: channel %u, pixel (%u, %u) is %g instead of %g", c, x, y,
                             (double)value, (double)known);
            }
        }
    }
    mcv_image_free(&image);
    mcv_image_free(&views);
}

static void test_plain(void **state) {
    (void)state;
    mcv_image image = labelled_image(), plain;
    mcv_error error = {""};
    check(mcv_light_field_plain(&image, (const uint32_t[]){J, K}, &plain, &error), &error);
    assert_int_equal(plain.width, M);
    assert_int_equal(plain.height, N);
    assert_int_equal(plain.channels, 1);
    for (uint32_t n = 0; n < N; ++n) {
        for (uint32_t m = 0; m < M; ++m) {
            double known = 0; /* whole numbers below 2^24 */
            for (uint32_t i = 0; i < 3 * J * K; ++i)
                known += (double)label(i / (J * K), m, n, i % J, i / J % K);
            if (*pixel(&plain, 0, m, n) != known)
                fail_msg("plain image: (%u, %u) is %g instead of %g", m, n,
                         (double)*pixel(&plain, 0, m, n), known);
        }
    }
    mcv_image_free(&image);
    mcv_image_free(&plain);
}

/* --- gradient
 * ---------------------------------------------------------------------------------------------------
 */

/* All light of macro pixel (m, n) in one place, which moves along by a column per macro pixel and
 * by a row; `brightness` each. */
enum { COLUMNS = 9, ROWS = 7 };
static const uint32_t angular[2] = {COLUMNS, ROWS};

static double brightness(uint32_t m, uint32_t n) { return 1 + 0.25 * ((m + 2 * n) % 5); }

static mcv_image moving_spot(uint32_t channels) {
    const mcv_image image = new_image(COLUMNS * COLUMNS, ROWS * ROWS, channels);
    for (uint32_t n = 0; n < ROWS; ++n)
        for (uint32_t m = 0; m < COLUMNS; ++m)
            for (uint32_t c = 0; c < channels; ++c)
                *pixel(&image, c, m * COLUMNS + m, n * ROWS + n) =
                    (float)(brightness(m, n) / channels);
    return image;
}

static mcv_image gradient_of(const mcv_image *image, mcv_emd_form form, uint32_t threads) {
    mcv_image gradient;
    mcv_error error = {""};
    check(mcv_light_field_gradient(image, angular, form, threads, &gradient, &error), &error);
    return gradient;
}

/* The gradient is a float: it may be rounded by half an ulp, and what goes into it is known to a
 * few ε of double. */
static void expect_gradient(const char *what, const mcv_image *gradient, uint32_t m, uint32_t n,
                            double known) {
    const double value = *pixel(gradient, 0, m, n);
    if (!(fabs(value - known) <= FLT_EPSILON * known))
        fail_msg("%s: the gradient at (%u, %u) is %.9g instead of %.9g, %.3g off", what, m, n,
                 value, known, value - known);
}

static void expect_border(const mcv_image *gradient) {
    for (uint32_t n = 0; n < gradient->height; ++n) {
        for (uint32_t m = 0; m < gradient->width; ++m) {
            const bool border =
                m == 0 || n == 0 || m == gradient->width - 1 || n == gradient->height - 1;
            if (isnan(*pixel(gradient, 0, m, n)) != border)
                fail_msg("(%u, %u) is%s NaN", m, n, border ? " not" : "");
        }
    }
}

static void test_moving_spot(void **state) {
    (void)state;
    const double across = 2.0 / COLUMNS, down = 2.0 / ROWS, diagonal = hypot(8.0 / 9, 6.0 / 7);
    for (uint32_t channels = 1; channels <= 4; channels += 3) {
        mcv_image image = moving_spot(channels);
        mcv_image normalized = gradient_of(&image, MCV_EMD_NORMALIZED, 0),
                  mass = gradient_of(&image, MCV_EMD_MASS, 0);
        assert_int_equal(normalized.width, COLUMNS);
        assert_int_equal(normalized.height, ROWS);
        expect_border(&normalized);
        expect_border(&mass);
        for (uint32_t n = 1; n + 1 < ROWS; ++n) {
            for (uint32_t m = 1; m + 1 < COLUMNS; ++m) {
                expect_gradient("a spot that moves", &normalized, m, n, 0.5 * hypot(across, down));
                /* In units of the median brightness, 1.5 of 63 macro pixels with
                 * 1, 1.25, 1.5, 1.75, 2 in turn. */
                const double l = brightness(m - 1, n) / 1.5, r = brightness(m + 1, n) / 1.5;
                const double t = brightness(m, n - 1) / 1.5, b = brightness(m, n + 1) / 1.5;
                expect_gradient("a spot that moves and changes", &mass, m, n,
                                0.5 * hypot(fmin(l, r) * across + 0.5 * diagonal * fabs(l - r),
                                            fmin(t, b) * down + 0.5 * diagonal * fabs(t - b)));
            }
        }
        mcv_image_free(&image);
        mcv_image_free(&normalized);
        mcv_image_free(&mass);
    }
}

/* A macro pixel without light is max(c) from others where only the distribution counts; negative
 * noise is no light. */
static void test_empty_macro_pixel(void **state) {
    (void)state;
    mcv_image image = moving_spot(1);
    const double diagonal = hypot(8.0 / 9, 6.0 / 7);
    *pixel(&image, 0, 4 * COLUMNS + 4, 3 * ROWS + 3) = 0;
    *pixel(&image, 0, 4 * COLUMNS + 1, 3 * ROWS + 1) = -0.5F;
    mcv_image gradient = gradient_of(&image, MCV_EMD_NORMALIZED, 1);
    expect_gradient("left of the empty one", &gradient, 3, 3, 0.5 * hypot(diagonal, 2.0 / ROWS));
    expect_gradient("below the empty one", &gradient, 4, 4, 0.5 * hypot(2.0 / COLUMNS, diagonal));
    expect_gradient("the empty one itself", &gradient, 4, 3,
                    0.5 * hypot(2.0 / COLUMNS, 2.0 / ROWS));
    mcv_image_free(&gradient);
    /* All others dark too: nothing differs. */
    for (size_t i = 0; i < (size_t)image.width * image.height; ++i)
        image.pixels[i] = fminf(0, image.pixels[i]);
    for (int form = MCV_EMD_NORMALIZED; form <= MCV_EMD_MASS; ++form) {
        gradient = gradient_of(&image, form, 1);
        expect_gradient("no light", &gradient, 4, 3, 0);
        mcv_image_free(&gradient);
    }
    mcv_image_free(&image);
}

static void test_any_number_of_threads(void **state) {
    (void)state;
    mcv_image image = new_image(COLUMNS * 13, ROWS * 11, 1);
    uint32_t bits = 7;
    for (size_t i = 0; i < (size_t)image.width * image.height; ++i) {
        bits = bits * 1664525u + 1013904223u;
        image.pixels[i] = (float)(bits >> 8) * 0x1p-24F;
    }
    mcv_image one = gradient_of(&image, MCV_EMD_MASS, 1);
    for (uint32_t threads = 2; threads <= 32; threads *= 4) {
        mcv_image other = gradient_of(&image, MCV_EMD_MASS, threads);
        if (memcmp(one.pixels, other.pixels, (size_t)13 * 11 * sizeof *one.pixels) != 0)
            fail_msg("%u threads give other bits than one", threads);
        mcv_image_free(&other);
    }
    mcv_image_free(&one);
    mcv_image_free(&image);
}

/* --- bad input
 * --------------------------------------------------------------------------------------------------
 */

static void expect_refused(const mcv_exr_part *part, const mcv_attribute *attributes,
                           uint32_t count, const uint64_t given[2], const char *sentence) {
    mcv_light_field_file file;
    mcv_error error = {""};
    check(mcv_exr_write(PATH, part, 1, attributes, count, &error), &error);
    assert_int_equal(mcv_light_field_read(PATH, given, &file, &error), MCV_BAD_INPUT);
    if (!strstr(error.text, PATH) || !strstr(error.text, sentence))
        fail_msg("\"%s\" does not say \"%s\"", error.text, sentence);
    unlink(PATH);
}

static void test_bad_input(void **state) {
    (void)state;
    const uint64_t none[2] = {0, 0}, five[2] = {5, 2}, seven[2] = {7, 2};
    mcv_exr_part part = {.name = "image", .image = labelled_image()};
    mcv_attribute resolution = {.name = "mcvisi:angularResolution", .numbers = {J, K}, .count = 2};
    const char *depths[] = {"U", "V", "Z"};

    expect_refused(&part, NULL, 0, none, "its header has no mcvisi:angularResolution");
    expect_refused(&part, &resolution, 1, seven,
                   "20 x 6 pixels must be a whole number of macro pixels of 7 x 2");
    resolution.numbers[0] = 3;
    expect_refused(&part, &resolution, 1, none,
                   "20 x 6 pixels must be a whole number of macro pixels of 3 x 2");
    resolution.numbers[0] = 2.5;
    expect_refused(&part, &resolution, 1, none,
                   "2.5 x 2 in the header: must be two integers of at least 1");
    resolution.count = 1;
    expect_refused(&part, &resolution, 1, none,
                   "mcvisi:angularResolution in the header must be 2 numbers");
    *pixel(&part.image, 1, 7, 4) = NAN;
    expect_refused(&part, NULL, 0, five, "pixel (7, 4) is NaN");
    *pixel(&part.image, 1, 7, 4) = INFINITY;
    expect_refused(&part, NULL, 0, five, "pixel (7, 4) is infinite");
    *pixel(&part.image, 1, 7, 4) = 1;
    part.channel_names = depths;
    expect_refused(&part, NULL, 0, five, "its 3 channels must be Y, or R, G and B");
    part.channel_names = NULL;
    for (size_t i = 0; i < (size_t)3 * part.image.width * part.image.height; ++i)
        part.image.pixels[i] = -1;
    expect_refused(&part, NULL, 0, five, "the whole image is dark");
    mcv_image_free(&part.image);
}

/* R, G and B without what else there is; above the camera's black level. */
static void test_reading(void **state) {
    (void)state;
    const char *names[] = {"A", "B", "G", "R"};
    mcv_exr_part part = {
        .name = "image", .image = new_image(M * J, N * K, 4), .channel_names = names};
    const mcv_attribute attributes[] = {
        {.name = "mcvisi:angularResolution", .numbers = {J, K}, .count = 2},
        {.name = "mcvisi:blackLevel", .numbers = {16}, .count = 1}};
    mcv_light_field_file file;
    mcv_error error = {""};
    for (uint32_t c = 0; c < 4; ++c)
        for (size_t i = 0; i < (size_t)M * J * N * K; ++i)
            part.image.pixels[(size_t)c * M * J * N * K + i] = (float)(100 * c + 20);
    check(mcv_exr_write(PATH, &part, 1, attributes, 2, &error), &error);
    check(mcv_light_field_read(PATH, (const uint64_t[]){0, 0}, &file, &error), &error);
    assert_int_equal(file.angular[0], J);
    assert_int_equal(file.angular[1], K);
    assert_int_equal(file.image.channels, 3);
    for (uint32_t c = 0; c < 3; ++c) {
        const double known = 100.0 * (3 - c) + 4;
        if (*pixel(&file.image, c, 3, 2) != known)
            fail_msg("channel %u is %g instead of %g", c, (double)*pixel(&file.image, c, 3, 2),
                     known);
    }
    mcv_light_field_free(&file);
    mcv_image_free(&part.image);
    unlink(PATH);
}

/* --- peak to noise
 * ---------------------------------------------------------------------------------------------- */

/*
 * A background of 3 and 5 in turn (mean 4, deviation √(n/(n - 1)) of n values), a defect of -6 in
 * the region and a far larger value between the rings, which must not count; NaN anywhere neither.
 */
static void test_contrast(void **state) {
    (void)state;
    mcv_image image = new_image(40, 30, 1);
    const mcv_ring region = {.outer = 2, .pitch = {0.5, 1}},
                   background = {.inner = 4, .outer = 8, .pitch = {0.5, 1}};
    uint32_t inside = 0;
    for (uint32_t y = 0; y < 30; ++y) {
        for (uint32_t x = 0; x < 40; ++x) {
            const double r = hypot(0.5 * (x - 19.5), y - 14.5);
            *pixel(&image, 0, x, y) = r > 2 && r < 4 ? 1000.0F : (x + y) % 2 ? 3.0F : 5.0F;
            inside += r >= 4 && r <= 8;
        }
    }
    *pixel(&image, 0, 20, 15) = -6;
    *pixel(&image, 0, 19, 14) = NAN;
    *pixel(&image, 0, 30, 14) = *pixel(&image, 0, 31, 14) =
        NAN; /* one of each, in the background */
    inside -= 2;
    const mcv_spread spread = mcv_image_spread(&image, &background);
    const double deviation = sqrt(inside / (inside - 1.0)),
                 ratio = mcv_peak_to_noise(&image, &region, &background);
    assert_int_equal(spread.count, inside);
    /* Sums of whole numbers are exact; a few roundings follow. */
    if (fabs(spread.mean - 4) > 8 * DBL_EPSILON)
        fail_msg("the background's mean is %.17g instead of 4", spread.mean);
    if (fabs(spread.deviation - deviation) > 8 * DBL_EPSILON)
        fail_msg("its deviation is %.17g instead of %.17g", spread.deviation, deviation);
    if (spread.largest != 5) fail_msg("its largest value is %g instead of 5", spread.largest);
    if (fabs(ratio - 10 / deviation) > 80 * DBL_EPSILON)
        fail_msg("peak to noise is %.17g instead of %.17g", ratio, 10 / deviation);
    mcv_image_free(&image);
}

/* --- noise floor --- */

/*
 * One row of J equal bins of n rays: dx and dy are W1 = √(2/n) ∫|B| of a Brownian bridge B, with
 * E ∫|B| = √(2π)/8 = 0.3133 and E (∫|B|)² = 7/60 (L. A. Shepp, On the integral of the absolute
 * value of the pinned Wiener process, 1982). By Jensen, the mean of ½ √(dx² + dy²) lies between √½
 * E W1 and √½ √(E W1²), 0.2216 and 0.2415 of √(2/n). Of 38² x 4 draws, each uncertain by 40 %, the
 * mean is within 2.6 %, five deviations; 64 bins miss less. A gradient of such noise alone is its
 * floor: its 38² values, 1 % in the mean, share neighbours.
 */
static void test_noise_floor(void **state) {
    enum { PLACES = 40, BINS = 64, RAYS = 4096 };
    const uint32_t row[2] = {BINS, 1};
    mcv_image image = new_image(PLACES * BINS, PLACES, 1),
              errors = new_image(PLACES * BINS, PLACES, 1);
    mcv_image noise_floor, gradient;
    mcv_error error = {""};
    (void)state;
    for (size_t i = 0; i < (size_t)PLACES * BINS * PLACES; ++i) {
        mcv_noise noise = mcv_noise_begin(77, 1, i);
        errors.pixels[i] = sqrtf((float)RAYS / BINS);
        image.pixels[i] = (float)mcv_noise_poisson(&noise, (double)RAYS / BINS);
    }
    check(mcv_light_field_floor(&image, &errors, row, MCV_EMD_NORMALIZED, 2, &noise_floor, &error),
          &error);
    check(mcv_light_field_gradient(&image, row, MCV_EMD_NORMALIZED, 2, &gradient, &error), &error);
    const double unit = sqrt(2.0 / RAYS), mean = mcv_image_spread(&noise_floor, NULL).mean / unit,
                 of_noise = mcv_image_spread(&gradient, NULL).mean / unit;
    print_message("floor %.4f, gradient of noise %.4f\n", mean, of_noise);
    assert_true(mean >= 0.974 * 0.2216 && mean <= 1.026 * 0.2415);
    assert_true(fabs(of_noise / mean - 1) < 0.075);
    mcv_image_free(&image);
    mcv_image_free(&errors);
    mcv_image_free(&noise_floor);
    mcv_image_free(&gradient);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_views),
        cmocka_unit_test(test_plain),
        cmocka_unit_test(test_moving_spot),
        cmocka_unit_test(test_empty_macro_pixel),
        cmocka_unit_test(test_any_number_of_threads),
        cmocka_unit_test(test_bad_input),
        cmocka_unit_test(test_reading),
        cmocka_unit_test(test_contrast),
        cmocka_unit_test(test_noise_floor),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
