/* SPDX-License-Identifier: Apache-2.0 */
/* Rows and columns across a circle: where each has its step, which of them count, and the circle
 * through them. */
#include "analysis/circle_finder.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where the circle crosses a line at this distance from its centre, in the mean over a spread:
 * exact to the fifth order (Gauss, Hermite).
 */
static double mean_crossing(double radius, double off, double spread2) {
    const double node = sqrt(3 * spread2), r2 = radius * radius;
    return 2.0 / 3 * sqrt(r2 - off * off) +
           (sqrt(r2 - (off + node) * (off + node)) + sqrt(r2 - (off - node) * (off - node))) / 6;
}

/* The place of the scan, its window and model. False where it leaves the box or meets a NaN. */
static bool make_scan(const mcv_circle_finder *f, bool along_rows, uint32_t line, double turn,
                      mcv_circle_scan *s) {
    const mcv_image *image = &f->readings->values;
    const mcv_pixel_box *box = &f->circle->box;
    const double radius = f->at.radius, w = f->window,
                 off = line + 0.5 - f->at.centre[along_rows ? 1 : 0],
                 spread2 = mcv_circle_spread2(f);
    const double depth2 = radius * radius - off * off, middle = f->at.centre[along_rows ? 0 : 1],
                 h = 1e-3;
    const uint32_t first = along_rows ? box->x : box->y,
                   last = first + (along_rows ? box->width : box->height);
    *s = (mcv_circle_scan){.along_rows = along_rows, .line = line, .turn = turn, .used = true};
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
        const double share = mcv_overlap(k, s->from, s->to), part = share * share / (step * step);
        inside += share * (image->pixels[i] - f->level[0]) / step;
        s->variance += part * mcv_readings_summed_variance(f->readings, i, 1);
        s->shared += part * mcv_readings_summed_variance(f->readings, i, 2);
    }
    s->place = turn > 0 ? s->from + inside : s->to - inside;
    s->by_level[0] = turn * (inside - (s->to - s->from)) / step;
    s->by_level[1] = -turn * inside / step;
    return isfinite(s->place);
}

/* A scan's distance from the circle, outwards. */
static double distance_of(const mcv_circle_scan *s) {
    return s->turn * (s->place - s->model) * s->cosine;
}

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void mcv_circle_make_scans(mcv_circle_finder *f) {
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
static int scan_sector(const mcv_circle_finder *f, const mcv_circle_scan *s) {
    const double across = s->line + 0.5 - f->at.centre[s->along_rows ? 1 : 0],
                 along = s->model - f->at.centre[s->along_rows ? 0 : 1];
    return s->along_rows ? mcv_circle_sector(f, along, across)
                         : mcv_circle_sector(f, across, along);
}

bool mcv_circle_judge_scans(mcv_circle_finder *f, double *sizes) {
    bool bad[MCV_CIRCLE_SECTORS] = {false};
    for (size_t i = 0; i < f->scan_count; ++i) sizes[i] = fabs(distance_of(f->scans + i));
    if (f->scan_count < 8) return false;
    qsort(sizes, f->scan_count, sizeof *sizes, compare_doubles);
    const double usual = 1.4826 * sizes[f->scan_count / 2];
    size_t used = 0;
    memset(f->seen, 0, sizeof f->seen);
    for (size_t i = 0; i < f->scan_count; ++i) {
        mcv_circle_scan *s = f->scans + i;
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

bool mcv_circle_solve(mcv_circle_finder *f, bool move) {
    double right[3] = {0}, (*n)[3] = f->normal, (*v)[3] = f->inverse;
    memset(f->normal, 0, sizeof f->normal);
    for (size_t i = 0; i < f->scan_count; ++i) {
        const mcv_circle_scan *s = f->scans + i;
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
