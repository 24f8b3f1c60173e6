/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/circle.h"

#include "analysis/form.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

mcv_result mcv_circle_parse(const char *text, size_t number, const mcv_image *image, bool whole,
                            mcv_circle *circle, mcv_error *error) {
    size_t count;
    *circle = (mcv_circle){.whole = whole};
    return mcv_boxes_parse(whole ? "circle" : "arc", text, number, image, 1, circle->name,
                           &circle->box, &count, error);
}

static mcv_result fail_circle(const mcv_circle *circle, mcv_error *error, const char *why) {
    return mcv_fail(error, MCV_FAILED, "%s %s: %s", circle->whole ? "circle" : "arc", circle->name,
                    why);
}

/* --- a first guess: the circle that most points of strong slope lie on
 * ---------------------------------------------- */

typedef struct guess {
    double centre[2], radius;
} guess;

/* A place of the steepest slope, and its direction towards the brighter side. */
typedef struct slope_point {
    double at[2], normal[2], size;
} slope_point;

/* Of the image smoothed by the binomial [1 2 1]² of both directions. Zero at the box's rim; NaN
 * beside a NaN. */
static void find_slopes(const mcv_image *image, const mcv_pixel_box *box, float *smooth,
                        float *slopes) {
    static const float tap[3] = {0.25F, 0.5F, 0.25F};
    const size_t w = box->width, h = box->height;
    for (size_t y = 1; y + 1 < h; ++y)
        for (size_t x = 1; x + 1 < w; ++x) {
            float sum = 0;
            for (size_t j = 0; j < 3; ++j)
                for (size_t i = 0; i < 3; ++i)
                    sum += tap[j] * tap[i] *
                           image->pixels[(box->y + y + j - 1) * image->width + box->x + x + i - 1];
            smooth[y * w + x] = sum;
        }
    for (size_t y = 2; y + 2 < h; ++y)
        for (size_t x = 2; x + 2 < w; ++x) {
            const float *s = smooth + y * w + x;
            slopes[2 * (y * w + x)] = 0.25F * (s[1] - s[-1]) +
                                      0.125F * (s[w + 1] - s[w - 1] + *(s - w + 1) - *(s - w - 1));
            slopes[2 * (y * w + x) + 1] =
                0.25F * (s[w] - *(s - w)) +
                0.125F * (s[w + 1] - *(s - w + 1) + s[w - 1] - *(s - w - 1));
        }
}

static double length_of(double x, double y) { return sqrt(x * x + y * y); }

static double slope_size(const float *slopes, size_t i) {
    return length_of(slopes[2 * i], slopes[2 * i + 1]);
}

static int compare_points(const void *a, const void *b) {
    const double x = ((const slope_point *)a)->size, y = ((const slope_point *)b)->size;
    return (x < y) - (x > y);
}

/* Where the slope is larger than one pixel before and behind; of these those of half the size that
 * a box's side of them has, or more. */
static size_t find_points(const mcv_pixel_box *box, const float *slopes, slope_point *points) {
    const size_t w = box->width, h = box->height;
    size_t count = 0;
    for (size_t y = 3; y + 3 < h; ++y)
        for (size_t x = 3; x + 3 < w; ++x) {
            const size_t i = y * w + x;
            const double size = slope_size(slopes, i);
            if (!(size > 0)) continue;
            const double nx = slopes[2 * i] / size, ny = slopes[2 * i + 1] / size;
            const bool lying = fabs(nx) >= fabs(ny);
            const size_t step = lying ? 1 : w;
            const double before = slope_size(slopes, i - step),
                         behind = slope_size(slopes, i + step);
            if (!(size > before && size >= behind)) continue;
            const double off = 0.5 * (before - behind) / (before - 2 * size + behind);
            points[count++] = (slope_point){
                {(double)x + 0.5 + (lying ? off : 0), (double)y + 0.5 + (lying ? 0 : off)},
                {nx, ny},
                size};
        }
    qsort(points, count, sizeof *points, compare_points);
    const size_t some = (w < h ? w : h) / 2;
    size_t strong = 0;
    while (strong < count &&
           points[strong].size >= 0.5 * points[some < count ? some : count - 1].size)
        ++strong;
    return strong;
}

/* False for three in a line. */
static bool through_three(const double *a, const double *b, const double *c, guess *g) {
    const double u[2] = {b[0] - a[0], b[1] - a[1]}, v[2] = {c[0] - a[0], c[1] - a[1]},
                 area = 2 * (u[0] * v[1] - u[1] * v[0]);
    const double uu = u[0] * u[0] + u[1] * u[1], vv = v[0] * v[0] + v[1] * v[1];
    const double x = (v[1] * uu - u[1] * vv) / area, y = (u[0] * vv - v[0] * uu) / area;
    *g = (guess){{a[0] + x, a[1] + y}, hypot(x, y)};
    return isfinite(g->radius);
}

/* Is it on the circle, with its slope along the circle's normal, bright inside or not? */
static bool lies_on(const slope_point *p, const guess *g, double bright, double tolerance) {
    const double x = g->centre[0] - p->at[0], y = g->centre[1] - p->at[1], r = length_of(x, y);
    return fabs(r - g->radius) <= tolerance &&
           bright * (x * p->normal[0] + y * p->normal[1]) >= 0.9 * r;
}

/* Gauss and Newton's steps on the distances of the points that lie on it. */
static void fit_points(const slope_point *points, size_t count, double bright, double tolerance,
                       guess *g) {
    double a[3][4] = {{0}};
    for (size_t i = 0; i < count; ++i) {
        if (!lies_on(points + i, g, bright, tolerance)) continue;
        const double x = points[i].at[0] - g->centre[0], y = points[i].at[1] - g->centre[1],
                     r = hypot(x, y);
        const double row[4] = {x / r, y / r, 1, r - g->radius};
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 4; ++k) a[j][k] += row[j] * row[k];
    }
    for (int j = 0; j < 3; ++j)
        for (int i = j + 1; i < 3; ++i) {
            const double f = a[i][j] / a[j][j];
            for (int k = j; k < 4; ++k) a[i][k] -= f * a[j][k];
        }
    double d[3];
    for (int j = 2; j >= 0; --j) {
        d[j] = a[j][3];
        for (int k = j + 1; k < 3; ++k) d[j] -= a[j][k] * d[k];
        d[j] /= a[j][j];
    }
    if (!isfinite(d[0] + d[1] + d[2])) return;
    g->centre[0] += d[0];
    g->centre[1] += d[1];
    g->radius += d[2];
}

/* Is it such a circle as is asked for? Places count from the box's corner. */
static bool is_fit(const mcv_circle *circle, const guess *g) {
    const double w = circle->box.width, h = circle->box.height;
    if (g->radius < 3) return false;
    if (!circle->whole) return g->radius < 100 * hypot(w, h);
    return g->centre[0] - g->radius > 0 && g->centre[1] - g->radius > 0 &&
           g->centre[0] + g->radius < w && g->centre[1] + g->radius < h;
}

/* Random sample consensus (Fischler and Bolles 1981): of many circles through three points the one
 * that most points lie on. */
static bool agree(const mcv_circle *circle, const slope_point *points, size_t count, guess *best,
                  double *bright) {
    enum { TRIALS = 1000, MOST = 2000 };
    const size_t stride = count / MOST + 1;
    uint32_t state = 1;
    size_t most = 0;
    for (int trial = 0; trial < TRIALS && count >= 8; ++trial) {
        const slope_point *p[3];
        guess g;
        for (int i = 0; i < 3; ++i) {
            state = state * 1664525U + 1013904223U;
            p[i] = points + (size_t)((double)state / 4294967296.0 * (double)count);
        }
        if (!through_three(p[0]->at, p[1]->at, p[2]->at, &g) || !is_fit(circle, &g)) continue;
        const double x = g.centre[0] - p[0]->at[0], y = g.centre[1] - p[0]->at[1];
        const double sign = x * p[0]->normal[0] + y * p[0]->normal[1] > 0 ? 1 : -1;
        size_t votes = 0;
        for (size_t i = 0; i < count; i += stride) votes += lies_on(points + i, &g, sign, 1);
        if (votes <= most) continue;
        most = votes;
        *best = g;
        *bright = sign;
    }
    if (most * stride < 8) return false;
    for (int round = 0; round < 5; ++round) fit_points(points, count, *bright, 1.5, best);
    return is_fit(circle, best);
}

static mcv_result find_guess(const mcv_image *image, const mcv_circle *circle, guess *g,
                             double *bright, mcv_error *error) {
    const size_t plane = (size_t)circle->box.width * circle->box.height;
    float *smooth = calloc(3 * plane, sizeof *smooth);
    slope_point *points = malloc(plane * sizeof *points);
    bool found = false;
    if (smooth && points) {
        find_slopes(image, &circle->box, smooth, smooth + plane);
        found = agree(circle, points, find_points(&circle->box, smooth + plane, points), g, bright);
        g->centre[0] += circle->box.x;
        g->centre[1] += circle->box.y;
    }
    free(smooth);
    free(points);
    if (found) return MCV_OK;
    return fail_circle(
        circle, error,
        circle->whole
            ? "no whole circle is in the box: give a box around it, or measure a part by --arc"
            : "no arc crosses the box");
}

/* --- scans
 * ----------------------------------------------------------------------------------------------------------
 */

enum { MAX_SECTORS = 256 };

/* One row or column where it crosses the circle. `turn`: 1 where it leaves the circle towards
 * higher columns or rows, else -1. */
typedef struct scan {
    bool along_rows, used;
    uint32_t line;
    double turn, from, to; /* the window along it, in columns or rows */
    double place, model;   /* where the step is, and where the circle's would be */
    double gradient[3];    /* of the model by column, row and radius */
    double by_spread;      /* of the model by σ² */
    double cosine;         /* of its angle to the normal */
    double by_level[2];    /* of the place by the levels outside and inside */
    double variance;       /* of the place by its own pixels */
} scan;

typedef struct finder {
    mcv_circle *circle;
    const mcv_readings *readings;
    guess at;
    double level[2]; /* outside, inside */
    double window;   /* from the circle, both ways, to where the plateaus begin */
    double spread2;  /* σ² as measured */
    int sectors;
    bool seen[MAX_SECTORS]; /* all scans there count */
    scan *scans;
    size_t scan_count;
    double normal[3][3], inverse[3][3]; /* of the least squares */
} finder;

/* σ² is that of a pixel at the least. */
static double used_spread2(const finder *f) { return fmax(f->spread2, 1.0 / 12); }

/*
 * Scans within 45° keep the window's ends beyond it from the circle: R²/2 - 2RW + W² >= 0. The
 * circle over ±√3 σ of the scan's own width must exist, too: R/√2 + √3 σ < 0.95 R.
 */
static double widest_window(double radius) { return (1 - M_SQRT1_2) * radius; }

/* Of the direction's place on the unit square turned by 45°, which goes round as the angle does. */
static int sector_of(const finder *f, double x, double y) {
    const double share = y / (fabs(x) + fabs(y)), turn = 0.25 * (x < 0   ? 2 - share
                                                                 : y < 0 ? 4 + share
                                                                         : share);
    const int sector = (int)(turn * f->sectors);
    return sector < f->sectors ? sector : f->sectors - 1;
}

/* Where the circle crosses a line at this distance from its centre, in the mean over a spread:
 * exact to the fifth order (Gauss, Hermite).
 */
static double mean_crossing(double radius, double off, double spread2) {
    const double node = sqrt(3 * spread2), r2 = radius * radius;
    return 2.0 / 3 * sqrt(r2 - off * off) +
           (sqrt(r2 - (off + node) * (off + node)) + sqrt(r2 - (off - node) * (off - node))) / 6;
}

/* The place of the scan, its window and model. False where it leaves the box or meets a NaN. */
static bool make_scan(const finder *f, bool along_rows, uint32_t line, double turn, scan *s) {
    const mcv_image *image = &f->readings->values, *deviation = &f->readings->deviation;
    const mcv_pixel_box *box = &f->circle->box;
    const double radius = f->at.radius, w = f->window,
                 off = line + 0.5 - f->at.centre[along_rows ? 1 : 0], spread2 = used_spread2(f);
    const double depth2 = radius * radius - off * off, middle = f->at.centre[along_rows ? 0 : 1],
                 h = 1e-3;
    const uint32_t first = along_rows ? box->x : box->y,
                   last = first + (along_rows ? box->width : box->height);
    *s = (scan){.along_rows = along_rows, .line = line, .turn = turn, .used = true};
    if (!(fabs(off) <= radius * M_SQRT1_2)) return false;
    const double inner = sqrt(fmax(0, depth2 - 2 * radius * w + w * w)),
                 outer = sqrt(depth2 + 2 * radius * w + w * w);
    s->from = turn > 0 ? middle + inner : middle - outer;
    s->to = turn > 0 ? middle + outer : middle - inner;
    if (s->from < first || s->to > last) return false;
    s->cosine = sqrt(depth2) / radius;
    const double crossing = mean_crossing(radius, off, spread2);
    s->model = middle + turn * crossing;
    s->gradient[along_rows ? 0 : 1] = 1;
    s->gradient[along_rows ? 1 : 0] =
        -turn *
        (mean_crossing(radius, off + h, spread2) - mean_crossing(radius, off - h, spread2)) /
        (2 * h);
    s->gradient[2] =
        turn * (mean_crossing(radius + h, off, spread2) - mean_crossing(radius - h, off, spread2)) /
        (2 * h);
    s->by_spread =
        turn * (mean_crossing(radius, off, spread2 + h) - mean_crossing(radius, off, spread2 - h)) /
        (2 * h);
    const double step = f->level[1] - f->level[0];
    double inside = 0;
    for (size_t k = (size_t)s->from; (double)k < s->to; ++k) {
        const size_t i = along_rows ? (size_t)line * image->width + k : k * image->width + line;
        const double share = mcv_overlap(k, s->from, s->to), u = deviation->pixels[i];
        inside += share * (image->pixels[i] - f->level[0]) / step;
        s->variance += share * share * u * u / (step * step);
    }
    s->place = turn > 0 ? s->from + inside : s->to - inside;
    s->by_level[0] = turn * (inside - (s->to - s->from)) / step;
    s->by_level[1] = -turn * inside / step;
    return isfinite(s->place);
}

/* A scan's distance from the circle, outwards. */
static double distance_of(const scan *s) { return s->turn * (s->place - s->model) * s->cosine; }

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void make_scans(finder *f) {
    const mcv_pixel_box *box = &f->circle->box;
    f->scan_count = 0;
    for (int along_rows = 0; along_rows < 2; ++along_rows) {
        const uint32_t first = along_rows ? box->y : box->x,
                       last = first + (along_rows ? box->height : box->width);
        for (uint32_t line = first; line < last; ++line)
            for (int turn = -1; turn <= 1; turn += 2)
                f->scan_count += make_scan(f, along_rows, line, turn, f->scans + f->scan_count);
    }
}

/* The sector of the place where the scan meets the circle. */
static int scan_sector(const finder *f, const scan *s) {
    const double across = s->line + 0.5 - f->at.centre[s->along_rows ? 1 : 0],
                 along = s->model - f->at.centre[s->along_rows ? 0 : 1];
    return s->along_rows ? sector_of(f, along, across) : sector_of(f, across, along);
}

/*
 * Places farther off than five times what noise, or the median of all distances, says do not count;
 * at least a tenth of a pixel is allowed. Sectors without such places and with others are seen.
 */
static bool judge_scans(finder *f, double *sizes) {
    bool bad[MAX_SECTORS] = {false};
    for (size_t i = 0; i < f->scan_count; ++i) sizes[i] = fabs(distance_of(f->scans + i));
    if (f->scan_count < 8) return false;
    qsort(sizes, f->scan_count, sizeof *sizes, compare_doubles);
    const double usual = 1.4826 * sizes[f->scan_count / 2];
    size_t used = 0;
    memset(f->seen, 0, sizeof f->seen);
    for (size_t i = 0; i < f->scan_count; ++i) {
        scan *s = f->scans + i;
        const int sector = scan_sector(f, s);
        s->used = fabs(distance_of(s)) <= fmax(0.1, 5 * fmax(usual, sqrt(s->variance) * s->cosine));
        if (!s->used) bad[sector] = true;
        f->seen[sector] = true;
    }
    for (int k = 0; k < f->sectors; ++k) f->seen[k] = f->seen[k] && !bad[k];
    for (size_t i = 0; i < f->scan_count; ++i) {
        f->scans[i].used = f->scans[i].used && f->seen[scan_sector(f, f->scans + i)];
        used += f->scans[i].used;
    }
    return used >= 8;
}

/* One step of least squares. Distances count by arc length: a scan has 1/cosine of it. False where
 * they do not tell three numbers. */
static bool solve(finder *f, bool move) {
    double right[3] = {0}, (*n)[3] = f->normal, (*v)[3] = f->inverse;
    memset(f->normal, 0, sizeof f->normal);
    for (size_t i = 0; i < f->scan_count; ++i) {
        const scan *s = f->scans + i;
        for (int j = 0; j < 3 && s->used; ++j) {
            right[j] += s->cosine * s->gradient[j] * (s->place - s->model);
            for (int k = 0; k < 3; ++k) n[j][k] += s->cosine * s->gradient[j] * s->gradient[k];
        }
    }
    double determinant = 0;
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) {
            const int a = (k + 1) % 3, b = (k + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
            v[j][k] = n[a][c] * n[b][d] - n[a][d] * n[b][c];
        }
    for (int k = 0; k < 3; ++k) determinant += n[0][k] * v[k][0];
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) v[j][k] /= determinant;
    double d[3];
    for (int j = 0; j < 3; ++j) d[j] = v[j][0] * right[0] + v[j][1] * right[1] + v[j][2] * right[2];
    if (!isfinite(d[0] + d[1] + d[2])) return false;
    if (!move) return true;
    f->at.centre[0] += d[0];
    f->at.centre[1] += d[1];
    f->at.radius += d[2];
    return f->at.radius > 3 && f->at.radius < 1e6;
}

/* --- the pixels beside the circle
 * ----------------------------------------------------------------------------------- */

/* From the window's end outwards and inwards. */
static double plateau_width(const finder *f) { return fmax(6, f->window); }

/* Calls for every pixel of a seen sector in the ring of the window and the plateaus: with its
 * index, and its distance from the circle. */
typedef void visit(finder *f, size_t index, double distance, void *user);

static void visit_ring(finder *f, visit *call, void *user) {
    const mcv_image *image = &f->readings->values;
    const mcv_pixel_box *box = &f->circle->box;
    const double reach = f->window + 0.75 + plateau_width(f);
    for (uint32_t y = box->y; y < box->y + box->height; ++y)
        for (uint32_t x = box->x; x < box->x + box->width; ++x) {
            const size_t i = (size_t)y * image->width + x;
            const double dx = x + 0.5 - f->at.centre[0], dy = y + 0.5 - f->at.centre[1],
                         d = length_of(dx, dy) - f->at.radius;
            if (!(fabs(d) <= reach) || isnan(image->pixels[i]) || !f->seen[sector_of(f, dx, dy)])
                continue;
            call(f, i, d, user);
        }
}

static bool on_plateau(const finder *f, double distance) {
    return fabs(distance) >= f->window + 0.75;
}

typedef struct ring_sums {
    double count[2], sum[2]; /* outside, inside */
    double density, deviation,
        moment; /* of pixels in the window, and of their distances' sizes and squares */
} ring_sums;

static void add_level(finder *f, size_t i, double d, void *user) {
    ring_sums *r = user;
    if (!on_plateau(f, d)) return;
    ++r->count[d < 0];
    r->sum[d < 0] += f->readings->values.pixels[i];
}

/*
 * σ² = ∫ 2|x| |E(x) - step(x)| dx of the spread function E, and its mean deviation ∫ |E(x) -
 * step(x)| dx; a pixel at the radius r stands for 1/r of the circumference.
 */
static void add_moments(finder *f, size_t i, double d, void *user) {
    ring_sums *r = user;
    if (fabs(d) > f->window) return;
    const double share =
                     (f->readings->values.pixels[i] - f->level[0]) / (f->level[1] - f->level[0]),
                 wrong = d < 0 ? 1 - share : share;
    r->density += 1 / (f->at.radius + d);
    r->deviation += wrong / (f->at.radius + d);
    r->moment += 2 * fabs(d) * wrong / (f->at.radius + d);
}

/* False where a side is not seen. */
static bool find_levels(finder *f, ring_sums *r) {
    *r = (ring_sums){0};
    visit_ring(f, add_level, r);
    for (int i = 0; i < 2; ++i) f->level[i] = r->sum[i] / r->count[i];
    return fmin(r->count[0], r->count[1]) >= 8 && f->level[0] != f->level[1];
}

static bool find_spread(finder *f, ring_sums *r) {
    r->density = r->deviation = r->moment = 0;
    visit_ring(f, add_moments, r);
    f->spread2 = 2 * f->window * r->moment / r->density;
    return isfinite(f->spread2);
}

/* --- noise that is not known
 * ---------------------------------------------------------------------------------------- */

typedef struct sides {
    mcv_roi region[2];
} sides;

static void add_side(finder *f, size_t i, double d, void *user) {
    mcv_roi *side = ((sides *)user)->region + (d < 0);
    if (!on_plateau(f, d)) return;
    side->inside[i] = 1;
    ++side->count;
}

typedef struct mixture {
    mcv_readings *readings;
    double variance[2];
} mixture;

/* Between the plateaus the variance goes with the grey value, as that of light does. */
static void set_noise(finder *f, size_t i, double d, void *user) {
    const mixture *m = user;
    const double share = fmin(
        1, fmax(0, (f->readings->values.pixels[i] - f->level[0]) / (f->level[1] - f->level[0])));
    const double used = on_plateau(f, d) ? d < 0 : share;
    m->readings->deviation.pixels[i] =
        (float)sqrt((1 - used) * m->variance[0] + used * m->variance[1]);
}

static mcv_result estimate_noise(finder *f, mcv_readings *readings, double least, double *freedom,
                                 mcv_error *error) {
    const mcv_image *image = &readings->values;
    const size_t plane = (size_t)image->width * image->height;
    uint8_t *inside = calloc(2 * plane, 1); /* of both sides */
    mixture m = {.readings = readings};
    sides s = {0};
    if (!inside) return fail_circle(f->circle, error, "no memory for its sides");
    for (int i = 0; i < 2; ++i)
        s.region[i] =
            (mcv_roi){.width = image->width, .height = image->height, .inside = inside + i * plane};
    visit_ring(f, add_side, &s);
    for (int i = 0; i < 2; ++i)
        m.variance[i] =
            s.region[i].count ? pow(mcv_roi_estimate_noise(readings, s.region + i, least), 2) : NAN;
    free(inside);
    const uint64_t count[2] = {s.region[0].estimated, s.region[1].estimated};
    if (!(m.variance[0] >= 0 && m.variance[1] >= 0) || count[0] < 4 || count[1] < 4)
        return fail_circle(
            f->circle, error,
            "too little room beside it to see the image's noise: give a larger box, or --noise");
    visit_ring(f, set_noise, &m);
    *freedom = mcv_noise_freedom(m.variance, count);
    return MCV_OK;
}

/* --- uncertainty
 * ----------------------------------------------------------------------------------------------------
 */

/* By how much each pixel moves column, row and radius: all that was done with pixels is linear in
 * them, to first order. */
typedef struct weights {
    double (*pixel)[3]; /* per pixel of the box */
    double by_level[2][3], by_spread[3];
    const ring_sums *ring;
    double covariance[3][3];
} weights;

static size_t in_box(const finder *f, size_t index) {
    const uint32_t width = f->readings->values.width;
    return (index / width - f->circle->box.y) * f->circle->box.width + index % width -
           f->circle->box.x;
}

static void weigh_scans(const finder *f, weights *w) {
    const uint32_t width = f->readings->values.width;
    const double step = f->level[1] - f->level[0];
    for (size_t i = 0; i < f->scan_count; ++i) {
        const scan *s = f->scans + i;
        double pull[3];
        if (!s->used) continue;
        for (int j = 0; j < 3; ++j) {
            pull[j] = 0;
            for (int k = 0; k < 3; ++k) pull[j] += f->inverse[j][k] * s->cosine * s->gradient[k];
            w->by_spread[j] -= pull[j] * s->by_spread;
            for (int side = 0; side < 2; ++side)
                w->by_level[side][j] += pull[j] * s->by_level[side];
        }
        for (size_t k = (size_t)s->from; (double)k < s->to; ++k) {
            const size_t index = s->along_rows ? (size_t)s->line * width + k : k * width + s->line;
            for (int j = 0; j < 3; ++j)
                w->pixel[in_box(f, index)][j] +=
                    pull[j] * s->turn * mcv_overlap(k, s->from, s->to) / step;
        }
    }
}

static void weigh_ring(finder *f, size_t i, double d, void *user) {
    weights *w = user;
    const int side = d < 0;
    const double step = f->level[1] - f->level[0], scale = 2 * f->window / w->ring->density;
    for (int j = 0; j < 3; ++j) {
        if (on_plateau(f, d))
            w->pixel[in_box(f, i)][j] += w->by_level[side][j] / w->ring->count[side];
        if (fabs(d) > f->window || !(f->spread2 > 1.0 / 12)) continue;
        w->pixel[in_box(f, i)][j] +=
            w->by_spread[j] * scale * 2 * fabs(d) * (side ? -1 : 1) / (step * (f->at.radius + d));
    }
}

static bool find_covariance(finder *f, const ring_sums *ring, double covariance[3][3]) {
    const mcv_pixel_box *box = &f->circle->box;
    const mcv_image *deviation = &f->readings->deviation;
    weights w = {.pixel = calloc((size_t)box->width * box->height, sizeof *w.pixel), .ring = ring};
    if (!w.pixel) return false;
    weigh_scans(f, &w);
    visit_ring(f, weigh_ring, &w);
    memset(covariance, 0, 9 * sizeof(double));
    for (size_t i = 0; i < (size_t)box->width * box->height; ++i) {
        const double u =
            deviation
                ->pixels[(box->y + i / box->width) * deviation->width + box->x + i % box->width];
        if (w.pixel[i][0] == 0 && w.pixel[i][1] == 0 && w.pixel[i][2] == 0) continue;
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k) covariance[j][k] += w.pixel[i][j] * w.pixel[i][k] * u * u;
    }
    free(w.pixel);
    return true;
}

/* The covariance of a row's place and a column's by the one pixel that they may share. */
static double shared_variance(const finder *f, const scan *row, const scan *column) {
    const double of_row = mcv_overlap(column->line, row->from, row->to),
                 of_column = mcv_overlap(row->line, column->from, column->to);
    const mcv_image *deviation = &f->readings->deviation;
    if (of_row == 0 || of_column == 0) return 0;
    const double u = deviation->pixels[(size_t)row->line * deviation->width + column->line] /
                     (f->level[1] - f->level[0]);
    return row->turn * column->turn * of_row * of_column * u * u;
}

/* The scans' distances from the circle, by arc length; what noise makes of them, less what the fit
 * takes out. */
static mcv_scatter scatter_of(const finder *f) {
    mcv_scatter all = {0};
    for (size_t i = 0; i < f->scan_count; ++i) {
        const scan *s = f->scans + i;
        double taken = 0;
        if (!s->used) continue;
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                taken += s->cosine * s->gradient[j] * f->inverse[j][k] * s->gradient[k];
        const double square = s->cosine * pow(s->place - s->model, 2),
                     noise = s->cosine * s->variance;
        all.count += 1 / s->cosine;
        all.squares += square;
        all.noise += noise * (1 - taken);
        all.variance += 2 * noise * noise * fmax(0, 1 - 2 * taken);
        all.crossed += 4 * fmax(0, square - noise) * noise;
        for (size_t k = 0; k < f->scan_count && s->along_rows; ++k) {
            const scan *other = f->scans + k;
            if (other->along_rows || !other->used) continue;
            all.variance += 4 * s->cosine * other->cosine * pow(shared_variance(f, s, other), 2);
        }
    }
    return all;
}

/* --- finding
 * --------------------------------------------------------------------------------------------------------
 */

/* Plateaus, spread and window, scans and their circle, in turns. */
static mcv_result refine(finder *f, int rounds, ring_sums *ring, double *sizes, mcv_error *error) {
    const mcv_circle *c = f->circle;
    for (int round = 0; round < rounds; ++round) {
        const double widest = widest_window(f->at.radius);
        if (!find_levels(f, ring) || !find_spread(f, ring))
            return fail_circle(c, error,
                               "too little room beside it: the box must hold more of both sides");
        /* 3 σ and a pixel. Noise moves the mean deviation less than σ²: a window that goes with the
         * noise would go with the radius. */
        const double deviation = 2 * f->window * ring->deviation / ring->density;
        f->window = fmin(0.5 * ceil(2 * (3 * sqrt(M_PI / 2) * fmax(deviation, 0.25) + 1)), widest);
        if (2 * sqrt(used_spread2(f)) + 1 > widest)
            return mcv_fail(error, MCV_FAILED,
                            "%s %s: its radius of %.1f pixels is too small for an edge that is "
                            "blurred by %.1f pixels: %.0f are needed",
                            c->whole ? "circle" : "arc", c->name, f->at.radius,
                            sqrt(used_spread2(f)),
                            (2 * sqrt(used_spread2(f)) + 1) / widest_window(1));
        if (!find_levels(f, ring) || !find_spread(f, ring))
            return fail_circle(c, error,
                               "too little room beside it: the box must hold more of both sides");
        make_scans(f);
        if (!judge_scans(f, sizes) || !solve(f, true))
            return fail_circle(c, error,
                               c->whole
                                   ? "too little of a circle is in the box, with room on both "
                                     "sides: give a box around it"
                                   : "too little of an arc is in the box, with room on both sides");
    }
    return MCV_OK;
}

static mcv_result finish(finder *f, const ring_sums *ring, double freedom, mcv_error *error) {
    mcv_circle *c = f->circle;
    if (!solve(f, false) || !find_covariance(f, ring, c->covariance))
        return fail_circle(c, error, "no memory for its uncertainty");
    const mcv_scatter scatter = scatter_of(f);
    const double clearly = scatter.noise + 3 * sqrt(scatter.variance);
    const double wide = mcv_widening(freedom) *
                        (scatter.squares > clearly ? sqrt(scatter.squares / scatter.noise) : 1);
    double used = 0;
    for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 3; ++k) c->covariance[j][k] *= wide * wide;
    for (size_t i = 0; i < f->scan_count; ++i) used += f->scans[i].used;
    c->bright = f->level[1] > f->level[0];
    c->column = (mcv_quantity){f->at.centre[0], sqrt(c->covariance[0][0])};
    c->row = (mcv_quantity){f->at.centre[1], sqrt(c->covariance[1][1])};
    c->radius = (mcv_quantity){f->at.radius, sqrt(c->covariance[2][2])};
    c->diameter = (mcv_quantity){2 * c->radius.value, 2 * c->radius.uncertainty};
    c->roundness = mcv_form_deviation(&scatter, freedom);
    c->seen = fmin(1, scatter.count / (2 * M_PI * f->at.radius));
    c->rejected = 1 - used / (double)f->scan_count;
    c->spread = sqrt(used_spread2(f));
    if (c->whole && c->seen < 0.5)
        return mcv_fail(error, MCV_FAILED,
                        "circle %s: only %.0f %% of it has room on both sides in the box: give a "
                        "larger box around it, or measure a part by --arc",
                        c->name, 100 * c->seen);
    if (!(c->radius.uncertainty <= 0.1 * c->radius.value))
        return mcv_fail(error, MCV_FAILED,
                        "%s %s is too short to tell its radius, %.3g ± %.2g pixels: show more of "
                        "it, or measure it by --edge",
                        c->whole ? "circle" : "arc", c->name, c->radius.value,
                        c->radius.uncertainty);
    return MCV_OK;
}

static mcv_result locate(finder *f, mcv_readings *readings, double least, mcv_error *error) {
    enum { ROUNDS = 6 };
    const mcv_pixel_box *box = &f->circle->box;
    double bright = 0, freedom = INFINITY,
           *sizes = malloc(4 * ((size_t)box->width + box->height) * sizeof *sizes);
    ring_sums ring = {0};
    f->scans = malloc(4 * ((size_t)box->width + box->height) * sizeof *f->scans);
    mcv_result result = MCV_FAILED;
    if (!sizes || !f->scans)
        (void)fail_circle(f->circle, error, "no memory for it");
    else
        result = find_guess(&readings->values, f->circle, &f->at, &bright, error);
    if (result == MCV_OK) {
        const double sectors = 0.5 * f->at.radius; /* each of them of 9 to 18 pixels */
        f->sectors = sectors < 8 ? 8 : sectors > MAX_SECTORS ? MAX_SECTORS : (int)sectors;
        f->window = fmin(5, widest_window(f->at.radius));
        for (int k = 0; k < f->sectors; ++k) f->seen[k] = true;
        result = refine(f, ROUNDS, &ring, sizes, error);
    }
    if (result == MCV_OK && !isnan(least))
        result = estimate_noise(f, readings, least, &freedom, error);
    if (result == MCV_OK && !isnan(least)) result = refine(f, 2, &ring, sizes, error);
    if (result == MCV_OK) result = finish(f, &ring, freedom, error);
    free(sizes);
    free(f->scans);
    return result;
}

mcv_result mcv_circle_locate(mcv_readings *readings, double least, mcv_circle *circle,
                             mcv_error *error) {
    finder f = {.circle = circle, .readings = readings};
    return locate(&f, readings, least, error);
}

/* --- distances
 * ------------------------------------------------------------------------------------------------------
 */

/* nᵀ C n of the centre. */
static double centre_variance(const mcv_circle *c, double x, double y) {
    return x * x * c->covariance[0][0] + 2 * x * y * c->covariance[0][1] +
           y * y * c->covariance[1][1];
}

mcv_quantity mcv_circle_distance(const mcv_circle *a, const mcv_circle *b) {
    const double dx = b->column.value - a->column.value, dy = b->row.value - a->row.value,
                 d = hypot(dx, dy), x = dx / d, y = dy / d;
    const double along = centre_variance(a, x, y) + centre_variance(b, x, y),
                 across = centre_variance(a, -y, x) + centre_variance(b, -y, x);
    if (d == 0)
        return (mcv_quantity){0, sqrt(a->covariance[0][0] + b->covariance[0][0] +
                                      a->covariance[1][1] + b->covariance[1][1])};
    /* Noise at right angles lengthens it; what that leaves uncertain is second order, as for the
     * modulation of an edge. */
    return (mcv_quantity){fmax(0, d - across / (2 * d)), sqrt(along + 2 * across / d * across / d)};
}

mcv_quantity mcv_edge_to_circle(const mcv_edge *line, const mcv_circle *circle) {
    const double *n = line->normal, x = circle->column.value - line->point[0],
                 y = circle->row.value - line->point[1];
    const double along = y * n[0] - x * n[1],
                 place = line->position.uncertainty * cos(line->tilt.value);
    return (mcv_quantity){x * n[0] + y * n[1],
                          sqrt(place * place + pow(along * line->tilt.uncertainty, 2) +
                               centre_variance(circle, n[0], n[1]))};
}
