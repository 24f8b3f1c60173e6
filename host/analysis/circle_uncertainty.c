/* SPDX-License-Identifier: Apache-2.0 */
/* By how much the noise of pixels moves a circle, and its scans about it. */
#include "analysis/circle_finder.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* By how much each pixel moves column, row and radius: all that was done with pixels is linear in
 * them, to first order. */
typedef struct weights {
    double (*pixel)[3]; /* per pixel of the box */
    double by_level[2][3], by_spread[3];
    const mcv_ring_sums *ring;
    double covariance[3][3];
} weights;

static size_t in_box(const mcv_circle_finder *f, size_t index) {
    const uint32_t width = f->readings->values.width;
    return (index / width - f->circle->box.y) * f->circle->box.width + index % width -
           f->circle->box.x;
}

static void weigh_scans(const mcv_circle_finder *f, weights *w) {
    const uint32_t width = f->readings->values.width;
    const double step = f->level[1] - f->level[0];
    for (size_t i = 0; i < f->scan_count; ++i) {
        const mcv_circle_scan *s = f->scans + i;
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

static void weigh_ring(mcv_circle_finder *f, size_t i, double d, void *user) {
    weights *w = user;
    const int side = d < 0;
    const double step = f->level[1] - f->level[0], scale = 2 * f->window / w->ring->density;
    for (int j = 0; j < 3; ++j) {
        if (mcv_circle_on_plateau(f, d))
            w->pixel[in_box(f, i)][j] += w->by_level[side][j] / w->ring->count[side];
        if (fabs(d) > f->window || !(f->spread2 > 1.0 / 12)) continue;
        w->pixel[in_box(f, i)][j] +=
            w->by_spread[j] * scale * 2 * fabs(d) * (side ? -1 : 1) / (step * (f->at.radius + d));
    }
}

bool mcv_circle_find_covariance(mcv_circle_finder *f, const mcv_ring_sums *ring,
                                double covariance[3][3]) {
    const mcv_pixel_box *box = &f->circle->box;
    weights w = {.pixel = calloc((size_t)box->width * box->height, sizeof *w.pixel), .ring = ring};
    if (!w.pixel) return false;
    weigh_scans(f, &w);
    mcv_circle_visit_ring(f, weigh_ring, &w);
    memset(covariance, 0, 9 * sizeof(double));
    for (size_t i = 0; i < (size_t)box->width * box->height; ++i) {
        const size_t at =
            (box->y + i / box->width) * f->readings->values.width + box->x + i % box->width;
        if (w.pixel[i][0] == 0 && w.pixel[i][1] == 0 && w.pixel[i][2] == 0) continue;
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                covariance[j][k] += w.pixel[i][j] * w.pixel[i][k] *
                                    mcv_readings_summed_variance(f->readings, at, 2);
    }
    free(w.pixel);
    return true;
}

/* The covariance of a row's place and a column's by the one pixel that they may share. */
static double shared_variance(const mcv_circle_finder *f, const mcv_circle_scan *row,
                              const mcv_circle_scan *column) {
    const double of_row = mcv_overlap(column->line, row->from, row->to),
                 of_column = mcv_overlap(row->line, column->from, column->to);
    const mcv_image *deviation = &f->readings->deviation;
    if (of_row == 0 || of_column == 0) return 0;
    const double u = deviation->pixels[(size_t)row->line * deviation->width + column->line] /
                     (f->level[1] - f->level[0]);
    return row->turn * column->turn * of_row * of_column * u * u;
}

mcv_scatter mcv_circle_scatter(const mcv_circle_finder *f) {
    mcv_scatter all = {0};
    for (size_t i = 0; i < f->scan_count; ++i) {
        const mcv_circle_scan *s = f->scans + i;
        double taken = 0;
        if (!s->used) continue;
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                taken += s->cosine * s->gradient[j] * f->inverse[j][k] * s->gradient[k];
        const double square = s->cosine * pow(s->place - s->model, 2),
                     noise = s->cosine * s->variance, shared = s->cosine * s->shared,
                     own = mcv_readings_squared_covariance(f->readings, noise, shared);
        all.count += 1 / s->cosine;
        all.squares += square;
        all.noise += noise - shared * taken;
        all.variance += 2 * fmax(0, own - 2 * taken * shared * shared);
        all.crossed += 4 * fmax(0, square - noise) * shared;
        for (size_t k = 0; k < f->scan_count && s->along_rows; ++k) {
            const mcv_circle_scan *other = f->scans + k;
            if (other->along_rows || !other->used) continue;
            all.variance += 4 * s->cosine * other->cosine * pow(shared_variance(f, s, other), 2);
        }
    }
    return all;
}
