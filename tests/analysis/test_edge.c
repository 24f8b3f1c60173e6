/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* Edges whose place and sharpness are known: exact pixels of slanted half-planes, blurred by known
 * spreads. Seeds are fixed. */
#include "test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/blur.h"
#include "analysis/edge.h"
#include "analysis/noise.h"
#include "coverage.h"
#include "slanted_edge.h"
#include "truths.h"

static mcv_readings draw(const picture *p, uint32_t width, uint32_t height, double deviation) {
    mcv_readings r = {0};
    mcv_error error = {""};
    assert_int_equal(mcv_image_new(&r.values, width, height, 1, &error), MCV_OK);
    assert_int_equal(mcv_image_new(&r.deviation, width, height, 1, &error), MCV_OK);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            r.values.pixels[y * width + x] = (float)pixel_value(p, x + 0.5, y + 0.5);
            r.deviation.pixels[y * width + x] = (float)deviation;
        }
    return r;
}

static void transpose(mcv_image *image) {
    mcv_image turned;
    mcv_error error = {""};
    assert_int_equal(mcv_image_new(&turned, image->height, image->width, 1, &error), MCV_OK);
    for (uint32_t y = 0; y < image->height; ++y)
        for (uint32_t x = 0; x < image->width; ++x)
            turned.pixels[x * image->height + y] = image->pixels[y * image->width + x];
    mcv_image_free(image);
    *image = turned;
}

static void release(mcv_readings *r) {
    mcv_image_free(&r->values);
    mcv_image_free(&r->deviation);
}

static mcv_edge find(const mcv_readings *r, const char *box) {
    mcv_edge edge;
    mcv_error error = {""};
    if (mcv_edge_parse(box, 1, &r->values, &edge, &error) != MCV_OK) fail_msg("%s", error.text);
    if (mcv_edge_find(r, &edge, &error) != MCV_OK) fail_msg("%s", error.text);
    return edge;
}

/*
 * Without noise only float32 (6e-8 of 200 DN over a step of 180, in each of some ten pixels of a
 * row) and the partial pixels at the ends of a blur are left: a hundredth of a pixel is asked for,
 * a thousandth is held.
 */
static void test_position(void **state) {
    static const double tilts[] = {0, 0.5, 2, 5, 12, 25, 40}, discs[] = {0, 1.3, 4};
    double worst = 0;
    (void)state;
    for (int t = 0; t < 7; ++t)
        for (int sign = -1; sign <= 1; sign += 2)
            for (int d = 0; d < 3; ++d)
                for (int k = 0; k < 4; ++k) {
                    const picture p = {.tilt = sign * tilts[t] * M_PI / 180,
                                       .place = 50.07 + 0.27 * k,
                                       .row = 20,
                                       .disc = discs[d],
                                       .dark = k % 2 ? 200 : 20,
                                       .bright = k % 2 ? 20 : 200};
                    mcv_readings r = draw(&p, 100, 40, 1);
                    if (k > 1) {
                        transpose(&r.values);
                        transpose(&r.deviation);
                    }
                    const mcv_edge e = find(&r, k > 1 ? "0,0,40,100" : "0,0,100,40");
                    assert_int_equal(e.across_rows, k < 2);
                    const double off = fabs(e.position.value - p.place),
                                 turned = fabs(e.tilt.value - p.tilt);
                    worst = fmax(worst, off);
                    if (off > 1e-3 || turned > 1e-4)
                        fail_msg("tilt %g°, disc %g, at %g: %g pixels and %g rad off",
                                 sign * tilts[t], discs[d], p.place, off, turned);
                    assert_true(fabs(e.dark.value - 20) < 0.1 && fabs(e.bright.value - 200) < 0.1);
                    assert_true(e.normal[k < 2 ? 0 : 1] * (k % 2 ? -1 : 1) > 0);
                    release(&r);
                }
    print_message("the worst of all is %.2g pixels off\n", worst);
}

static double sinc(double x) { return x == 0 ? 1 : sin(M_PI * x) / (M_PI * x); }

static double disc_mtf(double radius, double frequency) {
    const double x = 2 * M_PI * radius * frequency;
    return x == 0 ? 1 : 2 * j1(x) / x;
}

static double mtf_of(const picture *p, double frequency) {
    return fabs(sinc(frequency * cos(p->tilt)) * sinc(frequency * sin(p->tilt)) *
                disc_mtf(p->disc, frequency));
}

/* Where a share of the step has been made, by halving; along the row that the line passes. */
static double place_of(const picture *p, double share) {
    double low = -10, high = 10;
    for (int i = 0; i < 50; ++i) {
        const double middle = 0.5 * (low + high);
        if (pixel_value(p, p->place + middle, p->row) < p->dark + share * (p->bright - p->dark))
            low = middle;
        else
            high = middle;
    }
    return low * cos(p->tilt);
}

static double width_of(const picture *p) { return place_of(p, 0.9) - place_of(p, 0.1); }

/* Within 0.01 up to Nyquist, box pixel and disc, at tilts with and without regular phases. */
static void test_mtf(void **state) {
    static const double tilts[] = {2, 5, 7.1250163489, 14.0362434679, 20},
                        discs[] = {0, 0.8, 2, 4.5};
    (void)state;
    for (int t = 0; t < 5; ++t)
        for (int d = 0; d < 4; ++d) {
            const picture p = {.tilt = tilts[t] * M_PI / 180,
                               .place = 60.3,
                               .row = 40,
                               .disc = discs[d],
                               .dark = 10,
                               .bright = 250};
            mcv_readings r = draw(&p, 120, 80, 0.5);
            const mcv_edge e = find(&r, "0,0,120,80");
            mcv_edge_mtf m;
            mcv_error error = {""};
            double worst = 0;
            if (mcv_edge_spread(&r, &e, &m, &error) != MCV_OK) fail_msg("%s", error.text);
            for (int k = 0; k <= MCV_MTF_COUNT / 2; ++k) {
                const double f = m.frequency[k], truth = mtf_of(&p, f);
                const double off = fabs(m.modulation[k].value - truth);
                worst = fmax(worst, off);
                if (off > 0.01)
                    fail_msg("tilt %g°, disc %g: MTF(%g) is %g instead of %g", tilts[t], discs[d],
                             f, m.modulation[k].value, truth);
            }
            note_truth("T25 MTF of an edge behind a box pixel and a disc", "program", worst, 0.01);
            print_message("tilt %g°, disc %g: worst %.2g, MTF50 %.4f\n", tilts[t], discs[d], worst,
                          m.mtf50.value);
            const double f = m.mtf50.value,
                         half = sinc(f * cos(p.tilt)) * sinc(f * sin(p.tilt)) * disc_mtf(p.disc, f);
            if (fabs(half - 0.5) > 0.01)
                fail_msg("disc %g: the modulation at MTF50 = %g is %g", discs[d], f, half);
            assert_true(m.nyquist.value == m.modulation[32].value && m.frequency[32] == 0.5);
            mcv_edge_mtf_free(&m);
            release(&r);
        }
}

/* The lens of the camera: a box pixel behind a diffraction-limited one of f/5.6 and f/11 at 3.45
 * µm. */
static void test_diffraction(void **state) {
    static const double numbers[] = {5.6, 11}, pitch[2] = {3.45e-6, 3.45e-6};
    (void)state;
    for (int i = 0; i < 2; ++i) {
        const mcv_lens_mtf lens = {.f_number = numbers[i], .wavelength = 550e-9},
                           lenses[3] = {lens, lens, lens};
        const picture p = {
            .tilt = 5 * M_PI / 180, .place = 100.3, .row = 60, .dark = 10, .bright = 250};
        mcv_readings r = draw(&p, 200, 120, 0.5);
        mcv_error error = {""};
        assert_int_equal(mcv_blur(&r.values, NULL, lenses, pitch, NULL, &error), MCV_OK);
        const mcv_edge e = find(&r, "5,5,190,110");
        mcv_edge_mtf m;
        double worst = 0;
        if (mcv_edge_spread(&r, &e, &m, &error) != MCV_OK) fail_msg("%s", error.text);
        if (fabs(e.position.value - 100.3) > 0.01)
            fail_msg("f/%g: the edge is at %g", numbers[i], e.position.value);
        for (int k = 0; k <= MCV_MTF_COUNT / 2; ++k) {
            const double f = m.frequency[k], box = sinc(f * cos(p.tilt)) * sinc(f * sin(p.tilt));
            const double truth = box * mcv_lens_modulation(&lens, f / pitch[0]);
            worst = fmax(worst, fabs(m.modulation[k].value - truth));
            if (fabs(m.modulation[k].value - truth) > 0.01)
                fail_msg("f/%g: MTF(%g) is %g instead of %g", numbers[i], f, m.modulation[k].value,
                         truth);
        }
        print_message("f/%g: worst %.2g\n", numbers[i], worst);
        mcv_edge_mtf_free(&m);
        release(&r);
    }
}

/* --- stated uncertainties
 * --------------------------------------------------------------------------------------- */

static bool is_off(int covered, bool may_be_more) {
    const double share = (double)covered / CASES;
    return share < 0.95 - margin || (share > 0.95 + margin && !may_be_more);
}

enum { FIGURES = 9 };

/*
 * Two parallel edges of a bar with shot-like noise (more in the bright): value ± 1.96 uncertainty
 * holds the truth in 95 % of the pictures.
 */
static void check_coverage(double disc) {
    static const char *const names[FIGURES] = {"position", "tilt",     "dark",
                                               "bright",   "distance", "MTF(0.25)",
                                               "Nyquist",  "MTF50",    "10-90 width"};
    const picture p = {
        .tilt = 5 * M_PI / 180, .place = 30.4, .row = 25, .disc = disc, .dark = 40, .bright = 200};
    const double gap = 60 * cos(p.tilt); /* the second edge, 60 columns to the right */
    double truths[FIGURES] = {p.place,          p.tilt,          p.dark, p.bright, gap,
                              mtf_of(&p, 0.25), mtf_of(&p, 0.5), 0,      0};
    while (mtf_of(&p, truths[7]) > 0.5) truths[7] += 1e-5;
    truths[8] = width_of(&p);
    int covered[FIGURES] = {0};
    picture second = p;
    mcv_error error = {""};
    second.place += 60;
    mcv_readings clean = draw(&p, 120, 50, 0), other = draw(&second, 120, 50, 0),
                 noisy = draw(&p, 120, 50, 0);
    for (size_t i = 0; i < 120 * 50; ++i) {
        clean.values.pixels[i] += (float)p.dark - other.values.pixels[i];
        noisy.deviation.pixels[i] = sqrtf(4 + 0.1F * clean.values.pixels[i]);
    }
    for (int n = 0; n < CASES; ++n) {
        for (uint32_t i = 0; i < 120 * 50; ++i) {
            mcv_noise noise = mcv_noise_begin((uint32_t)n, 0, i);
            noisy.values.pixels[i] = (float)(clean.values.pixels[i] +
                                             noisy.deviation.pixels[i] * mcv_noise_normal(&noise));
        }
        const mcv_edge a = find(&noisy, "2,0,57,50"), b = find(&noisy, "62,0,57,50");
        mcv_edge_mtf m;
        if (mcv_edge_spread(&noisy, &a, &m, &error) != MCV_OK) fail_msg("%s", error.text);
        const mcv_quantity found[FIGURES] = {
            a.position,       a.tilt,    a.dark,  a.bright,     mcv_edge_distance(&a, &b),
            m.modulation[16], m.nyquist, m.mtf50, a.width_10_90};
        for (int k = 0; k < FIGURES; ++k) {
            /* The second edge's normal points the other way; its distance counts along the first's.
             */
            covered[k] += fabs(found[k].value - truths[k]) <= 1.959964 * found[k].uncertainty;
        }
        mcv_edge_mtf_free(&m);
    }
    for (int k = 0; k < FIGURES; ++k) {
        print_message("blur %g: %s: %.1f %%\n", disc, names[k], 100.0 * covered[k] / CASES);
    }
    for (int k = 0; k < FIGURES; ++k)
        if (is_off(covered[k], false))
            fail_msg("%s: %d of %d intervals hold the truth", names[k], covered[k], CASES);
    release(&clean);
    release(&other);
    release(&noisy);
}

static void test_coverage(void **state) {
    (void)state;
    check_coverage(1.2);
    check_coverage(0);
}

/*
 * The 10-90 width from a noise of 0.02 % of the step on, where what is left is how the spread
 * function bends between the pixels. That is no noise: intervals that allow for it hold the truth
 * more often, and may, where the noise is a third of a per cent or less.
 */
static void check_width(double tilt, double disc, double share, uint32_t width, uint32_t height) {
    const picture p = {.tilt = tilt * M_PI / 180,
                       .place = 0.5 * width + 0.4,
                       .row = 0.5 * height,
                       .disc = disc,
                       .dark = 40,
                       .bright = 200};
    const double truth = width_of(&p);
    mcv_readings clean = draw(&p, width, height, share * 160),
                 noisy = draw(&p, width, height, share * 160);
    double sum = 0;
    int covered = 0;
    char box[64];
    snprintf(box, sizeof box, "0,0,%u,%u", width, height);
    for (uint32_t n = 0; n < CASES; ++n) {
        for (uint32_t i = 0; i < width * height; ++i) {
            mcv_noise noise = mcv_noise_begin(n, 0, i);
            noisy.values.pixels[i] = (float)(clean.values.pixels[i] +
                                             noisy.deviation.pixels[i] * mcv_noise_normal(&noise));
        }
        const mcv_quantity found = find(&noisy, box).width_10_90;
        sum += found.value - truth;
        covered += fabs(found.value - truth) <= 1.959964 * found.uncertainty;
    }
    print_message("tilt %g°, blur %g, noise %g: 10-90 width %.4f, %+.5f in the mean, %.1f %% of %d "
                  "intervals hold it\n",
                  tilt, disc, share, truth, sum / CASES, 100.0 * covered / CASES, CASES);
    if (is_off(covered, share <= 0.003))
        fail_msg("%d of %d intervals hold the truth", covered, CASES);
    release(&clean);
    release(&noisy);
}

static void test_width_coverage(void **state) {
    static const double shares[] = {2e-4, 1e-3, 3e-3, 0.01, 0.03};
    (void)state;
    for (int k = 0; k < 5; ++k) {
        check_width(5, 0.4, shares[k], 56, 50);
        check_width(7, 0, shares[k], 56, 50);
        check_width(12.3, 1.2, shares[k], 56, 50);
        check_width(5, 0, shares[k], 30, 16);
    }
}

/* --- bad input
 * --------------------------------------------------------------------------------------------------
 */

static void expect_refused(const mcv_readings *r, const char *box, const char *part) {
    mcv_edge edge;
    mcv_error error = {""};
    mcv_result result = mcv_edge_parse(box, 1, &r->values, &edge, &error);
    if (result == MCV_OK) result = mcv_edge_find(r, &edge, &error);
    assert_int_not_equal(result, MCV_OK);
    if (!strstr(error.text, part)) fail_msg("%s: \"%s\" is missing in: %s", box, part, error.text);
}

static void test_no_edge(void **state) {
    const picture p = {.tilt = 0.1, .place = 50, .row = 20, .dark = 10, .bright = 200};
    mcv_readings r = draw(&p, 100, 40, 1);
    mcv_edge_mtf m;
    mcv_error error = {""};
    (void)state;
    expect_refused(&r, "0,0,30,40", "no edge");
    expect_refused(&r, "0,0,101,40", "100 x 40");
    expect_refused(&r, "0,0,5,40", "at least 8");
    expect_refused(&r, "0,0,50", "X,Y,W,H");
    expect_refused(&r, "0,0,50.5,30", "whole pixels");
    expect_refused(&r, "a=here", "X,Y,W,H");
    expect_refused(&r, "44,0,9,40", "too little of one side");
    release(&r);
    const picture straight = {.place = 50.3, .row = 20, .dark = 10, .bright = 200};
    r = draw(&straight, 100, 40, 1);
    const mcv_edge e = find(&r, "0,0,100,40");
    assert_int_equal(mcv_edge_spread(&r, &e, &m, &error), MCV_FAILED);
    assert_non_null(strstr(error.text, "tilt it"));
    release(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_position),       cmocka_unit_test(test_mtf),
        cmocka_unit_test(test_diffraction),    cmocka_unit_test(test_coverage),
        cmocka_unit_test(test_width_coverage), cmocka_unit_test(test_no_edge),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
