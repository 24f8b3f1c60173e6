/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* Circles, arcs, lines and widths whose places are known: exact pixels of discs and half-planes behind known spreads. Seeds are fixed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/circle.h"
#include "analysis/line.h"
#include "analysis/noise.h"
#include "area_samples.h"

/* A disc; `lobes` of them swell it by `swell` each way. */
typedef struct disc {
    double column, row, radius;
} disc;

typedef struct look {
    double spread;          /* standard deviation of the blur [pixel] */
    double outside, inside; /* levels */
    double noise[2];        /* variance, and by grey value */
} look;

static mcv_readings new_picture(uint32_t width, uint32_t height, double level) {
    mcv_readings r = {0};
    mcv_error error = {""};
    assert_int_equal(mcv_image_new(&r.values, width, height, 1, &error), MCV_OK);
    assert_int_equal(mcv_image_new(&r.deviation, width, height, 1, &error), MCV_OK);
    for (size_t i = 0; i < (size_t)width * height; ++i) r.values.pixels[i] = (float)level;
    return r;
}

static void release(mcv_readings *r) {
    mcv_image_free(&r->values);
    mcv_image_free(&r->deviation);
}

static double disc_value(const disc *d, double spread, uint32_t x, uint32_t y) {
    double share = 0;
    const double far = fabs(hypot(x + 0.5 - d->column, y + 0.5 - d->row) - d->radius);
    if (far > 0.71 + 4.1 * spread) return hypot(x + 0.5 - d->column, y + 0.5 - d->row) < d->radius;
    if (spread == 0) return disc_coverage_of_pixel(x - d->column, y - d->row, d->radius);
    for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 5; ++i)
            share += spread_weights[i] * spread_weights[j] *
                     disc_coverage_of_pixel(x - d->column + spread * spread_nodes[i], y - d->row + spread * spread_nodes[j], d->radius);
    return share;
}

static void draw_disc(mcv_readings *r, const disc *d, const look *l) {
    for (uint32_t y = 0; y < r->values.height; ++y)
        for (uint32_t x = 0; x < r->values.width; ++x)
            r->values.pixels[y * r->values.width + x] += (float)((l->inside - l->outside) * disc_value(d, l->spread, x, y));
}

/* Noise of the given variance, known or not. */
static void add_noise(mcv_readings *r, const look *l, uint32_t seed, bool known) {
    for (size_t i = 0; i < (size_t)r->values.width * r->values.height; ++i) {
        mcv_noise noise = mcv_noise_begin(seed, 0, i);
        const double deviation = sqrt(l->noise[0] + l->noise[1] * r->values.pixels[i]);
        r->deviation.pixels[i] = known ? (float)deviation : 0;
        r->values.pixels[i] += (float)(deviation * mcv_noise_normal(&noise));
    }
}

static double draw_uniform(mcv_noise *n, double low, double high) { return low + (high - low) * mcv_noise_uniform(n); }

static void locate(mcv_readings *r, const char *box, bool whole, double least, mcv_circle *c) {
    mcv_error error = {""};
    if (mcv_circle_parse(box, 1, &r->values, whole, c, &error) != MCV_OK || mcv_circle_locate(r, least, c, &error) != MCV_OK)
        fail_msg("%s", error.text);
}

/* --- without noise -------------------------------------------------------------------------------------------------- */

static void test_bias(void **state) {
    static const double radii[] = {8, 12.3, 20, 45.7, 120}, spreads[] = {0, 0.4, 0.8, 1.5};
    (void)state;
    for (int i = 0; i < 5; ++i)
        for (int k = 0; k < 4; ++k) {
            double sum[3] = {0}, worst[3] = {0};
            enum { PHASES = 6 };
            if (2 * sqrt(spreads[k] * spreads[k] + 1.0 / 12) + 1 > 0.29 * radii[i]) continue;
            for (int p = 0; p < PHASES; ++p) {
                const uint32_t size = (uint32_t)(2 * radii[i]) + 28;
                const look l = {.spread = spreads[k], .outside = p % 2 ? 200 : 20, .inside = p % 2 ? 20 : 200, .noise = {1, 0}};
                const disc d = {0.5 * size + 0.37 * p - 0.9, 0.5 * size - 0.23 * p + 0.6, radii[i] + 0.17 * p};
                mcv_readings r = new_picture(size, size, l.outside);
                mcv_circle c;
                char box[64];
                snprintf(box, sizeof box, "0,0,%u,%u", size, size);
                draw_disc(&r, &d, &l);
                for (size_t n = 0; n < (size_t)size * size; ++n) r.deviation.pixels[n] = 1;
                locate(&r, box, true, NAN, &c);
                const double off[3] = {c.column.value - d.column, c.row.value - d.row, c.radius.value - d.radius};
                for (int j = 0; j < 3; ++j) {
                    sum[j] += off[j] / PHASES;
                    worst[j] = fmax(worst[j], fabs(off[j]));
                }
                if (c.bright != (p % 2 == 0) || c.seen < 0.9) fail_msg("bright %d, seen %g", c.bright, c.seen);
                release(&r);
            }
            print_message("radius %g, spread %g: worst %.5f %.5f %.5f, radius in the mean %+.5f\n", radii[i], spreads[k], worst[0],
                          worst[1], worst[2], sum[2]);
            /* Thousandths of a pixel are asked for. */
            for (int j = 0; j < 3; ++j)
                if (worst[j] > 2e-3) fail_msg("radius %g, spread %g: off by %g", radii[i], spreads[k], worst[j]);
        }
}

/* --- stated uncertainties ------------------------------------------------------------------------------------------- */

enum { CASES = 1000, MAX_FIGURES = 16 };

typedef struct tally {
    const char *names[MAX_FIGURES];
    int covered[MAX_FIGURES];
    double pull[MAX_FIGURES], pull2[MAX_FIGURES];
} tally;

static void count(tally *t, int k, const char *name, mcv_quantity q, double truth) {
    const double z = (q.value - truth) / q.uncertainty;
    t->names[k] = name;
    t->covered[k] += fabs(z) <= 1.959964;
    t->pull[k] += z / CASES;
    t->pull2[k] += z * z / CASES;
}

/* Value ± 1.96 uncertainty holds the truth in 95 ± 2 % of the cases; the standard deviation of such a share is 0.7 %. */
static void judge(const char *what, const tally *t) {
    bool bad = false;
    for (int k = 0; k < MAX_FIGURES && t->names[k]; ++k) {
        const double share = (double)t->covered[k] / CASES;
        print_message("%s: %s: %.1f %%, pulls %+.2f ± %.2f\n", what, t->names[k], 100 * share, t->pull[k],
                      sqrt(t->pull2[k] - t->pull[k] * t->pull[k]));
        bad = bad || share < 0.93 || share > 0.97;
    }
    if (bad) fail_msg("%s: some intervals hold the truth in less than 93 or more than 97 %% of the cases", what);
}

static look random_look(mcv_noise *n) {
    const double low = draw_uniform(n, 20, 60), high = low + draw_uniform(n, 60, 180), noise = draw_uniform(n, 0.3, 5);
    const bool bright = mcv_noise_uniform(n) < 0.5;
    return (look){.spread = draw_uniform(n, 0, 1),
                  .outside = bright ? low : high,
                  .inside = bright ? high : low,
                  .noise = {noise * noise, 0.05 * mcv_noise_uniform(n)}};
}

static void check_circles(const char *what, bool known) {
    tally t = {0};
    for (uint32_t n = 0; n < CASES; ++n) {
        mcv_noise draw = mcv_noise_begin(n, 1, 0);
        const look l = random_look(&draw);
        const double radius = draw_uniform(&draw, 14, 26);
        const disc d = {37 + draw_uniform(&draw, -1, 1), 36 + draw_uniform(&draw, -1, 1), radius};
        mcv_readings r = new_picture(74, 72, l.outside);
        mcv_circle c;
        draw_disc(&r, &d, &l);
        add_noise(&r, &l, n, known);
        locate(&r, "1,0,72,72", true, known ? NAN : 0, &c);
        count(&t, 0, "column", c.column, d.column);
        count(&t, 1, "row", c.row, d.row);
        count(&t, 2, "radius", c.radius, d.radius);
        count(&t, 3, "diameter", c.diameter, 2 * d.radius);
        count(&t, 4, "roundness", c.roundness, 0);
        release(&r);
    }
    judge(what, &t);
}

static void test_circles(void **state) {
    (void)state;
    check_circles("circle", true);
    check_circles("circle, noise estimated", false);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bias),
        cmocka_unit_test(test_circles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
