/* SPDX-License-Identifier: Apache-2.0 */
/* A first guess of a circle: the one that most points of strong slope lie on. */
#include "analysis/circle_finder.h"

#include <math.h>
#include <stdlib.h>

/* A place of the steepest slope, and its direction towards the brighter side. */
typedef struct slope_point {
    double at[2], normal[2], size;
} slope_point;

/* Slopes of the image after smoothing by the binomial [1 2 1]² in both directions. They are zero at
 * the box's rim and NaN beside a NaN. */
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

static double slope_size(const float *slopes, size_t i) {
    return mcv_length2(slopes[2 * i], slopes[2 * i + 1]);
}

static int compare_points(const void *a, const void *b) {
    const double x = ((const slope_point *)a)->size, y = ((const slope_point *)b)->size;
    return (x < y) - (x > y);
}

/* Local maxima of the slope along its own direction. Kept are those of at least half the size of
 * the n-th largest; n is half of the box's shorter side. */
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
static bool through_three(const double *a, const double *b, const double *c, mcv_circle_guess *g) {
    const double u[2] = {b[0] - a[0], b[1] - a[1]}, v[2] = {c[0] - a[0], c[1] - a[1]},
                 area = 2 * (u[0] * v[1] - u[1] * v[0]);
    const double uu = u[0] * u[0] + u[1] * u[1], vv = v[0] * v[0] + v[1] * v[1];
    const double x = (v[1] * uu - u[1] * vv) / area, y = (u[0] * vv - v[0] * uu) / area;
    *g = (mcv_circle_guess){{a[0] + x, a[1] + y}, hypot(x, y)};
    return isfinite(g->radius);
}

/* Is it on the circle, with its slope along the circle's normal, bright inside or not? */
static bool lies_on(const slope_point *p, const mcv_circle_guess *g, double bright,
                    double tolerance) {
    const double x = g->centre[0] - p->at[0], y = g->centre[1] - p->at[1], r = mcv_length2(x, y);
    return fabs(r - g->radius) <= tolerance &&
           bright * (x * p->normal[0] + y * p->normal[1]) >= 0.9 * r;
}

/* Gauss and Newton's steps on the distances of the points that lie on it. */
static void fit_points(const slope_point *points, size_t count, double bright, double tolerance,
                       mcv_circle_guess *g) {
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

/* Is it plausible, and whole where a whole circle is asked for? Places count from the box's corner.
 */
static bool is_fit(const mcv_circle *circle, const mcv_circle_guess *g) {
    const double w = circle->box.width, h = circle->box.height;
    if (g->radius < 3) return false;
    if (!circle->whole) return g->radius < 100 * hypot(w, h);
    return g->centre[0] - g->radius > 0 && g->centre[1] - g->radius > 0 &&
           g->centre[0] + g->radius < w && g->centre[1] + g->radius < h;
}

/* Random sample consensus (Fischler and Bolles 1981): of many circles through three points the one
 * that most points lie on. */
static bool agree(const mcv_circle *circle, const slope_point *points, size_t count,
                  mcv_circle_guess *best, double *bright) {
    enum { TRIALS = 1000, MOST = 2000 };
    const size_t stride = count / MOST + 1;
    uint32_t state = 1;
    size_t most = 0;
    for (int trial = 0; trial < TRIALS && count >= 8; ++trial) {
        const slope_point *p[3];
        mcv_circle_guess g;
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

mcv_result mcv_circle_find_guess(const mcv_image *image, const mcv_circle *circle,
                                 mcv_circle_guess *g, double *bright, mcv_error *error) {
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
    return mcv_circle_fail(
        circle, error,
        circle->whole
            ? "no whole circle is in the box: give a box around it, or measure a part by --arc"
            : "no arc crosses the box");
}
