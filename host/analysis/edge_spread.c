/* SPDX-License-Identifier: Apache-2.0 */
/* The edge spread function in bins along the normal, and where it passes a level: the edge's width.
 */
#include "analysis/edge_line.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

void mcv_edge_bins_free(mcv_edge_bins *b) { free(b->count); }

bool mcv_edge_fill_bins(const mcv_edge_patch *p, const mcv_edge_line *l, mcv_edge_bins *b) {
    const double cosine = 1 / sqrt(1 + l->slope * l->slope), first = mcv_edge_line_column(l, 0.5),
                 last = mcv_edge_line_column(l, (double)p->rows - 0.5);
    const double reach = fmin(fmin(first, last), (double)p->columns - fmax(first, last)) * cosine;
    *b = (mcv_edge_bins){.half = reach > 1 ? (size_t)(reach * MCV_ESF_PER_PIXEL) : 0};
    b->count = b->half ? calloc(10 * b->half, sizeof *b->count) : NULL;
    if (!b->count) return false;
    b->sum = b->count + 2 * b->half;
    b->variance = b->sum + 2 * b->half;
    b->place = b->variance + 2 * b->half;
    b->place2 = b->place + 2 * b->half;
    for (size_t row = 0; row < p->rows; ++row)
        for (size_t column = 0; column < p->columns; ++column) {
            const double off =
                ((double)column + 0.5 - mcv_edge_line_column(l, (double)row + 0.5)) * cosine;
            const double bin = floor(off * MCV_ESF_PER_PIXEL) + (double)b->half;
            if (bin < 0 || bin >= 2 * (double)b->half) continue;
            const size_t i = (size_t)bin;
            ++b->count[i];
            b->sum[i] += mcv_patch_value(p, column, row);
            b->variance[i] += mcv_patch_variance(p, column, row);
            b->place[i] += off;
            b->place2[i] += off * off;
        }
    return true;
}

/* The spread function's level in a bin. */
static double level_of(const mcv_edge_bins *b, const mcv_edge_line *l, size_t bin) {
    return (b->sum[bin] / b->count[bin] - l->left.value) / (l->right.value - l->left.value);
}

/* The next bin that holds pixels, from `bin` outwards or back; SIZE_MAX where there is none. */
static size_t next_bin(const mcv_edge_bins *b, size_t bin, int direction) {
    do bin += (size_t)direction;
    while (bin < 2 * b->half && b->count[bin] == 0);
    return bin < 2 * b->half ? bin : SIZE_MAX;
}

/*
 * Where the spread function passes a level between its plateaus, nearest to the edge: noise may
 * pass it elsewhere. Its form between two bins is unknown: their distance times its rise is taken
 * as the width of a uniform distribution.
 */
static mcv_quantity crossing(const mcv_edge_bins *b, const mcv_edge_line *l, double level) {
    const int outwards = level < 0.5 ? -1 : 1;
    size_t inner = next_bin(b, b->half - 1, 1);
    while (inner != SIZE_MAX && (level_of(b, l, inner) - level) * outwards >= 0)
        inner = next_bin(b, inner, -outwards);
    for (size_t outer; inner != SIZE_MAX; inner = outer) {
        outer = next_bin(b, inner, outwards);
        if (outer == SIZE_MAX) break;
        const double here = level_of(b, l, inner), there = level_of(b, l, outer);
        if ((there - level) * outwards < 0) continue;
        const double place = b->place[inner] / b->count[inner],
                     gap = b->place[outer] / b->count[outer] - place, slope = (there - here) / gap;
        const double noise = fmax(b->variance[inner] / pow(b->count[inner], 2),
                                  b->variance[outer] / pow(b->count[outer], 2));
        const double step = l->right.value - l->left.value, shape = gap * (there - here);
        return (mcv_quantity){place + (level - here) / slope,
                              sqrt(noise / pow(slope * step, 2) + shape * shape / 12)};
    }
    return (mcv_quantity){NAN, NAN};
}

/* The pixels within a reach of a place on the normal, and the parabola through them. Levels are
 * shares of the step. */
typedef struct nearby {
    double count, variance; /* of one pixel, in the mean */
    double level, slope,
        share; /* in the place: the parabola's, and how much of a pixel's variance its level has */
    double misfit; /* the variance about the parabola over that of the noise */
} nearby;

/* False where the parabola knows the level no better than one pixel in the place would. */
static bool look_near(const mcv_edge_patch *p, const mcv_edge_line *l, double place, double reach,
                      nearby *n) {
    const double cosine = 1 / sqrt(1 + l->slope * l->slope), step = l->right.value - l->left.value;
    double s[5] = {0}, r[3] = {0}, squares = 0;
    *n = (nearby){0};
    for (size_t row = 0; row < p->rows; ++row) {
        const double middle = mcv_edge_line_column(l, (double)row + 0.5) - 0.5,
                     last = middle + (place + reach) / cosine;
        for (double column = fmax(0, ceil(middle + (place - reach) / cosine));
             column <= last && column < (double)p->columns; ++column) {
            const double t = ((column - middle) * cosine - place) / reach,
                         level = (mcv_patch_value(p, (size_t)column, row) - l->left.value) / step;
            const double powers[5] = {1, t, t * t, t * t * t, t * t * t * t};
            for (int k = 0; k < 5; ++k) s[k] += powers[k];
            for (int k = 0; k < 3; ++k) r[k] += powers[k] * level;
            squares += level * level;
            n->variance += mcv_patch_variance(p, (size_t)column, row) / (step * step);
        }
    }
    n->count = s[0];
    n->variance /= n->count;
    /* The inverse of the normal equations. */
    const double i00 = s[2] * s[4] - s[3] * s[3], i01 = s[2] * s[3] - s[1] * s[4],
                 i02 = s[1] * s[3] - s[2] * s[2], i11 = s[0] * s[4] - s[2] * s[2],
                 i12 = s[1] * s[2] - s[0] * s[3], i22 = s[0] * s[2] - s[1] * s[1];
    const double determinant = s[0] * i00 + s[1] * i01 + s[2] * i02;
    const double linear = (i01 * r[0] + i11 * r[1] + i12 * r[2]) / determinant,
                 bend = (i02 * r[0] + i12 * r[1] + i22 * r[2]) / determinant;
    n->level = (i00 * r[0] + i01 * r[1] + i02 * r[2]) / determinant;
    n->slope = linear / reach;
    n->share = i00 / determinant;
    n->misfit = n->count > 3 ? (squares - n->level * r[0] - linear * r[1] - bend * r[2]) /
                                   ((n->count - 3) * n->variance)
                             : 1;
    return n->share > 0 && n->share <= 1;
}

/*
 * Bins are too wide for the bends that a sharp edge has at its foot. A parabola through the pixels
 * right around the crossing follows a round foot. A bend within its reach h shifts the crossing by
 * up to 0.02 h. h is so short that this is a fifth of the effect 1.5 σ/√(2hM) of the noise σ of M
 * pixels per pixel of the normal, but holds 8 pixels, or 6 where they are sparse. If the parabola
 * misses these by clearly more than their noise, the misfit is the uncertainty (Birge's ratio).
 */
static mcv_quantity refine(const mcv_edge_patch *p, const mcv_edge_line *l, double target,
                           mcv_quantity rough) {
    enum { ROUNDS = 6 };
    const double bin = 1.0 / MCV_ESF_PER_PIXEL, most = 2 * bin;
    mcv_quantity found = rough;
    for (int round = 0; round < ROUNDS; ++round) {
        nearby here;
        if (!look_near(p, l, found.value, bin, &here) || !(here.slope > 0)) return rough;
        const double density = here.count / (2 * bin), noise = sqrt(here.variance) / here.slope;
        const double least = fmax(3 / density, fmin(4 / density, 0.5 * bin));
        double reach = cbrt(pow(15 * noise, 2) / (2 * density));
        const bool bound = reach < least;
        reach = fmax(reach, least);
        while (reach < most && !look_near(p, l, found.value, reach, &here)) reach *= 1.25;
        if (reach >= most && !look_near(p, l, found.value, most, &here)) return rough;
        if (!(here.slope > 0)) return rough;
        const double clearly = 1 + sqrt(2 / fmax(1, here.count - 3)),
                     misfit = bound && here.misfit > clearly ? here.misfit : 1;
        found = (mcv_quantity){found.value + (target - here.level) / here.slope,
                               sqrt(here.share * here.variance * misfit) / here.slope};
        if (fabs(found.value - rough.value) > 2 * bin) return rough; /* noise leads it away */
    }
    return found;
}

bool mcv_edge_find_width(const mcv_edge_patch *p, const mcv_edge_line *l, mcv_quantity *width) {
    mcv_edge_bins b;
    if (!mcv_edge_fill_bins(p, l, &b)) return false;
    const mcv_quantity low = refine(p, l, 0.1, crossing(&b, l, 0.1)),
                       high = refine(p, l, 0.9, crossing(&b, l, 0.9));
    *width = (mcv_quantity){high.value - low.value, hypot(low.uncertainty, high.uncertainty)};
    mcv_edge_bins_free(&b);
    return isfinite(width->value);
}
