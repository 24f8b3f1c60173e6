/* SPDX-License-Identifier: Apache-2.0 */
#include "render/adaptive.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Lower bound of a pixel's variance, as a share of the mean variance: a pilot of few samples misses
 * rare light. */
static const double LEAST_VARIANCE = 0.02;

enum { LARGEST_RADIUS = 8, BISECTIONS = 20 };

/* Arrays with one value per pixel. */
typedef struct plan {
    uint32_t width, height;
    double *halves[2]; /* variance among the even and among the odd replicates */
    double *all;       /* the mean of both */
    double *shares;    /* shares of the samples */
    double *columns;   /* sums over the window, for one row */
} plan;

static size_t pixels_of(const plan *p) { return (size_t)p->width * p->height; }

/* The variance between every second replicate, starting with `first`; the mean over the
 * channels. */
static void measure_variance(const mcv_film *look, uint32_t first, double *variances) {
    const size_t pixels = (size_t)look->width * look->height, stride = pixels * look->channels;
    for (size_t i = 0; i < pixels; ++i) {
        variances[i] = 0;
        for (uint32_t c = 0; c < look->channels; ++c) {
            double values[MCV_MAX_REPLICATES];
            uint32_t count = 0;
            for (uint32_t r = first; r < look->replicates; r += 2)
                values[count++] = look->sums[r * stride + c * pixels + i];
            variances[i] +=
                mcv_estimate_replicates(values, count).variance * count / look->channels;
        }
    }
}

/* Replaces each value of a row by the mean over 2 radius + 1 pixels, fewer at its ends. */
static void blur_row(double *row, uint32_t width, uint32_t radius) {
    double before[LARGEST_RADIUS + 1] = {
        0}; /* ring buffer of original values that are already overwritten */
    double sum = 0;
    for (uint32_t x = 0; x < radius && x < width; ++x) sum += row[x];
    for (uint32_t x = 0; x < width; ++x) {
        const uint32_t first = x > radius ? x - radius : 0,
                       last = x + radius < width ? x + radius : width - 1;
        if (x + radius < width) sum += row[x + radius];
        if (x > radius) sum -= before[(x - radius - 1) % (radius + 1)];
        before[x % (radius + 1)] = row[x];
        row[x] = sum / (last - first + 1);
    }
}

/* Means of `from` over squares around each pixel, or the squares of the means of its roots. */
static void blur(const plan *p, const double *from, uint32_t radius, bool of_roots, double *to) {
    const uint32_t width = p->width, height = p->height;
    memset(p->columns, 0, width * sizeof *p->columns);
    for (uint32_t y = 0; y < height + radius; ++y) {
        const double *entering = y < height ? from + (size_t)y * width : NULL;
        const double *leaving = y > 2 * radius ? from + (size_t)(y - 2 * radius - 1) * width : NULL;
        for (uint32_t x = 0; entering && x < width; ++x)
            p->columns[x] += of_roots ? sqrt(entering[x]) : entering[x];
        for (uint32_t x = 0; leaving && x < width; ++x)
            p->columns[x] -= of_roots ? sqrt(leaving[x]) : leaving[x];
        if (y < radius) continue;
        const uint32_t first = y > 2 * radius ? y - 2 * radius : 0,
                       last = y < height ? y : height - 1;
        double *row = to + (size_t)(y - radius) * width;
        for (uint32_t x = 0; x < width; ++x) row[x] = p->columns[x] / (last - first + 1);
        blur_row(row, width, radius);
        for (uint32_t x = 0; of_roots && x < width; ++x) row[x] *= row[x];
    }
}

static double mean_of(const double *values, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; ++i) sum += values[i];
    return sum / (double)count;
}

/* The share of the samples that each pixel would get from the variance of its surroundings; the
 * mean is 1. */
static void share_samples(const plan *p, const double *variances, uint32_t radius, bool of_roots,
                          double fall) {
    const size_t count = pixels_of(p);
    blur(p, variances, radius, of_roots, p->shares);
    const double least = LEAST_VARIANCE * mean_of(p->shares, count);
    for (size_t i = 0; i < count; ++i) {
        const double variance = p->shares[i] > least ? p->shares[i] : least;
        p->shares[i] = fall == 1 ? sqrt(variance) : pow(variance, 1 / (1 + fall));
    }
    const double mean = mean_of(p->shares, count);
    for (size_t i = 0; i < count; ++i) p->shares[i] /= mean;
}

/* Predicts the variance of one half of the replicates with the samples that the other half asks
 * for; the mean of both ways. */
static double foretell(const plan *p, uint32_t radius, bool of_roots) {
    double left = 0;
    for (int half = 0; half < 2; ++half) {
        share_samples(p, p->halves[half], radius, of_roots, 1);
        for (size_t i = 0; i < pixels_of(p); ++i) left += p->halves[!half][i] / p->shares[i];
    }
    return left / (2 * (double)pixels_of(p));
}

/* 2^level of a share: powers of two to the nearest, by their ratio. */
static double round_share(double share) {
    static const double least = 1.0 / (1 << -MCV_LOWEST_LEVEL), most = 1 << MCV_HIGHEST_LEVEL;
    double power = least;
    for (double next = 2 * least; next <= most; next *= 2)
        power = share > M_SQRT1_2 * next ? next : power;
    return power;
}

/* The largest factor of the shares, at most 2, that keeps the mean within the budget. */
static double fitting_factor(const plan *p, double budget) {
    double low = 0, high = 2;
    for (int turn = 0; turn < BISECTIONS; ++turn) {
        const double factor = 0.5 * (low + high);
        double samples = 0;
        for (size_t i = 0; i < pixels_of(p); ++i) samples += round_share(factor * p->shares[i]);
        if (samples <= budget * (double)pixels_of(p))
            low = factor;
        else
            high = factor;
    }
    return low;
}

static void allocate(const plan *p, double fall, double budget, signed char *levels, double *gain) {
    const size_t count = pixels_of(p);
    const double alike = mean_of(p->all, count);
    uint32_t best = 1;
    bool best_of_roots = false;
    double least = INFINITY;
    if (!(alike > 0)) return;
    /* Means of roots are robust against few bright samples; means of variances preserve thin
     * structures. */
    for (uint32_t radius = 1; radius <= LARGEST_RADIUS; radius *= 2) {
        for (int of_roots = 0; of_roots < 2; ++of_roots) {
            const double left = foretell(p, radius, of_roots);
            if (left < least) {
                least = left;
                best = radius;
                best_of_roots = of_roots;
            }
        }
    }
    share_samples(p, p->all, best, best_of_roots, fall);
    /* Dithering: similar pixels must not all cross a power of two together. */
    for (size_t i = 0; i < count; ++i)
        p->shares[i] *= 1 + 0x1p-39 * (double)((uint32_t)i * 0x9e3779b9u);
    const double factor = fitting_factor(p, budget);
    for (size_t i = 0; i < count; ++i)
        levels[i] = (signed char)ilogb(round_share(factor * p->shares[i]));
    *gain = alike / least;
}

mcv_result mcv_allocate_samples(const mcv_film *look, double fall, double budget,
                                signed char *levels, double *gain, mcv_error *error) {
    const size_t count = (size_t)look->width * look->height;
    plan p = {.width = look->width, .height = look->height};
    double **planes[] = {&p.halves[0], &p.halves[1], &p.all, &p.shares};
    bool enough = (p.columns = malloc(look->width * sizeof *p.columns)) != NULL;
    *gain = 1;
    memset(levels, 0, count);
    for (int i = 0; i < 4; ++i)
        enough = (*planes[i] = malloc(count * sizeof(double))) != NULL && enough;
    if (enough) {
        for (uint32_t half = 0; half < 2; ++half) measure_variance(look, half, p.halves[half]);
        for (size_t i = 0; i < count; ++i) p.all[i] = 0.5 * (p.halves[0][i] + p.halves[1][i]);
        allocate(&p, fall, budget, levels, gain);
    }
    for (int i = 0; i < 4; ++i) free(*planes[i]);
    free(p.columns);
    return enough ? MCV_OK
                  : mcv_fail(error, MCV_FAILED, "no memory for the samples of %zu pixels", count);
}
