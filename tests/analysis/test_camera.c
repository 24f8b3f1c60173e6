/* SPDX-License-Identifier: Apache-2.0 */
/* The camera against the laws of EMVA 1288, and its random numbers against their distributions.
 * Seeds are fixed, so is the outcome. */
#include "test.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "analysis/camera.h"
#include "analysis/noise.h"
#include "io/values.h"

/* --- random numbers
 * --------------------------------------------------------------------------------------------- */

/* Known answers of the generator's authors (Random123, kat_vectors: philox4x32, 10 rounds). */
static void test_philox_known_answers(void **state) {
    static const uint32_t cases[3][10] = {
        {0, 0, 0, 0, 0, 0, 0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8},
        {0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0x408f276d,
         0x41c83b0e, 0xa20bc7c6, 0x6d5451fd},
        {0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344, 0xa4093822, 0x299f31d0, 0xd16cfe09,
         0x94fdcceb, 0x5001e420, 0x24126ea1}};
    (void)state;
    for (int i = 0; i < 3; ++i) {
        uint32_t words[4];
        mcv_philox(cases[i], cases[i] + 4, words);
        assert_memory_equal(words, cases[i] + 6, sizeof words);
    }
}

/* Q(a, x) = 1 - P(a, x) by the series of P (DLMF 8.11.4), good to 1e-12 for the x <= 300 of this
 * test. */
static double chi2_p(double chi2, double freedom) {
    const double a = freedom / 2, x = chi2 / 2;
    double term = 1 / a, sum = term;
    for (int n = 1; term > 1e-17 * sum; ++n) sum += term *= x / (a + n);
    return fmax(0, 1 - sum * exp(a * log(x) - x - lgamma(a)));
}

enum { MAX_BINS = 256, DRAWS = 400000, MIN_EXPECTED = 10 };

/*
 * Pearson's chi² of DRAWS numbers of this mean against the Poisson distribution of `expected`:
 * classes of equal width, about an eighth of a standard deviation, within 5 standard deviations;
 * neighbours are pooled until MIN_EXPECTED are expected.
 */
static double poisson_p(double mean, double expected, uint32_t seed, double *chi2, int *freedom) {
    const double sigma = sqrt(expected);
    const double width = fmax(1, floor(sigma / 8));
    const double first = fmax(0, floor(expected - 5 * sigma));
    const int bins = (int)fmin(MAX_BINS, ceil((expected + 5 * sigma - first) / width) + 2);
    double counts[MAX_BINS] = {0}, chances[MAX_BINS] = {0}, below = 0;
    for (int i = 0; i < DRAWS; ++i) {
        mcv_noise noise = mcv_noise_begin(seed, 0, (uint64_t)i);
        const double bin = floor((mcv_noise_poisson(&noise, mean) - first) / width);
        counts[(int)fmin(fmax(bin, 0), bins - 1)] += 1;
    }
    for (int b = 0; b < bins - 1; ++b) {
        for (double k = first + b * width; k < first + (b + 1) * width; ++k)
            chances[b] += exp(k * log(expected) - expected - lgamma(k + 1));
        below += chances[b];
    }
    /* Beyond 5 sigma lie fewer than MIN_EXPECTED: the last class takes what is missing. */
    chances[bins - 1] = fmax(0, 1 - below);
    double observed = 0, share = 0, last_observed = 0, last_share = 0;
    *chi2 = 0;
    *freedom = -1;
    for (int b = 0; b < bins; ++b) {
        observed += counts[b];
        share += chances[b];
        if (DRAWS * share < MIN_EXPECTED && b < bins - 1) continue;
        if (DRAWS * share < MIN_EXPECTED) { /* what is left goes to the class before */
            *chi2 -= pow(last_observed - DRAWS * last_share, 2) / (DRAWS * last_share);
            --*freedom;
            observed += last_observed;
            share += last_share;
        }
        *chi2 += pow(observed - DRAWS * share, 2) / (DRAWS * share);
        ++*freedom;
        last_observed = observed;
        last_share = share;
        observed = share = 0;
    }
    return chi2_p(*chi2, *freedom);
}

/* Each of 11 means at alpha = 1e-3 / 11; the control, a mean that is 8 standard errors off, must be
 * refused at the same level. */
static void test_poisson_chi2(void **state) {
    static const double means[] = {0.01, 0.1, 1, 5, 10, 30, 100, 1e3, 1e4, 1e5, 1e6};
    enum { COUNT = sizeof means / sizeof means[0] };
    const double alpha = 1e-3 / COUNT;
    (void)state;
    for (int i = 0; i < COUNT; ++i) {
        double chi2;
        int freedom;
        double p = poisson_p(means[i], means[i], 1, &chi2, &freedom);
        print_message("mean %g: chi2 %.1f, %d degrees of freedom, p = %.3g\n", means[i], chi2,
                      freedom, p);
        if (!(p >= alpha))
            fail_msg("mean %g: chi2 = %g with %d degrees of freedom, p = %g", means[i], chi2,
                     freedom, p);
        const double wrong = means[i] + 8 * sqrt(means[i] / DRAWS);
        p = poisson_p(wrong, means[i], 1, &chi2, &freedom);
        if (!(p < alpha))
            fail_msg("mean %g: numbers of the mean %g were not refused: p = %g", means[i], wrong,
                     p);
    }
}

/* The seam between the two methods: just below and above 10 the same numbers are expected, each
 * tested as above. */
static void test_poisson_at_the_seam(void **state) {
    double chi2;
    int freedom;
    (void)state;
    const double p[2] = {poisson_p(nextafter(10, 0), 10, 2, &chi2, &freedom),
                         poisson_p(10, 10, 3, &chi2, &freedom)};
    for (int i = 0; i < 2; ++i)
        if (!(p[i] >= 1e-3 / 2)) fail_msg("method %d: p = %g", i, p[i]);
    mcv_noise noise = mcv_noise_begin(0, 0, 0);
    assert_true(mcv_noise_poisson(&noise, 0) == 0);
}

/* Moments 1 to 4 of a normal distribution are 0, 1, 0, 3; powers 1 to 4 have the variances 1, 2,
 * 15, 96. Five standard errors. */
static void test_normal_moments(void **state) {
    static const double moments[] = {0, 1, 0, 3}, variances[] = {1, 2, 15, 96};
    enum { COUNT = 1000000 };
    double sums[4] = {0};
    (void)state;
    for (int i = 0; i < COUNT; ++i) {
        mcv_noise noise = mcv_noise_begin(4, 1, (uint64_t)i);
        const double x = mcv_noise_normal(&noise);
        double power = 1;
        for (int k = 0; k < 4; ++k) sums[k] += power *= x;
    }
    for (int k = 0; k < 4; ++k) {
        const double off = fabs(sums[k] / COUNT - moments[k]),
                     allowed = 5 * sqrt(variances[k] / COUNT);
        if (off > allowed) fail_msg("moment %d is %g off, more than %g", k + 1, off, allowed);
    }
}

/* --- the camera
 * -------------------------------------------------------------------------------------------------
 */

enum { SIDE = 1000 };

static mcv_image flat(uint32_t side, float value) {
    mcv_image image;
    mcv_error error = {""};
    if (mcv_image_new(&image, side, side, 1, &error) != MCV_OK) fail_msg("%s", error.text);
    for (size_t i = 0; i < (size_t)side * side; ++i) image.pixels[i] = value;
    return image;
}

static mcv_exposure expose(const mcv_camera *camera, const mcv_image *light) {
    mcv_exposure exposure;
    mcv_error error = {""};
    if (mcv_camera_expose(camera, light, NULL, &exposure, &error) != MCV_OK)
        fail_msg("%s", error.text);
    return exposure;
}

/* Mean and unbiased variance. */
static void moments(const mcv_image *image, double *mean, double *variance) {
    const size_t count = (size_t)image->width * image->height * image->channels;
    double sum = 0, squares = 0;
    for (size_t i = 0; i < count; ++i) sum += image->pixels[i];
    *mean = sum / (double)count;
    for (size_t i = 0; i < count; ++i) squares += pow(image->pixels[i] - *mean, 2);
    *variance = squares / ((double)count - 1);
}

/*
 * mu_y = black + K mu_e and sigma_y² = K² (mu_e + sigma_d²) + 1/12, within 5 standard errors of N
 * pixels. The fourth central moment of Poisson plus normal noise is 3 s² + mu_e (s = mu_e +
 * sigma_d², in electrons), so that the variance of the sample variance is (2 s² + mu_e)/N times K⁴.
 * Rounding adds 1/12 independent of the rest up to exp(-2 pi² sigma_y²) (Sheppard, Widrow): nothing
 * from the smallest sigma_y here, 2.0 DN, on.
 */
static void test_mean_and_variance_laws(void **state) {
    static const double electrons[] = {0, 0.5, 30, 1000, 8000};
    static const double gains[] = {0.4, 2.5};
    const double count = (double)SIDE * SIDE;
    (void)state;
    for (int g = 0; g < 2; ++g) {
        for (int i = 0; i < 5; ++i) {
            const mcv_camera camera = {.electrons_per_unit = {1000, 1000, 1000},
                                       .full_well = 20000,
                                       .gain = gains[g],
                                       .read_noise = 5,
                                       .bits = 16,
                                       .black_level = 100,
                                       .seed = (uint32_t)(10 * g + i)};
            mcv_image light = flat(SIDE, (float)(electrons[i] / 1000));
            mcv_exposure exposure = expose(&camera, &light);
            const double k2 = gains[g] * gains[g];
            const double mu = 1000 * (double)light.pixels[0]; /* as rounded to float */
            const double s = mu + 25;
            double mean, variance;
            moments(&exposure.grey, &mean, &variance);
            const double mean_off = fabs(mean - (100 + gains[g] * mu));
            const double mean_allowed = 5 * sqrt((k2 * s + 1.0 / 12) / count);
            if (mean_off > mean_allowed)
                fail_msg("%g e-, K = %g: mean %g is %g off, more than %g", mu, gains[g], mean,
                         mean_off, mean_allowed);
            const double expected = k2 * s + 1.0 / 12;
            const double allowed = 5 * sqrt((2 * expected * expected + k2 * k2 * mu) / count);
            if (fabs(variance - expected) > allowed)
                fail_msg("%g e-, K = %g: variance %g instead of %g +- %g", mu, gains[g], variance,
                         expected, allowed);
            assert_true(exposure.saturated == 0 && exposure.below_zero == 0);
            mcv_exposure_free(&exposure);
            mcv_image_free(&light);
        }
    }
}

/* The photon transfer curve as EMVA 1288 evaluates it: the slope of variance over mean is K, within
 * 0.5 % (its standard error here is 0.1
 * %). */
static void test_photon_transfer_gives_the_gain(void **state) {
    enum { LEVELS = 8 };
    const mcv_camera camera = {.electrons_per_unit = {1, 1, 1},
                               .full_well = 20000,
                               .gain = 0.2,
                               .read_noise = 4,
                               .bits = 12,
                               .black_level = 64,
                               .seed = 7};
    double x[LEVELS], y[LEVELS], mx = 0, my = 0, xy = 0, xx = 0;
    (void)state;
    for (int i = 0; i < LEVELS; ++i) {
        mcv_image light = flat(SIDE, (float)(2000 * i));
        mcv_exposure exposure = expose(&camera, &light);
        moments(&exposure.grey, &x[i], &y[i]);
        mx += x[i] / LEVELS;
        my += y[i] / LEVELS;
        mcv_exposure_free(&exposure);
        mcv_image_free(&light);
    }
    for (int i = 0; i < LEVELS; ++i) {
        xy += (x[i] - mx) * (y[i] - my);
        xx += (x[i] - mx) * (x[i] - mx);
    }
    const double gain = xy / xx;
    if (fabs(gain / 0.2 - 1) > 0.005)
        fail_msg("the photon transfer curve gives K = %g instead of 0.2", gain);
}

/* Without noise a grey value is the line, rounded: within half a grey value, to the rounding of the
 * doubles. */
static void test_linear_without_noise(void **state) {
    const mcv_camera camera = {.electrons_per_unit = {30000, 30000, 30000},
                               .full_well = 30000,
                               .gain = 65000.0 / 30000,
                               .read_noise = 9,
                               .bits = 16,
                               .black_level = 500,
                               .noise_free = true};
    mcv_image light = flat(256, 0);
    (void)state;
    for (size_t i = 0; i < 65536; ++i) light.pixels[i] = (float)i / 65536;
    mcv_exposure exposure = expose(&camera, &light);
    for (size_t i = 0; i < 65536; ++i) {
        const double line = 500 + 65000 * (double)light.pixels[i];
        const double off = fabs((double)exposure.grey.pixels[i] - line);
        if (off > 0.5 + 65535 * 4 * 0x1p-53)
            fail_msg("light %g: grey value %g is %g off", light.pixels[i], exposure.grey.pixels[i],
                     off);
    }
    assert_true(exposure.saturated == 0);
    assert_true(exposure.brightest == 30000 * 65535.0 / 65536);
    mcv_exposure_free(&exposure);
    mcv_image_free(&light);
}

static void test_same_seed_same_bits(void **state) {
    mcv_camera camera = {.electrons_per_unit = {500, 500, 500},
                         .full_well = 1e4,
                         .gain = 1,
                         .read_noise = 5,
                         .bits = 14,
                         .black_level = 50,
                         .seed = 3};
    mcv_image light = flat(64, 1);
    (void)state;
    mcv_exposure a = expose(&camera, &light), b = expose(&camera, &light);
    const size_t bytes = 64 * 64 * sizeof(float);
    assert_memory_equal(a.grey.pixels, b.grey.pixels, bytes);
    /* A pixel's noise depends on its place alone, not on the pixels around it. */
    mcv_image part = light;
    part.height = 5;
    mcv_exposure c = expose(&camera, &part);
    assert_memory_equal(a.grey.pixels, c.grey.pixels, bytes * 5 / 64);
    camera.seed = 4;
    mcv_exposure d = expose(&camera, &light);
    double same = 0;
    for (size_t i = 0; i < 64 * 64; ++i) same += a.grey.pixels[i] == d.grey.pixels[i];
    /* Chance meetings of a normal distribution: 1/(2 √pi sigma) = 1.2 % at sigma = √525; 4 % is 15
     * standard deviations beyond it. */
    if (same > 0.04 * 64 * 64) fail_msg("another seed left %g of 4096 grey values", same);
    mcv_exposure_free(&a);
    mcv_exposure_free(&b);
    mcv_exposure_free(&c);
    mcv_exposure_free(&d);
    mcv_image_free(&light);
}

/* The noise of neighbours and of channels is independent: correlations within 5/√N. */
static void test_noise_is_white(void **state) {
    const mcv_camera camera = {.electrons_per_unit = {500, 500, 500},
                               .full_well = 1e4,
                               .gain = 1,
                               .read_noise = 5,
                               .bits = 14,
                               .black_level = 50};
    mcv_image light;
    mcv_error error = {""};
    (void)state;
    assert_int_equal(mcv_image_new(&light, SIDE, SIDE, 2, &error), MCV_OK);
    for (size_t i = 0; i < 2 * (size_t)SIDE * SIDE; ++i) light.pixels[i] = 1;
    mcv_exposure exposure = expose(&camera, &light);
    double mean, variance;
    moments(&exposure.grey, &mean, &variance);
    static const size_t steps[] = {1, SIDE, (size_t)SIDE * SIDE};
    for (int s = 0; s < 3; ++s) {
        double product = 0;
        const size_t count = 2 * (size_t)SIDE * SIDE - steps[s];
        for (size_t i = 0; i < count; ++i)
            product +=
                (exposure.grey.pixels[i] - mean) * (exposure.grey.pixels[i + steps[s]] - mean);
        const double correlation = product / (double)count / variance;
        if (fabs(correlation) > 5 / sqrt((double)count))
            fail_msg("pixels %zu apart are correlated by %g", steps[s], correlation);
    }
    mcv_exposure_free(&exposure);
    mcv_image_free(&light);
}

static void test_saturation_and_black_level(void **state) {
    /* Pixels of 0, 1/2 and 2 full wells; gain so that the full well is 200 of 255. */
    float pixels[] = {0, 0.5F, 2};
    const mcv_image light = {.width = 3, .height = 1, .channels = 1, .pixels = pixels};
    mcv_camera camera = {.electrons_per_unit = {1000, 1000, 1000},
                         .full_well = 1000,
                         .gain = 0.19,
                         .bits = 8,
                         .black_level = 10,
                         .noise_free = true};
    (void)state;
    mcv_exposure exposure = expose(&camera, &light);
    assert_true(exposure.grey.pixels[0] == 10);
    assert_true(exposure.grey.pixels[1] == 105);
    assert_true(exposure.grey.pixels[2] == 200);
    assert_int_equal(exposure.saturated, 1);
    assert_true(exposure.brightest == 2000);
    mcv_exposure_free(&exposure);

    /* The converter's range ends before the full well. */
    camera.gain = 1;
    exposure = expose(&camera, &light);
    assert_true(exposure.grey.pixels[1] == 255 && exposure.grey.pixels[2] == 255);
    assert_int_equal(exposure.saturated, 2);
    mcv_exposure_free(&exposure);

    /* With noise a full pixel stays full, even where its Poisson number would be beyond every
     * integer. */
    pixels[2] = 1e30F;
    camera = (mcv_camera){.electrons_per_unit = {1000, 1000, 1000},
                          .full_well = 1000,
                          .gain = 0.19,
                          .bits = 8,
                          .black_level = 10};
    exposure = expose(&camera, &light);
    assert_true(exposure.grey.pixels[2] == 200);
    mcv_exposure_free(&exposure);

    /* Black level 0: a dark pixel lies below it where 2 Z, Z being standard normal, rounds below 0:
     * Z < -1/4. */
    mcv_image dark = flat(SIDE, 0);
    camera = (mcv_camera){
        .electrons_per_unit = {1, 1, 1}, .full_well = 1000, .gain = 1, .read_noise = 2, .bits = 8};
    exposure = expose(&camera, &dark);
    const double share = (double)exposure.below_zero / ((double)SIDE * SIDE),
                 expected = 0.5 * erfc(0.25 / sqrt(2));
    if (fabs(share - expected) > 5 * sqrt(expected * (1 - expected)) / SIDE)
        fail_msg("%g of the dark pixels are below zero instead of %g", share, expected);
    mcv_exposure_free(&exposure);
    mcv_image_free(&dark);
}

/* EMVA 1288: mu_p = 50.34 A t lambda E for A in µm², t in ms, lambda in µm, E in µW/cm²; its
 * constant has four digits. */
static void test_photons_as_in_the_standard(void **state) {
    (void)state;
    const double ours = mcv_camera_electrons_per_irradiance(2e-3, 0.5, 550e-9, 3.45e-6 * 3.45e-6);
    const double standard = 0.5 * 50.34 * 3.45 * 3.45 * 2 * 0.55 * 100; /* 1 W/m² is 100 µW/cm² */
    if (fabs(ours / standard - 1) > 0.005 / 50.34)
        fail_msg("%g electrons instead of %g", ours, standard);
}

/* Covariance of the two images' values, over count - 1. */
static double covariance(const mcv_image *a, const mcv_image *b) {
    const size_t count = (size_t)a->width * a->height;
    double mean_a, mean_b, unused, sum = 0;
    moments(a, &mean_a, &unused);
    moments(b, &mean_b, &unused);
    for (size_t i = 0; i < count; ++i) sum += (a->pixels[i] - mean_a) * (b->pixels[i] - mean_b);
    return sum / ((double)count - 1);
}

/*
 * What two exposures have in common is the fixed pattern: its variance is K² (DSNU² + PRNU² mu_e²),
 * the temporal one K² (mu_e + mu_d + sigma_d0²) + 1/12, half the variance of their difference. A
 * covariance of N pairs has the standard error √((v² + c²)/N), v the variance of each and c the
 * covariance; a variance of N normal values v √(2/N).
 */
static void test_fixed_pattern_and_dark_current(void **state) {
    static const double electrons[] = {0, 4000};
    const double count = (double)SIDE * SIDE, k2 = 0.5 * 0.5;
    (void)state;
    for (int i = 0; i < 2; ++i) {
        mcv_camera camera = {.electrons_per_unit = {1, 1, 1},
                             .dark_electrons = 60,
                             .full_well = 20000,
                             .gain = 0.5,
                             .read_noise = 5,
                             .dsnu = 8,
                             .prnu = 0.01,
                             .bits = 16,
                             .black_level = 100,
                             .specimen = 3,
                             .seed = 1};
        mcv_image light = flat(SIDE, (float)electrons[i]);
        mcv_exposure a = expose(&camera, &light);
        camera.seed = 2;
        mcv_exposure b = expose(&camera, &light);
        camera.specimen = 4;
        mcv_exposure other = expose(&camera, &light);
        const double pattern = k2 * (64 + pow(0.01 * electrons[i], 2)),
                     temporal = k2 * (electrons[i] + 60 + 25) + 1.0 / 12;
        const double sum = pattern + temporal;
        double mean, variance;
        moments(&a.grey, &mean, &variance);
        const double expected = 100 + 0.5 * (electrons[i] + 60);
        if (fabs(mean - expected) > 5 * sqrt(sum / count))
            fail_msg("%g e-: mean %g instead of %g", electrons[i], mean, expected);
        const double fixed = covariance(&a.grey, &b.grey),
                     allowed = 5 * sqrt((sum * sum + pattern * pattern) / count);
        if (fabs(fixed - pattern) > allowed)
            fail_msg("%g e-: the pattern's variance is %g instead of %g", electrons[i], fixed,
                     pattern);
        if (fabs(variance - sum) > 5 * sum * sqrt(2.1 / count))
            fail_msg("%g e-: variance %g instead of %g", electrons[i], variance, sum);
        const double strange = covariance(&a.grey, &other.grey);
        if (fabs(strange) > 5 * sum / sqrt(count))
            fail_msg("two cameras share a pattern: covariance %g", strange);
        /* The stated uncertainty, the same all over, is that of the model. */
        assert_true(fabs(a.uncertainty.pixels[0] - sqrt(sum)) < 1e-6 * sqrt(sum));
        mcv_exposure_free(&a);
        mcv_exposure_free(&b);
        mcv_exposure_free(&other);
        mcv_image_free(&light);
    }
}

/* The light's uncertainty adds K R SE to the camera's own part, and nothing where the pixel is
 * saturated. */
static void test_uncertainty_of_the_light(void **state) {
    float values[] = {3, 50}, errors[] = {0.25F, 0.5F};
    const mcv_image light = {.width = 2, .height = 1, .channels = 1, .pixels = values};
    const mcv_image light_error = {.width = 2, .height = 1, .channels = 1, .pixels = errors};
    const mcv_camera camera = {.electrons_per_unit = {100, 1, 1},
                               .full_well = 1000,
                               .gain = 2,
                               .read_noise = 7,
                               .bits = 12};
    const double expected = sqrt(4 * (300 + 49 + 625) + 1.0 / 12);
    mcv_exposure exposure;
    mcv_error error = {""};
    (void)state;
    assert_int_equal(mcv_camera_expose(&camera, &light, &light_error, &exposure, &error), MCV_OK);
    assert_true(fabs(exposure.uncertainty.pixels[0] / expected - 1) < 1e-6);
    assert_true(exposure.render.pixels[0] == 50 && exposure.render.pixels[1] == 0);
    mcv_exposure_free(&exposure);
    assert_int_equal(mcv_camera_expose(&camera, &light, NULL, &exposure, &error), MCV_OK);
    assert_null(exposure.render.pixels);
    mcv_exposure_free(&exposure);
}

/* --- the level
 * --------------------------------------------------------------------------------------------------
 */

enum { WIDE = 320, HIGH = 256 };

/* Half of the picture is 1, with a slope of 10 % down it; the rest 0.05. Or two bright lines of two
 * pixels on the black. */
static double truth_at(bool lines, uint32_t x, uint32_t y) {
    if (lines) return x % 160 == 77 || x % 160 == 78 ? 1 : 0.001;
    return x < WIDE / 2 ? 1 - 0.1 * y / HIGH : 0.05;
}

enum { COLOURS = 3 };

/*
 * As a render of so many samples in 4 replicates: each sample's deviation is twice its mean, which
 * 16 of them bring to a half. Channels are the picture times their colour, errors and all.
 */
static mcv_quantity level_of_colours(bool lines, double samples, uint32_t seed, uint32_t channels,
                                     const double colour[COLOURS]) {
    mcv_image light, light_error;
    mcv_error error = {""};
    assert_int_equal(mcv_image_new(&light, WIDE, HIGH, channels, &error), MCV_OK);
    assert_int_equal(mcv_image_new(&light_error, WIDE, HIGH, channels, &error), MCV_OK);
    for (uint32_t i = 0; i < WIDE * HIGH; ++i) {
        mcv_noise noise = mcv_noise_begin((uint32_t)samples, seed, i);
        const double truth = truth_at(lines, i % WIDE, i / WIDE),
                     deviation = 2 * truth / sqrt(samples / 4);
        double replicates[4], mean = 0, squares = 0;
        for (int k = 0; k < 4; ++k)
            mean += (replicates[k] = truth + deviation * mcv_noise_normal(&noise)) / 4;
        for (int k = 0; k < 4; ++k) squares += pow(replicates[k] - mean, 2);
        for (uint32_t c = 0; c < channels; ++c) {
            light.pixels[c * WIDE * HIGH + i] = (float)(colour[c] * mean);
            light_error.pixels[c * WIDE * HIGH + i] = (float)(colour[c] * sqrt(squares / 12));
        }
    }
    const mcv_quantity level = mcv_camera_level(&light, &light_error, 1, (const double[]){5, 5, 5});
    mcv_image_free(&light);
    mcv_image_free(&light_error);
    return level;
}

static mcv_quantity level_of(bool lines, double samples, uint32_t seed) {
    return level_of_colours(lines, samples, seed, 1, (const double[]){1, 0, 0});
}

/*
 * Within 1 % of each other for 16 to 4096 samples, and of the truth: between the mean and the
 * largest value of the plateau, 0.95 and 1 of 5; of lines that fill 1/80, 1 by their own brightness
 * but for the black, 0.001 · 79.
 */
static void test_level(void **state) {
    static const double samples[] = {16, 256, 4096};
    (void)state;
    for (int lines = 0; lines < 2; ++lines) {
        const double last = level_of(lines, 4096, 0).value;
        const double low = lines ? 1 / (1 + 0.001 * 79) - 0.005 : 0.95;
        if (!(last > 5 * low && last < 5))
            fail_msg("level %g is not within %g and 5", last, 5 * low);
        for (int i = 0; i < 3; ++i) {
            const double level = level_of(lines, samples[i], 0).value;
            if (fabs(level / last - 1) > 0.01)
                fail_msg("level %g of %g samples, but %g of 4096", level, samples[i], last);
        }
    }
    float black[1] = {0};
    const mcv_image dark = {.width = 1, .height = 1, .channels = 1, .pixels = black};
    assert_true(mcv_camera_level(&dark, NULL, 1, (const double[]){1, 1, 1}).value == 0);
}

/*
 * The stated uncertainty, against the spread of 40 pictures of 16 samples: their deviation is known
 * to 1/√78 = 11 %, 3 of which are allowed; 4 u^4 in place of at most 3 u^4 adds up to 4 % where the
 * error is a half of the value. The mean of 40 is the level of 4096 samples within 3.3 of its own
 * deviations.
 */
static void test_level_uncertainty(void **state) {
    enum { PICTURES = 40 };
    (void)state;
    for (int lines = 0; lines < 2; ++lines) {
        const mcv_quantity last = level_of(lines, 4096, 0);
        double sum = 0, squares = 0, stated = 0;
        for (uint32_t n = 1; n <= PICTURES; ++n) {
            const mcv_quantity level = level_of(lines, 16, n);
            sum += level.value;
            squares += level.value * level.value;
            stated += level.uncertainty / PICTURES;
        }
        const double mean = sum / PICTURES,
                     deviation = sqrt((squares - sum * mean) / (PICTURES - 1));
        if (deviation > 1.37 * stated || stated > 1.41 * deviation)
            fail_msg("%s: a deviation of %g, but %g is stated", lines ? "lines" : "plateau",
                     deviation, stated);
        if (fabs(mean - last.value) > 3.3 * hypot(deviation / sqrt(PICTURES), last.uncertainty))
            fail_msg("%s: %g in the mean, but %g of 4096 samples", lines ? "lines" : "plateau",
                     mean, last.value);
    }
}

/*
 * The same of three channels, which the brightest rules where they differ: taken as alike they
 * would have up to twice the uncertainty. The lines are told by pixels, the plateau by squares. Of
 * 60 pictures the deviation is known to 1/√118 = 9.2 %, 3 of which are allowed, and to the other
 * side the 4 % above.
 */
static void test_level_uncertainty_of_colours(void **state) {
    enum { PICTURES = 60 };
    static const double colours[][COLOURS] = {{1, 1, 1}, {1, 0.5, 0.3}, {1, 0.9, 0.8}};
    (void)state;
    for (int k = 0; k < 2 * 3; ++k) {
        const bool lines = k % 2;
        const double *colour = colours[k / 2];
        double sum = 0, squares = 0, stated = 0;
        for (uint32_t n = 1; n <= PICTURES; ++n) {
            const mcv_quantity level = level_of_colours(lines, 16, n, COLOURS, colour);
            sum += level.value;
            squares += level.value * level.value;
            stated += level.uncertainty / PICTURES;
        }
        const double deviation = sqrt((squares - sum * sum / PICTURES) / (PICTURES - 1));
        print_message("%s, channels %g %g %g: stated %.4f, seen %.4f\n",
                      lines ? "lines" : "plateau", colour[0], colour[1], colour[2], stated,
                      deviation);
        if (deviation > 1.28 * stated || stated > 1.32 * deviation)
            fail_msg("%s, channels %g %g %g: a deviation of %g, but %g is stated",
                     lines ? "lines" : "plateau", colour[0], colour[1], colour[2], deviation,
                     stated);
    }
}

/* Each pixel of the mosaic reads its colour's channel with its colour's sensitivity; grey light
 * falls on all. */
static void test_bayer_patterns(void **state) {
    float pixels[3 * 16];
    (void)state;
    for (int i = 0; i < 48; ++i) pixels[i] = (float)(10 * (1 + (i >= 16) + (i >= 32)));
    for (uint32_t bayer = MCV_BAYER_RGGB; bayer <= MCV_BAYER_GBRG; ++bayer) {
        for (uint32_t channels = 1; channels <= 3; channels += 2) {
            const mcv_image light = {
                .width = 4, .height = 4, .channels = channels, .pixels = pixels};
            const mcv_camera camera = {.electrons_per_unit = {1, 2, 3},
                                       .full_well = 1000,
                                       .gain = 1,
                                       .bits = 8,
                                       .bayer = bayer,
                                       .noise_free = true};
            mcv_exposure exposure = expose(&camera, &light);
            assert_int_equal(exposure.grey.channels, 1);
            for (int i = 0; i < 16; ++i) {
                const char letter = mcv_bayer_patterns[bayer][i / 4 % 2 * 2 + i % 2];
                const int colour = letter == 'R' ? 0 : letter == 'G' ? 1 : 2;
                const double expected = (colour + 1) * (channels == 1 ? 10 : 10 * (colour + 1));
                if (exposure.grey.pixels[i] != expected)
                    fail_msg("%s, pixel %d: %g instead of %g", mcv_bayer_patterns[bayer], i,
                             exposure.grey.pixels[i], expected);
            }
            mcv_exposure_free(&exposure);
        }
    }
}

/* --- files
 * ------------------------------------------------------------------------------------------------------
 */

static void round_trip(const char *path, uint32_t channels, int bits) {
    mcv_image written, read;
    mcv_error error = {""};
    assert_int_equal(mcv_image_new(&written, 61, 37, channels, &error), MCV_OK);
    const size_t count = (size_t)61 * 37 * channels;
    for (size_t i = 0; i < count; ++i)
        written.pixels[i] = (float)(i * 7919 % (bits == 8 ? 256 : 65536));
    if (mcv_values_write(path, &written, bits, &error) != MCV_OK) fail_msg("%s", error.text);
    if (mcv_values_read(path, &read, &error) != MCV_OK) fail_msg("%s", error.text);
    assert_int_equal(read.width, 61);
    assert_int_equal(read.height, 37);
    assert_int_equal(read.channels, channels);
    for (size_t i = 0; i < count; ++i)
        if (read.pixels[i] != written.pixels[i])
            fail_msg("%s: value %zu: %g was written as %g", path, i, read.pixels[i],
                     written.pixels[i]);
    mcv_image_free(&written);
    mcv_image_free(&read);
}

/* Each beginning of the file is refused by a sentence with its name, or holds all of the pixels. */
static void expect_truncation_noticed(const char *path) {
    static char bytes[65536];
    FILE *file = fopen(path, "rb");
    const size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    for (size_t length = 0; length < size; length = length < 300 ? length + 1 : length + 97) {
        mcv_image read = {0};
        mcv_error error = {""};
        file = fopen(path, "wb");
        assert_int_equal(fwrite(bytes, 1, length, file), length);
        fclose(file);
        if (mcv_values_read(path, &read, &error) == MCV_OK)
            assert_int_equal(read.width, 61);
        else if (!strstr(error.text, path))
            fail_msg("%zu bytes of %s: %s", length, path, error.text);
        mcv_image_free(&read);
    }
}

static void test_files_of_values(void **state) {
    static const char *const paths[] = {"test_camera.png", "test_camera.tif", "test_camera.npy"};
    mcv_image read;
    mcv_error error = {""};
    (void)state;
    for (int i = 0; i < 3; ++i) {
        for (uint32_t channels = 1; channels <= 3; channels += 2)
            for (int bits = 8; bits <= 16; bits += 8) round_trip(paths[i], channels, bits);
        expect_truncation_noticed(paths[i]);
        unlink(paths[i]);
        assert_int_equal(mcv_values_read(paths[i], &read, &error), MCV_BAD_INPUT);
    }
    assert_int_equal(mcv_values_read("x.jpg", &read, &error), MCV_USAGE);
}

static void expect_refused(const mcv_camera *camera, const mcv_image *light, mcv_result code,
                           const char *part) {
    mcv_exposure exposure;
    mcv_error error = {""};
    assert_int_equal(mcv_camera_expose(camera, light, NULL, &exposure, &error), code);
    if (!strstr(error.text, part)) fail_msg("\"%s\" is missing in: %s", part, error.text);
    assert_null(exposure.grey.pixels);
}

static void test_bad_input(void **state) {
    float pixels[] = {1, 1, 1, 1};
    const mcv_image light = {.width = 2, .height = 2, .channels = 1, .pixels = pixels};
    const mcv_camera good = {
        .electrons_per_unit = {1, 1, 1}, .full_well = 1000, .gain = 1, .bits = 8};
    (void)state;
    const float bad[] = {NAN, INFINITY, -1e-9F};
    for (int i = 0; i < 3; ++i) {
        pixels[2] = bad[i];
        expect_refused(&good, &light, MCV_BAD_INPUT, "column 0, row 1, channel 0");
    }
    pixels[2] = 1;
    mcv_camera camera = good;
    camera.bits = 17;
    expect_refused(&camera, &light, MCV_USAGE, "17 bits");
    camera = good;
    camera.black_level = 256;
    expect_refused(&camera, &light, MCV_USAGE, "black level of 256");
    camera = good;
    camera.gain = 0;
    expect_refused(&camera, &light, MCV_USAGE, "gain of 0");
    camera = good;
    camera.read_noise = NAN;
    expect_refused(&camera, &light, MCV_USAGE, "read noise");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_philox_known_answers),
        cmocka_unit_test(test_poisson_chi2),
        cmocka_unit_test(test_poisson_at_the_seam),
        cmocka_unit_test(test_normal_moments),
        cmocka_unit_test(test_mean_and_variance_laws),
        cmocka_unit_test(test_photon_transfer_gives_the_gain),
        cmocka_unit_test(test_linear_without_noise),
        cmocka_unit_test(test_same_seed_same_bits),
        cmocka_unit_test(test_noise_is_white),
        cmocka_unit_test(test_saturation_and_black_level),
        cmocka_unit_test(test_photons_as_in_the_standard),
        cmocka_unit_test(test_fixed_pattern_and_dark_current),
        cmocka_unit_test(test_uncertainty_of_the_light),
        cmocka_unit_test(test_level),
        cmocka_unit_test(test_level_uncertainty),
        cmocka_unit_test(test_level_uncertainty_of_colours),
        cmocka_unit_test(test_bayer_patterns),
        cmocka_unit_test(test_files_of_values),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
