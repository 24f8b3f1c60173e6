/* SPDX-License-Identifier: Apache-2.0 */
/* One region of two pictures: its means with their errors, and the test whether they differ. */
#include "analysis/compare_unit.h"

#include <math.h>

/*
 * Without replicate values, a tile's p-value is near uniform where its noise is nearly normal: they
 * are counted from 25 effective samples of light per replicate on (relative variance at most 1/25,
 * as of a Poisson count of 25).
 */
enum { MIN_EVENTS = 25 };

static void channel_range(const mcv_region *region, uint32_t channels, uint32_t *first,
                          uint32_t *last) {
    *first = region->channel == MCV_ALL_CHANNELS ? 0 : region->channel;
    *last = region->channel == MCV_ALL_CHANNELS ? channels : region->channel + 1;
}

/* The mean over the region in every replicate, then their spread: correlations between pixels are
 * in it. */
static void view_film(const mcv_film *film, const mcv_region *region, mcv_region_view *v) {
    uint32_t first, last;
    channel_range(region, film->channels, &first, &last);
    v->pixels = (uint64_t)region->width * region->height * (last - first);
    for (uint32_t r = 0; r < film->replicates; ++r) {
        double sum = 0;
        for (uint32_t c = first; c < last; ++c) {
            for (uint32_t row = region->row; row < region->row + region->height; ++row) {
                const size_t line =
                    (((size_t)r * film->channels + c) * film->height + row) * film->width;
                for (uint32_t column = 0; column < region->width; ++column)
                    sum += film->sums[line + region->column + column];
            }
        }
        v->means[r] = sum / ((double)v->pixels * (double)film->samples);
    }
    v->estimate = mcv_estimate_replicates(v->means, film->replicates);
}

/* Standard errors of a pixel's channels add up (full correlation), variances of pixels do
 * (independence). */
static void view_measured(const mcv_measured *m, const mcv_measured *other,
                          const mcv_region *region, mcv_region_view *v) {
    const mcv_image *image = m->mean;
    const size_t plane = (size_t)image->width * image->height;
    uint32_t first, last;
    channel_range(region, image->channels, &first, &last);
    double mean = 0, variance = 0, squares = 0;
    v->pixels = 0;
    for (uint32_t row = region->row; row < region->row + region->height; ++row) {
        for (uint32_t column = region->column; column < region->column + region->width; ++column) {
            const size_t at = (size_t)row * image->width + column;
            double value = 0, deviation = 0, check = 0;
            for (uint32_t c = first; c < last; ++c) {
                value += image->pixels[c * plane + at];
                deviation += m->error->pixels[c * plane + at];
                check += (double)other->mean->pixels[c * plane + at] +
                         other->error->pixels[c * plane + at];
            }
            if (!isfinite(value + deviation + check)) continue;
            mean += value;
            variance += deviation * deviation;
            squares += deviation * deviation * deviation * deviation;
            v->pixels += last - first;
        }
    }
    const double count = (double)v->pixels;
    v->estimate =
        (mcv_estimate){.mean = mean / count,
                       .variance = variance / (count * count),
                       .freedom = squares > 0 ? variance * variance / squares * (m->replicates - 1)
                                              : m->replicates - 1};
}

void mcv_region_measure(const mcv_compared *s, const mcv_compared *other, const mcv_region *region,
                        mcv_region_view *v) {
    if (s->film) {
        view_film(s->film, region, v);
    } else {
        view_measured(s->measured, other->measured, region, v);
    }
}

mcv_estimate mcv_estimate_subtract(const mcv_estimate *x, const mcv_estimate *y) {
    const double a = x->variance, b = y->variance;
    return (mcv_estimate){.mean = x->mean - y->mean,
                          .variance = a + b,
                          .freedom = a + b > 0 ? (a + b) * (a + b) /
                                                     (a * a / x->freedom + b * b / y->freedom)
                                               : x->freedom + y->freedom};
}

double mcv_welch_two_sided(const mcv_estimate *difference) {
    return mcv_student_two_sided(difference->mean / sqrt(difference->variance),
                                 difference->freedom);
}

/*
 * The two-sided rank test of the replicate means; -1 where all are equal. Values closer than
 * rounding are ties, which are ordered as speaks least for a difference: no chance order of them
 * has a larger p-value, so that ties cannot raise a false alarm.
 */
static double rank_test(const mcv_compared *x, const mcv_region_view *vx, const mcv_compared *y,
                        const mcv_region_view *vy, double rounding) {
    uint32_t greater = 0, ties = 0;
    for (uint32_t i = 0; i < x->replicates; ++i) {
        for (uint32_t j = 0; j < y->replicates; ++j) {
            const double difference = vx->means[i] - vy->means[j];
            ties += fabs(difference) <= rounding;
            greater += difference > rounding;
        }
    }
    const uint32_t pairs = x->replicates * y->replicates;
    if (ties == pairs) return -1;
    const uint32_t less = pairs - greater - ties;
    const uint32_t smaller = (greater < less ? greater : less) + ties;
    return 2 * smaller >= pairs ? 1 : fmin(1, 2 * x->rank_table[smaller]);
}

static bool enough_events(const mcv_compared *s, const mcv_estimate *e) {
    return e->variance * s->replicates * MIN_EVENTS <= e->mean * e->mean;
}

mcv_unit_outcome mcv_compare_unit(const mcv_compared *x, const mcv_compared *y,
                                  const mcv_region *region) {
    mcv_region_view vx, vy;
    mcv_region_measure(x, y, region, &vx);
    mcv_region_measure(y, x, region, &vy);
    if (vx.pixels == 0) return (mcv_unit_outcome){0};
    const double rounding =
        MCV_COMPARE_ROUNDING * fmax(fabs(vx.estimate.mean), fabs(vy.estimate.mean));
    const mcv_estimate difference = mcv_estimate_subtract(&vx.estimate, &vy.estimate);
    const bool equal = fabs(difference.mean) <= rounding;
    const bool constant = difference.variance == 0;
    mcv_unit_outcome o = {.seen = true, .variance = difference.variance};
    if (x->film) {
        o.uniform = rank_test(x, &vx, y, &vy, rounding);
        if (o.uniform < 0) return o;
        o.counts = true;
        o.p = equal ? 1 : fmax(o.uniform, constant ? 0 : mcv_welch_two_sided(&difference));
    } else {
        if (constant && equal) return o;
        /* Without noise all that is known of the replicates is that each side has one value. */
        o.uniform = constant ? 2 * x->rank_table[0] : mcv_welch_two_sided(&difference);
        o.counts = sqrt(difference.variance) > rounding && enough_events(x, &vx.estimate) &&
                   enough_events(y, &vy.estimate);
        /*
         * The replicates of one pixel may be equal by chance, as at an edge where each counts the
         * same samples: their deviation is no estimate then. This p-value is the least that a rank
         * test of as many replicates can have.
         */
        const bool pixel = region->width == 1 && region->height == 1;
        o.p = equal ? 1 : fmax(o.uniform, pixel ? 2 * x->rank_table[0] : 0);
    }
    o.tested = true;
    return o;
}
