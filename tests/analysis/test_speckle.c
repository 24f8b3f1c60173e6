/* SPDX-License-Identifier: Apache-2.0 */
/* Speckle: its contrast in pixels of any size, its statistics, what makes it fainter, and the
 * camera that reads it. */
/* ctest: label truth */
#include "scene_builder.h"
#include "truths.h"

#include "analysis/read_speckle.h"
#include "analysis/speckle.h"

#include <math.h>
#include <stdlib.h>

static const double wavelength = 660e-9, f_number = 8;

static mcv_speckle speckle_of(double pitch, uint32_t seed) {
    return (mcv_speckle){.f_number = f_number,
                         .wavelength = wavelength,
                         .aperture = {.shape = MCV_APERTURE_DISC},
                         .pitch = {pitch, pitch},
                         .polarization = 1,
                         .patterns = 1,
                         .seed = seed};
}

/* Light of 1 everywhere, with its speckle; the caller frees it. */
static float *even_light(const mcv_speckle *speckle, uint32_t side, uint32_t q) {
    const size_t fine = (size_t)side * q * side * q;
    float *laser = malloc(fine * sizeof *laser),
          *light = malloc((size_t)side * side * sizeof *light);
    assert_true(laser && light);
    for (size_t i = 0; i < fine; ++i) laser[i] = 1;
    for (size_t i = 0; i < (size_t)side * side; ++i) light[i] = 1;
    BUILD(mcv_speckle_add(speckle, laser, q, side, side, light, &builder_error));
    free(laser);
    return light;
}

/* Mean and standard deviation, without the eighth of the side along the border, which diffraction
 * darkens. */
typedef struct moments {
    double count, sum, squares;
} moments;

static void add_moments(const float *light, uint32_t side, moments *m) {
    for (uint32_t row = side / 8; row < side - side / 8; ++row)
        for (uint32_t column = side / 8; column < side - side / 8; ++column) {
            const double change = (double)light[row * side + column] - 1;
            ++m->count;
            m->sum += change;
            m->squares += change * change;
        }
}

static double contrast_of(double ratio, uint32_t side, double polarization, double patterns,
                          uint32_t seeds, double *mean) {
    const double pixel = ratio * wavelength * f_number;
    const uint32_t q = mcv_speckle_subpixels(pixel, wavelength, f_number);
    moments m = {0, 0, 0};
    for (uint32_t seed = 1; seed <= seeds; ++seed) {
        mcv_speckle speckle = speckle_of(pixel / q, seed);
        speckle.polarization = polarization;
        speckle.patterns = patterns;
        float *light = even_light(&speckle, side, q);
        add_moments(light, side, &m);
        free(light);
    }
    *mean = 1 + m.sum / m.count;
    return sqrt(m.squares / m.count);
}

/*
 * The contrast of square pixels p behind a round stop, √(p^-4 ∬ (p - |x|)(p - |y|) (2
 * J1(πr)/(πr))²) by numerical integration, p in λN. Six pictures of 262 144 sub-pixels hold some 50
 * 000 pixels that are independent, or grains where these are larger: 0.3 % of the contrast. The
 * mean keeps within 0.9/√(8000 grains) = 1 %.
 */
static void test_contrast_of_pixels(void **state) {
    (void)state;
    static const struct {
        double ratio;
        uint32_t side;
        double contrast;
    } cases[] = {{0.5, 256, 0.906}, {1, 128, 0.711}, {2, 64, 0.440}, {4, 64, 0.246}};
    for (size_t i = 0; i < 4; ++i) {
        double mean;
        const double seen = contrast_of(cases[i].ratio, cases[i].side, 1, 1, 6, &mean);
        print_message("p/(λN) = %g: contrast %.4f, expected %.3f (%+.2f %%); mean %.4f\n",
                      cases[i].ratio, seen, cases[i].contrast, 100 * (seen / cases[i].contrast - 1),
                      mean);
        char what[96];
        snprintf(what, sizeof what, "T29 contrast of square pixels of %g grains", cases[i].ratio);
        note_truth(what, "program", fabs(seen / cases[i].contrast - 1), 0.01);
        if (!(fabs(seen / cases[i].contrast - 1) <= 0.01) || !(fabs(mean - 1) <= 0.015))
            fail_msg("p/(λN) = %g: contrast %g, expected %g; mean %g", cases[i].ratio, seen,
                     cases[i].contrast, mean);
    }
}

/*
 * Two polarisations have √((1 + p²)/2) of the contrast, M patterns 1/√M, also where M is no whole
 * number. The pixel of λN/4 alone leaves 0.975, which all share; the same seed has the same first
 * pattern, so that only some 3 % of chance is left.
 */
static void test_what_makes_it_fainter(void **state) {
    (void)state;
    double mean;
    const double whole = contrast_of(0.25, 256, 1, 1, 4, &mean);
    static const double cases[][3] = {
        {0, 1, 0.70711}, {0.6, 1, 0.82462}, {1, 2, 0.70711}, {1, 2.5, 0.63246}, {0, 3, 0.40825}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double seen = contrast_of(0.25, 256, cases[i][0], cases[i][1], 4, &mean) / whole;
        print_message("polarisation %g, %g patterns: %.4f, expected %.4f\n", cases[i][0],
                      cases[i][1], seen, cases[i][2]);
        note_truth("T29 contrast of two polarisations and of 2, 2.5 and 3 patterns", "program",
                   fabs(seen / cases[i][2] - 1), 0.03);
        if (!(fabs(seen / cases[i][2] - 1) <= 0.03))
            fail_msg("polarisation %g, %g patterns: %g, expected %g", cases[i][0], cases[i][1],
                     seen, cases[i][2]);
    }
    /* σ_λ = 1 nm/2.3548, σ_h = 10 µm: 8π · 6.434e-4 · 15.15 = 0.24501, and √(1 + 0.24501²). */
    assert_true(fabs(mcv_speckle_spectral_patterns(1e-9, 660e-9, 1e-5) - 1.029579) <= 1e-5);
    assert_true(mcv_speckle_spectral_patterns(0, 660e-9, 1e-5) == 1);
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/*
 * Of one pattern, p(I) = exp(-I): Kolmogorov and Smirnov's distance of n independent values is
 * above 1.95/√n with probability 1e-3. Values 3 λN apart are independent: the first zero of the
 * autocovariance lies at 1.22 λN, and beyond 3 λN it is below 1e-4. Pixels of λN/8 take 0.6 % off
 * the contrast, which moves the distribution by 0.002 at most. Two patterns, and the two
 * polarisations of depolarised light, have p(I) = 4 I exp(-2I).
 */
static void test_exponential(void **state) {
    (void)state;
    enum { SIDE = 384, STEP = 24, EDGE = 48, SEEDS = 8 };
    static double values[SEEDS * (SIDE / STEP) * (SIDE / STEP)];
    static const char *const truths[] = {
        "T29 exponential statistics: Kolmogorov-Smirnov distance",
        "T29 statistics of two patterns: Kolmogorov-Smirnov distance",
        "T29 statistics of depolarised light: Kolmogorov-Smirnov distance"};
    for (int i = 0; i < 3; ++i) {
        size_t n = 0;
        double distance = 0, of_one = 0;
        for (uint32_t seed = 1; seed <= SEEDS; ++seed) {
            mcv_speckle speckle = speckle_of(wavelength * f_number / 8, seed);
            speckle.patterns = i == 1 ? 2 : 1;
            speckle.polarization = i == 2 ? 0 : 1;
            float *light = even_light(&speckle, SIDE, 1);
            for (int row = EDGE; row < SIDE - EDGE; row += STEP)
                for (int column = EDGE; column < SIDE - EDGE; column += STEP)
                    values[n++] = (double)light[row * SIDE + column];
            free(light);
        }
        qsort(values, n, sizeof values[0], ascending);
        for (size_t k = 0; k < n; ++k) {
            const double v = values[k], one = -expm1(-v),
                         expected = i ? 1 - (1 + 2 * v) * exp(-2 * v) : one,
                         from = (double)k / (double)n, to = (double)(k + 1) / (double)n;
            distance = fmax(distance, fmax(to - expected, expected - from));
            of_one = fmax(of_one, fmax(to - one, one - from));
        }
        const double limit = 1.95 / sqrt((double)n) + 0.002;
        print_message("case %d, %zu values: distance %.4f, limit %.4f\n", i, n, distance, limit);
        note_truth(truths[i], "program", distance, limit);
        if (!(distance <= limit)) fail_msg("case %d: distance %g, limit %g", i, distance, limit);
        assert_int_equal(of_one <= limit, i == 0);
    }
}

/* --- apertures --- */

/* The even part of the transform of a disc, and the odd one of its halves, by Struve's function H1:
 * at a shift of s λN. */
static double disc_field(double s) { return s > 0 ? 2 * j1(M_PI * s) / (M_PI * s) : 1; }

static double half_field(double s) {
    double sum = 0;
    for (int k = 0; k < 40; ++k)
        sum += pow(-1, k) * pow(M_PI * s / 2, 2 * k + 2) / (tgamma(k + 1.5) * tgamma(k + 2.5));
    return 2 * sum / (M_PI * s);
}

static double sinc(double x) { return x == 0 ? 1 : sin(M_PI * x) / (M_PI * x); }

/* |µ|² at a shift of (right, up) λN: the transform of what is open, over its area. A square of
 * diagonal 2 has the side √2. */
static double covariance_of(const mcv_aperture_shape *a, double right, double up) {
    const double s = hypot(right, up), cell = M_SQRT2 / (2 * a->order);
    double re = 0, im = 0, open = 0;
    switch (a->shape) {
    case MCV_APERTURE_RING:
        re = (disc_field(s) - a->ratio * a->ratio * disc_field(a->ratio * s)) /
             (1 - a->ratio * a->ratio);
        return re * re;
    case MCV_APERTURE_HALF: /* at 45°, along the normal or across it */
        im = fabs(right - up) < 1e-9 ? half_field(s) : 0;
        return disc_field(s) * disc_field(s) + im * im;
    case MCV_APERTURE_BLADES:
        return pow(sinc(right / M_SQRT2) * sinc(up / M_SQRT2), 2);
    default:
        break;
    }
    for (uint32_t j = 0; j < a->order; ++j)
        for (uint32_t i = 0; i < a->order; ++i) {
            if (!mcv_code_is_open(a->order, i, j)) continue;
            const double x = (i - (a->order - 1) / 2.0) * cell,
                         y = ((a->order - 1) / 2.0 - j) * cell,
                         phase = 2 * M_PI * (x * right + y * up);
            re += cos(phase);
            im += sin(phase);
            ++open;
        }
    return (re * re + im * im) / (open * open) * pow(sinc(cell * right) * sinc(cell * up), 2);
}

/* The covariance of sub-pixels `right` and `down` apart, over their variance. */
static double seen_covariance(const mcv_aperture_shape *aperture, int right, int down) {
    enum { SIDE = 256, EDGE = 32, SEEDS = 8 };
    double sum = 0, squares = 0;
    for (uint32_t seed = 1; seed <= SEEDS; ++seed) {
        mcv_speckle speckle = speckle_of(wavelength * f_number / 4, seed);
        speckle.aperture = *aperture;
        float *light = even_light(&speckle, SIDE, 1);
        for (int row = EDGE; row < SIDE - EDGE; ++row)
            for (int column = EDGE; column < SIDE - EDGE; ++column) {
                const double here = (double)light[row * SIDE + column] - 1;
                sum += here * ((double)light[(row + down) * SIDE + column + right] - 1);
                squares += here * here;
            }
        free(light);
    }
    return sum / squares;
}

/*
 * The grains have the shape that the aperture's transform gives. Of each aperture some 8 · 48² λ²N²
 * hold at least 4000 grains: 0.016 of the variance, and 4.5 of that are 0.07. The pixels of λN/4
 * themselves leave 0.02 at most. The disc alone would miss each row by 0.1 or more, but for the
 * third, which tells the direction from the second.
 */
static void test_apertures(void **state) {
    (void)state;
    static const struct {
        mcv_aperture_shape aperture;
        int right, down; /* in λN/4 */
    } cases[] = {
        {{.shape = MCV_APERTURE_RING, .ratio = 0.8}, 6, 0},
        {{.shape = MCV_APERTURE_HALF, .rotation = M_PI / 4}, 3, -3},
        {{.shape = MCV_APERTURE_HALF, .rotation = M_PI / 4}, 3, 3},
        {{.shape = MCV_APERTURE_BLADES, .blades = 4, .rotation = M_PI / 4}, 3, 0},
        {{.shape = MCV_APERTURE_CODED, .order = 5}, 3, 0},
        {{.shape = MCV_APERTURE_CODED, .order = 5}, 0, 3},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double right = cases[i].right / 4.0, down = cases[i].down / 4.0,
                     expected = covariance_of(&cases[i].aperture, right, -down),
                     seen = seen_covariance(&cases[i].aperture, cases[i].right, cases[i].down),
                     disc = pow(disc_field(hypot(right, down)), 2);
        print_message("case %zu: covariance %.4f, expected %.4f, of the disc %.4f\n", i, seen,
                      expected, disc);
        note_truth("T29 covariance through rings, halves, blades and codes", "program",
                   fabs(seen - expected), 0.07);
        if (!(fabs(seen - expected) <= 0.07))
            fail_msg("case %zu: covariance %g, expected %g", i, seen, expected);
    }
}

/* --- the camera --- */

enum { WIDTH = 48, HEIGHT = 32, Q = 4 };

/* A picture of this size and light, in memory or in a file. */
static void fill(mcv_image *image, uint32_t width, uint32_t height, float value) {
    BUILD(mcv_image_new(image, width, height, 1, &builder_error));
    for (size_t i = 0; i < (size_t)width * height; ++i) image->pixels[i] = value;
}

static void write_laser(const char *path, uint32_t q, bool laser, const char *quantity) {
    mcv_exr_part part = {.name = "image"};
    const mcv_attribute attributes[] = {
        {.name = "mcvisi:quantity", .text = quantity},
        {.name = MCV_LASER_WAVELENGTH, .numbers = {wavelength}, .count = 1}};
    fill(&part.image, WIDTH * q, HEIGHT * q, 1);
    BUILD(mcv_exr_write(path, &part, 1, attributes, laser ? 2 : 1, &builder_error));
    mcv_image_free(&part.image);
}

static mcv_result read_out(const char *speckle, bool stop, const char *aperture, mcv_read_out *out,
                           mcv_error *error) {
    mcv_exr_part part = {.name = "image"};
    mcv_attribute attributes[] = {{.name = "mcvisi:quantity", .text = "irradiance"},
                                  {.name = "mcvisi:pixelSize",
                                   .numbers = {wavelength * f_number, wavelength * f_number},
                                   .count = 2},
                                  {.name = "mcvisi:fNumber", .numbers = {f_number}, .count = 1},
                                  {.name = "mcvisi:aperture", .text = aperture}};
    fill(&part.image, WIDTH, HEIGHT, 1);
    mcv_exr exr = {.parts = &part,
                   .part_count = 1,
                   .attributes = attributes,
                   .attribute_count = !stop      ? 2
                                      : aperture ? 4
                                                 : 3};
    const mcv_camera_settings settings = {.electrons_per_unit = {1000, 1000, 1000},
                                          .quantum_efficiency = {1, 1, 1},
                                          .wavelength = {wavelength, wavelength, wavelength},
                                          .lens_mtf = "none",
                                          .speckle = speckle,
                                          .speckle_polarization = 1,
                                          .speckle_patterns = 1,
                                          .camera = {.full_well = 1e5, .bits = 16, .gain = 1}};
    const mcv_result result = mcv_camera_read_out(&settings, "light.exr", &exr, out, error);
    mcv_image_free(&part.image);
    return result;
}

/*
 * Photons are counted of the light with its speckle: the variance of the grey values is the
 * speckle's (0.711 · 1000)² and the photons' 1000. Some 1200 grains leave 5 % of it, of which 4.5
 * are 23 %; speckle after the photons would not be told from it, but light without speckle has
 * 1000.
 */
static void test_camera(void **state) {
    (void)state;
    const char *path = MCV_BINARY_DIR "/tests/speckle_laser.exr";
    for (int speckled = 0; speckled < 2; ++speckled) {
        mcv_read_out out;
        double sum = 0, squares = 0;
        write_laser(path, Q, true, "irradiance");
        BUILD(read_out(speckled ? path : NULL, true, NULL, &out, &builder_error));
        for (int i = 0; i < WIDTH * HEIGHT; ++i) {
            const double change = (double)out.exposure.grey.pixels[i] - 1000;
            sum += change;
            squares += change * change;
        }
        const double expected = speckled ? 711.0 * 711 + 1000 : 1000,
                     seen = squares / (WIDTH * HEIGHT);
        if (!(fabs(seen / expected - 1) <= 0.23))
            fail_msg("variance %g, expected %g; mean %g", seen, expected,
                     1000 + sum / (WIDTH * HEIGHT));
        assert_true(out.speckle == (speckled ? 1 : 0));
        mcv_exposure_free(&out.exposure);
    }
}

static void test_bad_input(void **state) {
    (void)state;
    const char *path = MCV_BINARY_DIR "/tests/speckle_bad.exr";
    static const struct {
        uint32_t q;
        bool laser, stop;
        const char *quantity, *aperture, *says;
    } cases[] = {
        {Q, false, true, "irradiance", NULL, "light of lamps makes no speckle"},
        {Q, true, true, "radiance", NULL, "is not that of light.exr"},
        {Q - 1, true, true, "irradiance", NULL,
         "has 3 x 3 sub-pixels for each pixel, but grains of 5.28e-06 m need 4 x 4: render it with "
         "--lasers 4"},
        {Q, true, false, "irradiance", NULL, "light.exr: has no f-number"},
        {Q, true, true, "irradiance", "star", "mcvisi:aperture in its header is \"star\""},
        {Q, true, true, "irradiance", "coded", "must be a shape of sensors with its numbers"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_read_out out;
        mcv_error error = {""};
        write_laser(path, cases[i].q, cases[i].laser, cases[i].quantity);
        assert_int_equal(read_out(path, cases[i].stop, cases[i].aperture, &out, &error),
                         MCV_BAD_INPUT);
        if (!strstr(error.text, cases[i].says))
            fail_msg("\"%s\" must say \"%s\"", error.text, cases[i].says);
    }
    mcv_read_out out;
    mcv_error error = {""};
    assert_int_not_equal(read_out("no_such_file.exr", true, NULL, &out, &error), MCV_OK);
    assert_non_null(strstr(error.text, "no_such_file.exr"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_contrast_of_pixels),
        cmocka_unit_test(test_what_makes_it_fainter),
        cmocka_unit_test(test_exponential),
        cmocka_unit_test(test_apertures),
        cmocka_unit_test(test_camera),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
