/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: label truth */
/* Circles, arcs, lines and widths whose places are known: exact pixels of discs and half-planes
 * behind known spreads. Seeds are fixed. */
#include "test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/circle.h"
#include "analysis/line.h"
#include "analysis/noise.h"
#include "area_samples.h"
#include "coverage.h"

/*
 * Weighted points as a spread whose variance is known: the five of Gauss and Hermite in both
 * directions, which have a Gaussian's moments up to the ninth. A spread of points is as good as
 * another: what is measured must be the disc's, not the spread's.
 */
static const double spread_nodes[5] = {-2.8569700138728056, -1.3556261799742659, 0,
                                       1.3556261799742659, 2.8569700138728056};
static const double spread_weights[5] = {0.011257411327720689, 0.22207592200561266, 8.0 / 15,
                                         0.22207592200561266, 0.011257411327720689};

/* In pixels from the top-left corner of the image. */
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
    mcv_image_free(&r->render);
}

static double disc_value(const disc *d, double spread, uint32_t x, uint32_t y) {
    double share = 0;
    const double dx = x + 0.5 - d->column, dy = y + 0.5 - d->row,
                 from = sqrt(dx * dx + dy * dy) - d->radius;
    if (fabs(from) > 0.71 + 4.1 * spread) return from < 0;
    if (spread == 0) return disc_coverage_of_pixel(x - d->column, y - d->row, d->radius);
    for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 5; ++i)
            share += spread_weights[i] * spread_weights[j] *
                     disc_coverage_of_pixel(x - d->column + spread * spread_nodes[i],
                                            y - d->row + spread * spread_nodes[j], d->radius);
    return share;
}

static void draw_disc(mcv_readings *r, const disc *d, const look *l) {
    for (uint32_t y = 0; y < r->values.height; ++y)
        for (uint32_t x = 0; x < r->values.width; ++x)
            r->values.pixels[y * r->values.width + x] +=
                (float)((l->inside - l->outside) * disc_value(d, l->spread, x, y));
}

/* Noise as `measure` meets it: known, to be estimated from the image, or that of a render that a
 * lens has blurred, which neighbours share. */
typedef enum way { KNOWN, ESTIMATED, BLURRED } way;

static double least_of(way how) { return how == ESTIMATED ? 0 : NAN; }

/* A blur of 1, 2, 1 in both directions correlates neighbours by 4/6, those two apart by 1/6. */
static const double blur_sum = 1 + 2 * (4 + 1) / 6.0, blur_squares = 1 + 2 * (16 + 1) / 36.0;

static void blur(double *noise, uint32_t count, size_t step) {
    double before = noise[0];
    for (uint32_t i = 0; i < count; ++i) {
        const double here = noise[i * step], next = noise[(i + 1 < count ? i + 1 : i) * step];
        noise[i * step] = (before + 2 * here + next) / 6; /* keeps the variance at 1 */
        before = here;
    }
}

static void blur_noise(const look *l, mcv_readings *r, double *noise) {
    const uint32_t width = r->values.width, height = r->values.height;
    mcv_error error = {""};
    for (uint32_t y = 0; y < height; ++y) blur(noise + (size_t)y * width, width, 1);
    for (uint32_t x = 0; x < width; ++x) blur(noise + x, height, width);
    assert_int_equal(mcv_image_new(&r->render, width, height, 1, &error), MCV_OK);
    for (size_t i = 0; i < (size_t)width * height; ++i)
        r->render.pixels[i] = (float)sqrt(l->noise[0]);
    r->correlation =
        (mcv_correlation){.sum = blur_sum * blur_sum, .squares = blur_squares * blur_squares};
}

static void add_noise(mcv_readings *r, const look *l, uint32_t seed, way how) {
    const size_t count = (size_t)r->values.width * r->values.height;
    double *normal = malloc(count * sizeof *normal);
    assert_non_null(normal);
    for (size_t i = 0; i < count; ++i) {
        mcv_noise noise = mcv_noise_begin(seed, 0, i);
        normal[i] = mcv_noise_normal(&noise) * (how == BLURRED ? 6 : 1);
    }
    if (how == BLURRED) blur_noise(l, r, normal);
    for (size_t i = 0; i < count; ++i) {
        const double by_value = how == BLURRED ? 0 : l->noise[1] * r->values.pixels[i],
                     deviation = sqrt(l->noise[0] + by_value);
        r->deviation.pixels[i] = how == ESTIMATED ? 0 : (float)deviation;
        r->values.pixels[i] += (float)(deviation * normal[i]);
    }
    free(normal);
}

static double draw_uniform(mcv_noise *n, double low, double high) {
    return low + (high - low) * mcv_noise_uniform(n);
}

static void locate(mcv_readings *r, const char *box, bool whole, double least, mcv_circle *c) {
    mcv_error error = {""};
    if (mcv_circle_parse(box, 1, &r->values, whole, c, &error) != MCV_OK ||
        mcv_circle_locate(r, least, c, &error) != MCV_OK)
        fail_msg("%s", error.text);
}

/* --- without noise
 * --------------------------------------------------------------------------------------------------
 */

static void test_bias(void **state) {
    static const double radii[] = {6, 8, 12.3, 20, 45.7, 120}, spreads[] = {0, 0.4, 0.8, 1.5};
    (void)state;
    for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 4; ++k) {
            double sum[3] = {0}, worst[3] = {0};
            enum { PHASES = 6 };
            if (2 * sqrt(spreads[k] * spreads[k] + 1.0 / 12) + 1 > 0.29 * radii[i]) continue;
            for (int p = 0; p < PHASES; ++p) {
                const uint32_t size = (uint32_t)(2 * radii[i]) + 28;
                const look l = {.spread = spreads[k],
                                .outside = p % 2 ? 200 : 20,
                                .inside = p % 2 ? 20 : 200,
                                .noise = {1, 0}};
                const disc d = {0.5 * size + 0.37 * p - 0.9, 0.5 * size - 0.23 * p + 0.6,
                                radii[i] + 0.17 * p};
                mcv_readings r = new_picture(size, size, l.outside);
                mcv_circle c;
                char box[64];
                snprintf(box, sizeof box, "0,0,%u,%u", size, size);
                draw_disc(&r, &d, &l);
                for (size_t n = 0; n < (size_t)size * size; ++n) r.deviation.pixels[n] = 1;
                locate(&r, box, true, NAN, &c);
                const double off[3] = {c.column.value - d.column, c.row.value - d.row,
                                       c.radius.value - d.radius};
                for (int j = 0; j < 3; ++j) {
                    sum[j] += off[j] / PHASES;
                    worst[j] = fmax(worst[j], fabs(off[j]));
                }
                if (c.bright != (p % 2 == 0) || c.seen < 0.9)
                    fail_msg("bright %d, seen %g", c.bright, c.seen);
                release(&r);
            }
            print_message("radius %g, spread %g: worst %.5f %.5f %.5f, radius in the mean %+.5f\n",
                          radii[i], spreads[k], worst[0], worst[1], worst[2], sum[2]);
            /* Thousandths of a pixel are asked for. */
            for (int j = 0; j < 3; ++j)
                if (worst[j] > 2e-3)
                    fail_msg("radius %g, spread %g: off by %g", radii[i], spreads[k], worst[j]);
        }
}

/* --- stated uncertainties
 * ------------------------------------------------------------------------------------------- */

/* test_circle_slow.c lets the noise be estimated as well. */
#ifndef ALSO_ESTIMATED
#define ALSO_ESTIMATED false
#endif

enum { MAX_FIGURES = 16 };

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

/*
 * Value ± 1.96 uncertainty holds the truth in 95 % of the cases. Of blurred noise it may hold it in
 * 99 %: what neighbours share counts as for sums that reach beyond the blur, the most that it can.
 */
static void judge(const char *what, way how, const tally *t) {
    bool bad = false;
    for (int k = 0; k < MAX_FIGURES && t->names[k]; ++k) {
        const double share = (double)t->covered[k] / CASES;
        print_message("%s: %s: %.1f %%, pulls %+.2f ± %.2f\n", what, t->names[k], 100 * share,
                      t->pull[k], sqrt(t->pull2[k] - t->pull[k] * t->pull[k]));
        bad = bad || share < 0.95 - margin || share > (how == BLURRED ? 0.99 : 0.95 + margin);
    }
    if (bad)
        fail_msg("%s: some intervals hold the truth in less or more than 95 ± %.1f %% of the cases",
                 what, 100 * margin);
}

static look random_look(mcv_noise *n) {
    const double low = draw_uniform(n, 20, 60), high = low + draw_uniform(n, 60, 180),
                 noise = draw_uniform(n, 0.3, 4);
    const bool bright = mcv_noise_uniform(n) < 0.5;
    return (look){.spread = draw_uniform(n, 0, 1),
                  .outside = bright ? low : high,
                  .inside = bright ? high : low,
                  .noise = {noise * noise, 0.05 * mcv_noise_uniform(n)}};
}

static void check_circles(const char *what, way how) {
    tally t = {0};
    for (uint32_t n = 0; n < CASES; ++n) {
        mcv_noise draw = mcv_noise_begin(n, 1, 0);
        const look l = random_look(&draw);
        const double radius = draw_uniform(&draw, 14, 26);
        const disc d = {37 + draw_uniform(&draw, -1, 1), 36 + draw_uniform(&draw, -1, 1), radius};
        mcv_readings r = new_picture(74, 72, l.outside);
        mcv_circle c;
        draw_disc(&r, &d, &l);
        add_noise(&r, &l, n, how);
        locate(&r, "1,0,72,72", true, least_of(how), &c);
        count(&t, 0, "column", c.column, d.column);
        count(&t, 1, "row", c.row, d.row);
        count(&t, 2, "radius", c.radius, d.radius);
        count(&t, 3, "diameter", c.diameter, 2 * d.radius);
        count(&t, 4, "roundness", c.roundness, 0);
        release(&r);
    }
    judge(what, how, &t);
}

static void test_circles(void **state) {
    (void)state;
    check_circles("circle", KNOWN);
    check_circles("circle, noise blurred", BLURRED);
    if (ALSO_ESTIMATED) check_circles("circle, noise estimated", ESTIMATED);
}

/* Two bores and an arc of the second; the distance of their centres. */
static void check_bores(const char *what, way how) {
    tally t = {0};
    for (uint32_t n = 0; n < CASES; ++n) {
        mcv_noise draw = mcv_noise_begin(n, 2, 0);
        const look l = random_look(&draw);
        const disc a = {22 + draw_uniform(&draw, -1, 1), 26 + draw_uniform(&draw, -1, 1),
                        draw_uniform(&draw, 11, 13)};
        const disc b = {67 + draw_uniform(&draw, -1, 1), 25 + draw_uniform(&draw, -1, 1),
                        draw_uniform(&draw, 15, 17)};
        mcv_readings r = new_picture(94, 50, l.outside);
        mcv_circle first, second, arc;
        draw_disc(&r, &a, &l);
        draw_disc(&r, &b, &l);
        add_noise(&r, &l, n, how);
        locate(&r, "1,4,42,43", true, least_of(how), &first);
        locate(&r, "44,0,50,50", true, least_of(how), &second);
        locate(&r, "46,0,42,32", false, least_of(how), &arc); /* its upper half and some more */
        count(&t, 0, "centre distance", mcv_circle_distance(&first, &second),
              hypot(b.column - a.column, b.row - a.row));
        count(&t, 1, "arc's column", arc.column, b.column);
        count(&t, 2, "arc's row", arc.row, b.row);
        count(&t, 3, "arc's radius", arc.radius, b.radius);
        count(&t, 4, "arc's diameter", arc.diameter, 2 * b.radius);
        count(&t, 5, "arc's roundness", arc.roundness, 0);
        release(&r);
    }
    judge(what, how, &t);
}

static void test_bores(void **state) {
    (void)state;
    check_bores("bores", KNOWN);
    check_bores("bores, noise blurred", BLURRED);
    if (ALSO_ESTIMATED) check_bores("bores, noise estimated", ESTIMATED);
}

/* A half-plane behind the spread: bright beyond the line through a place, whose normal is turned
 * from the columns by `tilt`. */
static double half_value(double column, double row, double tilt, double spread, uint32_t x,
                         uint32_t y) {
    const double cosine = cos(tilt), sine = sin(tilt),
                 d = (x + 0.5 - column) * cosine - (y + 0.5 - row) * sine;
    double share = 0;
    if (fabs(d) > 0.71 + 4.1 * spread) return d > 0;
    for (int j = 0; j < 5; ++j)
        for (int i = 0; i < 5; ++i)
            share += spread_weights[i] * spread_weights[j] *
                     box_coverage(d + spread * (spread_nodes[i] * cosine - spread_nodes[j] * sine),
                                  cosine, sine);
    return share;
}

/* A bar with sides of their own tilts, and a disc to the right of it. */
static void check_bars(const char *what, way how) {
    tally t = {0};
    for (uint32_t n = 0; n < CASES; ++n) {
        mcv_noise draw = mcv_noise_begin(n, 3, 0);
        const look l = random_look(&draw);
        const double row = 32, tilt = draw_uniform(&draw, -0.08, 0.08),
                     tilts[2] = {tilt, tilt + draw_uniform(&draw, -0.01, 0.01)};
        const double places[2] = {20 + draw_uniform(&draw, -1, 1), 45 + draw_uniform(&draw, -1, 1)};
        const disc d = {77 + draw_uniform(&draw, -1, 1), 32 + draw_uniform(&draw, -1, 1),
                        draw_uniform(&draw, 12, 14)};
        mcv_readings r = new_picture(98, 64, l.outside);
        mcv_error error = {""};
        mcv_edge edge;
        mcv_line line;
        mcv_caliper caliper;
        mcv_circle circle;
        for (uint32_t y = 0; y < 64; ++y)
            for (uint32_t x = 0; x < 98; ++x)
                r.values.pixels[y * 98 + x] +=
                    (float)((l.inside - l.outside) *
                            (half_value(places[0], row, tilts[0], l.spread, x, y) -
                             half_value(places[1], row, tilts[1], l.spread, x, y)));
        draw_disc(&r, &d, &l);
        add_noise(&r, &l, n, how);
        const double least = least_of(how);
        if (mcv_edge_parse("6,2,27,60", 1, &r.values, &edge, &error) != MCV_OK ||
            mcv_edge_locate(&r, least, &edge, &error) != MCV_OK ||
            mcv_edge_is_straight(&edge, &error) != MCV_OK)
            fail_msg("%u: %s", n, error.text);
        if (mcv_line_parse("4,1,33,30+4,33,33,30", 1, &r.values, &line, &error) != MCV_OK ||
            mcv_line_locate(&r, least, &line, &error) != MCV_OK)
            fail_msg("%u: %s", n, error.text);
        if (mcv_caliper_parse("5,8,54,48", 1, &r.values, &caliper, &error) != MCV_OK ||
            mcv_caliper_locate(&r, least, &caliper, &error) != MCV_OK)
            fail_msg("%u: %s", n, error.text);
        locate(&r, "58,12,39,40", true, least, &circle);
        const double cosine = cos(tilts[0]), sine = sin(tilts[0]);
        count(&t, 0, "edge's position", edge.position, places[0]);
        count(&t, 1, "edge's tilt", edge.tilt, tilts[0]);
        count(&t, 2, "edge's sagitta", edge.sagitta, 0);
        count(&t, 3, "line's position", line.edge.position,
              places[0] + (line.edge.point[1] - row) * tan(tilts[0]));
        count(&t, 4, "line's tilt", line.edge.tilt, tilts[0]);
        count(&t, 5, "line's straightness", line.straightness, 0);
        /* Along the mean normal, in the row that the edges' points share. */
        const double turned = 0.5 * (tilts[0] + tilts[1]);
        count(&t, 6, "width", caliper.width,
              (places[1] - places[0] +
               (tan(tilts[1]) - tan(tilts[0])) * (caliper.edges[0].point[1] - row)) *
                  cos(turned));
        count(&t, 7, "angle", caliper.angle, tilts[1] - tilts[0]);
        count(&t, 8, "line to circle", mcv_edge_to_circle(&line.edge, &circle),
              ((d.column - places[0]) * cosine - (d.row - row) * sine) *
                  (l.inside > l.outside ? 1 : -1));
        count(&t, 9, "edge to edge", mcv_edge_distance(caliper.edges, caliper.edges + 1),
              caliper.width.value * 0 +
                  ((places[1] - places[0] +
                    (tan(tilts[1]) - tan(tilts[0])) * (caliper.edges[0].point[1] - row)) *
                   cos(turned)) *
                      (l.inside > l.outside ? 1 : -1));
        release(&r);
    }
    judge(what, how, &t);
}

static void test_bars(void **state) {
    (void)state;
    check_bars("bar", KNOWN);
    check_bars("bar, noise blurred", BLURRED);
    if (ALSO_ESTIMATED) check_bars("bar, noise estimated", ESTIMATED);
}

/*
 * Forms that are not as fitted: an ellipse of the semi-axes R + e and R - e, which is e cos 2φ from
 * its circle (and e²/R, here below 0.3 % of that), and a wavy edge, each row of pixels with a place
 * of its own.
 */
static void check_deviations(const char *what, way how) {
    tally t = {0};
    for (uint32_t n = 0; n < CASES; ++n) {
        mcv_noise draw = mcv_noise_begin(n, 4, 0);
        look l = random_look(&draw);
        const double radius = draw_uniform(&draw, 16, 20), e = draw_uniform(&draw, 0.02, 0.2),
                     scale = (radius - e) / (radius + e);
        const double column = 27 + draw_uniform(&draw, -1, 1),
                     row = 28 + draw_uniform(&draw, -1, 1), wave = draw_uniform(&draw, 0.02, 0.2);
        /* What blurs the noise blurs the edge: it has no waves within the reach of the blur. */
        const double pitch = how == BLURRED ? 0.4 : 0.9;
        double places[56], mean = 0, slope = 0, squares = 0;
        mcv_readings r = new_picture(96, 56, l.outside);
        mcv_circle circle;
        mcv_line line;
        mcv_error error = {""};
        for (int y = 0; y < 56; ++y) {
            places[y] = 75 + wave * sin(pitch * y + n);
            mean += places[y] / 56;
        }
        for (int y = 0; y < 56; ++y)
            slope += (y - 27.5) * (places[y] - mean) / (56 * (56.0 * 56 - 1) / 12);
        for (int y = 0; y < 56; ++y) squares += pow(places[y] - mean - slope * (y - 27.5), 2);
        for (uint32_t y = 0; y < 56; ++y)
            for (uint32_t x = 0; x < 96; ++x) {
                const double x0 = scale * (x - column), x1 = scale * (x + 1 - column), y0 = y - row,
                             y1 = y0 + 1, b = radius - e;
                const double area = disc_corner(x1, y1, b) - disc_corner(x0, y1, b) -
                                    disc_corner(x1, y0, b) + disc_corner(x0, y0, b);
                r.values.pixels[y * 96 + x] +=
                    (float)((l.inside - l.outside) *
                            (area / scale + fmin(1, fmax(0, x + 1 - places[y]))));
            }
        add_noise(&r, &l, n, how);
        locate(&r, "0,0,55,56", true, least_of(how), &circle);
        if (mcv_line_parse("60,0,30,56", 1, &r.values, &line, &error) != MCV_OK ||
            mcv_line_locate(&r, least_of(how), &line, &error) != MCV_OK)
            fail_msg("%u: %s", n, error.text);
        count(&t, 0, "roundness", circle.roundness, e * M_SQRT1_2);
        count(&t, 1, "straightness", line.straightness, sqrt(squares / 56));
        release(&r);
    }
    judge(what, how, &t);
}

static void test_deviations(void **state) {
    (void)state;
    check_deviations("forms", KNOWN);
    check_deviations("forms, noise blurred", BLURRED);
    if (ALSO_ESTIMATED) check_deviations("forms, noise estimated", ESTIMATED);
}

/* --- what is refused
 * ------------------------------------------------------------------------------------------------
 */

static void expect_refusal(mcv_result result, const mcv_error *error, const char *const parts[]) {
    if (result != MCV_FAILED) fail_msg("not refused, for want of: %s", parts[0]);
    for (int i = 0; parts[i]; ++i)
        if (!strstr(error->text, parts[i]))
            fail_msg("\"%s\" is missing in: %s", parts[i], error->text);
}

/*
 * A box across a bore. The chord that 40 rows cut off a radius of 160 has the sagitta 160 - √(160²
 * - 20²) = 1.255; a parabola through all rows of the arc is 1 % off at most ((40/320)² = 1.6 % is
 * how much the fourth power adds at the ends).
 */
static void test_curved(void **state) {
    const look l = {.spread = 0.5, .outside = 20, .inside = 200, .noise = {1, 0}};
    const disc d = {-120.3, 20.2, 160};
    mcv_readings r = new_picture(80, 40, l.outside);
    mcv_error error = {""};
    mcv_edge edge;
    mcv_circle arc;
    (void)state;
    draw_disc(&r, &d, &l);
    add_noise(&r, &l, 5, KNOWN);
    assert_int_equal(mcv_edge_parse("bore=10,0,60,40", 1, &r.values, &edge, &error), MCV_OK);
    assert_int_equal(mcv_edge_locate(&r, NAN, &edge, &error), MCV_OK);
    const double truth = -(160 - sqrt(160 * 160 - 20 * 20)); /* it bulges to the dark side */
    if (fabs(edge.sagitta.value - truth) > 0.016 * fabs(truth) + 1.96 * edge.sagitta.uncertainty)
        fail_msg("the sagitta is %g ± %g instead of %g", edge.sagitta.value,
                 edge.sagitta.uncertainty, truth);
    expect_refusal(mcv_edge_is_straight(&edge, &error), &error,
                   (const char *const[]){"edge bore", "sagitta", "1.2", "--circle", "--arc", NULL});
    locate(&r, "10,0,60,40", false, NAN, &arc);
    if (fabs(arc.radius.value - d.radius) > 4 * arc.radius.uncertainty)
        fail_msg("the arc's radius is %g ± %g instead of %g", arc.radius.value,
                 arc.radius.uncertainty, d.radius);
    assert_int_equal(mcv_circle_parse("10,0,60,40", 1, &r.values, true, &arc, &error), MCV_OK);
    expect_refusal(mcv_circle_locate(&r, NAN, &arc, &error), &error,
                   (const char *const[]){"--arc", NULL});
    release(&r);
}

static void test_no_circle(void **state) {
    const look l = {.outside = 20, .inside = 200, .noise = {4, 0}},
               soft = {.spread = 1.5, .outside = 20, .inside = 200, .noise = {4, 0}};
    const disc small = {20.3, 19.8, 9}, large = {19, 20, 16};
    mcv_readings r = new_picture(40, 40, l.outside);
    mcv_error error = {""};
    mcv_circle c;
    (void)state;
    add_noise(&r, &l, 1, KNOWN);
    assert_int_equal(mcv_circle_parse("0,0,40,40", 1, &r.values, true, &c, &error), MCV_OK);
    expect_refusal(mcv_circle_locate(&r, NAN, &c, &error), &error,
                   (const char *const[]){"circle 1", NULL});
    assert_int_equal(mcv_circle_parse("0,0,41,40", 1, &r.values, true, &c, &error), MCV_USAGE);
    release(&r);
    r = new_picture(40, 40, l.outside);
    draw_disc(&r, &small, &soft);
    add_noise(&r, &l, 1, KNOWN);
    assert_int_equal(mcv_circle_parse("0,0,40,40", 1, &r.values, true, &c, &error), MCV_OK);
    expect_refusal(mcv_circle_locate(&r, NAN, &c, &error), &error,
                   (const char *const[]){"too small", "blurred", NULL});
    release(&r);
    /* A box that is too tight leaves nothing of the outer side. */
    r = new_picture(40, 40, l.outside);
    draw_disc(&r, &large, &l);
    add_noise(&r, &l, 1, KNOWN);
    assert_int_equal(mcv_circle_parse("2,3,34,34", 1, &r.values, true, &c, &error), MCV_OK);
    expect_refusal(mcv_circle_locate(&r, NAN, &c, &error), &error,
                   (const char *const[]){"box", NULL});
    /* No width without a second edge. */
    mcv_caliper caliper;
    assert_int_equal(mcv_caliper_parse("20,10,20,10", 1, &r.values, &caliper, &error), MCV_OK);
    expect_refusal(mcv_caliper_locate(&r, NAN, &caliper, &error), &error,
                   (const char *const[]){"two opposite edges", NULL});
    release(&r);
}

/* A keyway in a bore, a tenth of its circumference, and a spot of dust: a least-squares fit of all
 * would be off by a good part of a pixel.
 */
static void test_robust(void **state) {
    const look l = {.spread = 0.4, .outside = 20, .inside = 200, .noise = {1, 0}};
    const disc d = {40.3, 39.6, 27.25};
    mcv_readings r = new_picture(80, 80, l.outside);
    mcv_circle c;
    (void)state;
    draw_disc(&r, &d, &l);
    for (uint32_t y = 0; y < 80; ++y)
        for (uint32_t x = 0; x < 80; ++x) {
            if (x > 60 && x < 75 && y > 32 && y < 49) r.values.pixels[y * 80 + x] = 200;
            if (hypot(x - 22.0, y - 20.0) < 4) r.values.pixels[y * 80 + x] = 20;
        }
    add_noise(&r, &l, 3, KNOWN);
    locate(&r, "3,2,75,75", true, NAN, &c);
    print_message("keyway and dust: %g %g %g off, %.0f %% rejected\n", c.column.value - d.column,
                  c.row.value - d.row, c.radius.value - d.radius, 100 * c.rejected);
    if (fabs(c.column.value - d.column) > 4 * c.column.uncertainty ||
        fabs(c.row.value - d.row) > 4 * c.row.uncertainty ||
        fabs(c.radius.value - d.radius) > 4 * c.radius.uncertainty)
        fail_msg("the circle is off by %g, %g, %g", c.column.value - d.column, c.row.value - d.row,
                 c.radius.value - d.radius);
    assert_true(c.rejected > 0.1 && c.rejected < 0.4);
    release(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bias),       cmocka_unit_test(test_circles),
        cmocka_unit_test(test_bores),      cmocka_unit_test(test_bars),
        cmocka_unit_test(test_deviations), cmocka_unit_test(test_curved),
        cmocka_unit_test(test_no_circle),  cmocka_unit_test(test_robust),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
