/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The mean of a picture's channels: all channels of a pixel come from the same paths, so that their
 * errors add up. Stated uncertainties against many pictures, from the film to the figures. Seeds
 * are fixed.
 */
#include "test.h"

#include <math.h>
#include <string.h>

#include "analysis/channel.h"
#include "analysis/noise.h"
#include "analysis/region.h"
#include "coverage.h"

enum { WIDTH = 48, HEIGHT = 24, PLANE = WIDTH * HEIGHT, CHANNELS = 3, REPLICATES = 4 };

static const double colour[CHANNELS] = {1, 0.7, 0.4}, camera = 0.06;

static double truth_at(size_t pixel, uint32_t channel) {
    return colour[channel] * (pixel % WIDTH < WIDTH / 2 ? 1 : 0.8);
}

/* A render whose samples are off by 0.12 of their mean. Of that the share `common` of the variance
 * is the same in all channels. */
static void render(double common, uint32_t seed, mcv_film *film) {
    film->samples = 1;
    for (uint32_t i = 0; i < PLANE; ++i) {
        mcv_noise noise = mcv_noise_begin(seed, 0, i);
        for (uint32_t r = 0; r < REPLICATES; ++r) {
            const double all = mcv_noise_normal(&noise);
            for (uint32_t c = 0; c < CHANNELS; ++c) {
                const double off = sqrt(common) * all + sqrt(1 - common) * mcv_noise_normal(&noise);
                film->sums[(r * CHANNELS + c) * PLANE + i] = truth_at(i, c) * (1 + 0.12 * off);
            }
        }
    }
}

/* The camera's noise is each channel's own. */
static void expose(uint32_t seed, mcv_image *light, const mcv_image *render_error,
                   mcv_image *errors) {
    for (uint32_t i = 0; i < CHANNELS * PLANE; ++i) {
        mcv_noise noise = mcv_noise_begin(seed, 1, i);
        light->pixels[i] += (float)(camera * mcv_noise_normal(&noise));
        errors->pixels[i] = hypotf(render_error->pixels[i], (float)camera);
    }
}

enum { FIGURES = 5 };
static const char *const names[FIGURES] = {"mean", "deviation", "SNR", "difference", "CNR"};

static void find(mcv_film *film, uint32_t seed, mcv_quantity found[FIGURES]) {
    mcv_image light, render_error, errors;
    mcv_readings r = {.render_freedom = REPLICATES - 1, .correlation = {1, 1, 1, 1}};
    mcv_roi region, background;
    mcv_error error = {""};
    assert_int_equal(mcv_film_develop(film, &light, &render_error, &error), MCV_OK);
    assert_int_equal(mcv_image_new(&errors, WIDTH, HEIGHT, CHANNELS, &error), MCV_OK);
    expose(seed, &light, &render_error, &errors);
    const double shared = mcv_film_channel_correlation(film);
    assert_int_equal(mcv_choose_channel(0, "a", &light, &r.values, &error), MCV_OK);
    assert_int_equal(
        mcv_choose_errors(0, "a", &errors, &render_error, shared, &r.deviation, &error), MCV_OK);
    assert_int_equal(
        mcv_choose_errors(0, "a", &render_error, &render_error, shared, &r.render, &error), MCV_OK);
    assert_int_equal(mcv_roi_parse("0,0,24,24", 1, &r.values, &region, &error), MCV_OK);
    assert_int_equal(mcv_roi_parse("24,0,24,24", 2, &r.values, &background, &error), MCV_OK);
    const mcv_roi_figures f = mcv_roi_measure(&r, &region);
    const mcv_contrast_figures c = mcv_roi_contrast(&r, &region, &background);
    const mcv_quantity all[FIGURES] = {f.mean, f.deviation, f.snr, c.difference,
                                       c.contrast_to_noise};
    memcpy(found, all, sizeof all);
    mcv_roi_free(&region);
    mcv_roi_free(&background);
    mcv_image *const images[] = {&light,    &render_error, &errors,
                                 &r.values, &r.deviation,  &r.render};
    for (size_t i = 0; i < sizeof images / sizeof images[0]; ++i) mcv_image_free(images[i]);
}

/* The mean of the three channels is 0.7 or 0.56, and the camera's noise of it `camera`/√3. */
static void check_coverage(double common) {
    static const double mean = 0.7, dark = 0.56;
    const double noise = camera / sqrt(CHANNELS),
                 truths[FIGURES] = {mean, noise, mean / noise, mean - dark, (mean - dark) / noise};
    int covered[FIGURES] = {0};
    mcv_film film;
    mcv_error error = {""};
    assert_int_equal(mcv_film_new(&film, WIDTH, HEIGHT, CHANNELS, REPLICATES, &error), MCV_OK);
    for (uint32_t n = 0; n < CASES; ++n) {
        mcv_quantity found[FIGURES];
        render(common, n, &film);
        find(&film, n, found);
        for (int k = 0; k < FIGURES; ++k)
            covered[k] += fabs(found[k].value - truths[k]) <= 1.959964 * found[k].uncertainty;
    }
    mcv_film_free(&film);
    for (int k = 0; k < FIGURES; ++k) {
        const double share = (double)covered[k] / CASES;
        print_message("common %g: %s %.1f %%\n", common, names[k], 100 * share);
        if (fabs(share - 0.95) > margin)
            fail_msg("common %g: %s: %d of %d intervals hold the truth", common, names[k],
                     covered[k], CASES);
    }
}

static void test_coverage(void **state) {
    (void)state;
    check_coverage(1);
    check_coverage(0.5);
    check_coverage(0);
}

/* By hand: errors 3 and 4 in two channels, all of one cause or of two; beside them 12 of another.
 */
static void test_sums_of_errors(void **state) {
    float own[] = {3, 4}, all[] = {5, sqrtf(160)};
    const mcv_image render_error = {.width = 1, .height = 1, .channels = 2, .pixels = own},
                    errors = {.width = 1, .height = 1, .channels = 2, .pixels = all};
    static const struct {
        uint64_t channel;
        double shared, truth;
    } cases[] = {{0, 1, 0.5 * 7}, {0, 0, 0.5 * 5}, {1, 1, 3}, {2, 0, 4}, {0, -1, 0.5}};
    mcv_image out;
    mcv_error error = {""};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        assert_int_equal(mcv_choose_errors(cases[i].channel, "a", &render_error, &render_error,
                                           cases[i].shared, &out, &error),
                         MCV_OK);
        assert_float_equal(out.pixels[0], cases[i].truth, 1e-6);
        mcv_image_free(&out);
    }
    /* √(7² + 4² + 12²)/2, the others being 4 = √(5² - 3²) and 12 = √(160 - 4²). */
    assert_int_equal(mcv_choose_errors(0, "a", &errors, &render_error, 1, &out, &error), MCV_OK);
    assert_float_equal(out.pixels[0], 0.5 * sqrt(49 + 16 + 144), 1e-5);
    mcv_image_free(&out);
    assert_int_equal(mcv_choose_errors(0, "a", &errors, NULL, 1, &out, &error), MCV_OK);
    assert_float_equal(out.pixels[0], 0.5 * sqrt(25 + 160), 1e-5);
    mcv_image_free(&out);
    assert_int_equal(mcv_choose_errors(3, "a", &errors, NULL, 1, &out, &error), MCV_USAGE);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_coverage),
        cmocka_unit_test(test_sums_of_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
