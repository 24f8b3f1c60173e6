/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/compare_unit.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* The unit test: all pixels and tiles, channel by channel. */
static void test_units(const mcv_compared *x, const mcv_compared *y, uint32_t width,
                       uint32_t height, uint32_t channels, mcv_comparison *c) {
    double smallest = 1;
    for (uint32_t size = 1; size <= MCV_COMPARE_TILE; size *= MCV_COMPARE_TILE) {
        for (uint32_t channel = 0; channel < channels; ++channel) {
            for (uint32_t row = 0; row < height; row += size) {
                for (uint32_t column = 0; column < width; column += size) {
                    const mcv_region region = {channel, column, row,
                                               width - column < size ? width - column : size,
                                               height - row < size ? height - row : size};
                    const mcv_unit_outcome o = mcv_compare_unit(x, y, &region);
                    c->units += o.tested;
                    if (o.tested && o.p < smallest) {
                        smallest = o.p;
                        c->worst = region;
                    }
                }
            }
        }
    }
    c->p_unit = smallest == 1 ? 1 : mcv_sidak(smallest, (double)c->units);
}

/* KS and count: one p-value per tile, over all channels (they share their paths and are no
 * independent cases). */
static mcv_result test_tiles(const mcv_compared *x, const mcv_compared *y, uint32_t width,
                             uint32_t height, mcv_comparison *c, mcv_error *error) {
    const uint64_t most =
        (uint64_t)(width / MCV_COMPARE_TILE + 1) * (height / MCV_COMPARE_TILE + 1);
    double *p = malloc(most * sizeof *p);
    if (!p)
        return mcv_fail(error, MCV_FAILED, "no memory to compare %llu tiles",
                        (unsigned long long)most);
    double variance = 0;
    uint64_t seen = 0;
    for (uint32_t row = 0; row < height; row += MCV_COMPARE_TILE) {
        for (uint32_t column = 0; column < width; column += MCV_COMPARE_TILE) {
            const mcv_region region = {
                MCV_ALL_CHANNELS, column, row,
                width - column < MCV_COMPARE_TILE ? width - column : MCV_COMPARE_TILE,
                height - row < MCV_COMPARE_TILE ? height - row : MCV_COMPARE_TILE};
            const mcv_unit_outcome o = mcv_compare_unit(x, y, &region);
            variance += o.variance;
            seen += o.seen;
            if (!o.counts) continue;
            p[c->tiles++] = o.uniform;
            c->small_tiles += o.uniform < 0.01;
            c->histogram[o.uniform < 1 ? (int)(o.uniform * MCV_COMPARE_BINS)
                                       : MCV_COMPARE_BINS - 1] += 1;
        }
    }
    c->p_tiles = mcv_smaller_than_uniform(p, c->tiles);
    c->p_count = mcv_binomial_upper(c->small_tiles, c->tiles, 0.01);
    free(p);
    /* Seen in 9 of 10 cases: above the threshold by the t that is exceeded downwards in one of ten.
     */
    const double freedom = x->replicates + y->replicates - 2;
    const double level =
        c->units > 0 ? mcv_sidak(MCV_COMPARE_ALPHA, 1 / (double)c->units) : MCV_COMPARE_ALPHA;
    c->detectable_tile = sqrt(variance / (double)seen) * (mcv_student_quantile(level, freedom) +
                                                          mcv_student_quantile(0.2, freedom));
    return MCV_OK;
}

static void test_image(const mcv_compared *x, const mcv_compared *y, uint32_t width,
                       uint32_t height, uint32_t channels, mcv_comparison *c) {
    mcv_region_view vx, vy;
    double smallest = 1;
    for (uint32_t channel = 0; channel < channels; ++channel) {
        const mcv_region whole = {channel, 0, 0, width, height};
        mcv_region_measure(x, y, &whole, &vx);
        mcv_region_measure(y, x, &whole, &vy);
        if (vx.pixels == 0) continue;
        const mcv_estimate difference = mcv_estimate_subtract(&vx.estimate, &vy.estimate);
        const double rounding =
            MCV_COMPARE_ROUNDING * fmax(fabs(vx.estimate.mean), fabs(vy.estimate.mean));
        /* Without any variance a difference is certain: welch() is 0. */
        if (fabs(difference.mean) > rounding)
            smallest = fmin(smallest, mcv_welch_two_sided(&difference));
    }
    c->p_image = smallest == 1 ? 1 : mcv_sidak(smallest, channels);

    const mcv_region whole = {MCV_ALL_CHANNELS, 0, 0, width, height};
    mcv_region_measure(x, y, &whole, &vx);
    mcv_region_measure(y, x, &whole, &vy);
    const mcv_estimate difference = mcv_estimate_subtract(&vx.estimate, &vy.estimate);
    const double mean = (fabs(vx.estimate.mean) + fabs(vy.estimate.mean)) / 2;
    c->mean_x = vx.estimate.mean;
    c->mean_y = vy.estimate.mean;
    if (vx.pixels == 0 || mean == 0) return;
    const double level = mcv_sidak(MCV_COMPARE_ALPHA, 1.0 / channels);
    c->detectable = sqrt(difference.variance) / mean *
                    (mcv_student_quantile(level, difference.freedom) +
                     mcv_student_quantile(0.2, difference.freedom));
    c->detectable_tile /= mean;
}

static void judge(const mcv_compared *x, const mcv_compared *y, mcv_comparison *c) {
    c->different = true;
    if (c->p_image < MCV_COMPARE_ALPHA) {
        snprintf(c->reason, sizeof c->reason,
                 "the image means %.6g and %.6g differ by %.3g %% (p = %.2g)", c->mean_x, c->mean_y,
                 100 * (c->mean_y / c->mean_x - 1), c->p_image);
    } else if (c->p_unit < MCV_COMPARE_ALPHA) {
        mcv_region_view vx, vy;
        mcv_region_measure(x, y, &c->worst, &vx);
        mcv_region_measure(y, x, &c->worst, &vy);
        snprintf(c->reason, sizeof c->reason,
                 "the %u x %u pixels from column %u, row %u on, channel %u, are %.6g and %.6g on "
                 "average (p = %.2g among %llu units)",
                 c->worst.width, c->worst.height, c->worst.column, c->worst.row, c->worst.channel,
                 vx.estimate.mean, vy.estimate.mean, c->p_unit, (unsigned long long)c->units);
    } else if (c->p_tiles < MCV_COMPARE_ALPHA || c->p_count < MCV_COMPARE_ALPHA) {
        snprintf(
            c->reason, sizeof c->reason,
            "%llu of %llu tiles have a p-value below 0.01 (p = %.2g), and their distribution is "
            "not uniform (Kolmogorov-Smirnov p = %.2g)",
            (unsigned long long)c->small_tiles, (unsigned long long)c->tiles, c->p_count,
            c->p_tiles);
    } else {
        c->different = false;
        snprintf(c->reason, sizeof c->reason,
                 "no difference beyond the noise; a difference of %.2g %% of the image mean, or of "
                 "%.2g %% of it in one tile, would have been detected",
                 100 * c->detectable, 100 * c->detectable_tile);
    }
}

static mcv_result compare(mcv_compared *x, mcv_compared *y, uint32_t width, uint32_t height,
                          uint32_t channels, mcv_comparison *c, mcv_error *error) {
    if (x->replicates < 2 || y->replicates < 2 || x->replicates > MCV_MAX_REPLICATES ||
        y->replicates > MCV_MAX_REPLICATES) {
        return mcv_fail(
            error, MCV_BAD_INPUT,
            "renders of %u and %u replicates cannot be compared: 2 to %d are needed, 16 are "
            "recommended",
            x->replicates, y->replicates, MCV_MAX_REPLICATES);
    }
    double *rank_table = mcv_mann_whitney(x->replicates, y->replicates);
    if (!rank_table)
        return mcv_fail(error, MCV_FAILED, "no memory to compare %u and %u replicates",
                        x->replicates, y->replicates);
    x->rank_table = y->rank_table = rank_table;
    test_units(x, y, width, height, channels, c);
    const mcv_result result = test_tiles(x, y, width, height, c, error);
    if (result == MCV_OK) {
        test_image(x, y, width, height, channels, c);
        judge(x, y, c);
    }
    free(rank_table);
    return result;
}

static mcv_result sizes_differ(uint32_t w1, uint32_t h1, uint32_t c1, uint32_t w2, uint32_t h2,
                               uint32_t c2, mcv_error *error) {
    return mcv_fail(error, MCV_BAD_INPUT,
                    "pictures of %u x %u pixels, %u channels and of %u x %u, %u cannot be "
                    "compared: sizes must be the same",
                    w1, h1, c1, w2, h2, c2);
}

mcv_result mcv_compare_films(const mcv_film *x, const mcv_film *y, mcv_comparison *comparison,
                             mcv_error *error) {
    *comparison = (mcv_comparison){0};
    if (x->width != y->width || x->height != y->height || x->channels != y->channels) {
        return sizes_differ(x->width, x->height, x->channels, y->width, y->height, y->channels,
                            error);
    }
    if (x->samples == 0 || y->samples == 0)
        return mcv_fail(error, MCV_FAILED,
                        "a film without samples cannot be compared: nothing was rendered");
    mcv_compared sx = {.film = x, .replicates = x->replicates},
                 sy = {.film = y, .replicates = y->replicates};
    return compare(&sx, &sy, x->width, x->height, x->channels, comparison, error);
}

static bool same_size(const mcv_image *a, const mcv_image *b) {
    return a->width == b->width && a->height == b->height && a->channels == b->channels;
}

/* Where one of the images alone is finite, they differ whatever the noise. */
static bool differ_in_finiteness(const mcv_image *x, const mcv_image *y, mcv_comparison *c) {
    const size_t plane = (size_t)x->width * x->height;
    for (size_t i = 0; i < plane * x->channels; ++i) {
        if (!isfinite(x->pixels[i]) == !isfinite(y->pixels[i])) continue;
        c->worst = (mcv_region){(uint32_t)(i / plane), (uint32_t)(i % x->width),
                                (uint32_t)(i % plane / x->width), 1, 1};
        c->different = true;
        snprintf(
            c->reason, sizeof c->reason,
            "the pixel in column %u, row %u, channel %u, is %g and %g: only one of them is finite",
            c->worst.column, c->worst.row, c->worst.channel, x->pixels[i], y->pixels[i]);
        return true;
    }
    return false;
}

static mcv_result check_sizes(const mcv_measured *x, const mcv_measured *y, mcv_error *error) {
    const mcv_image *const others[] = {x->error, y->mean, y->error};
    for (int i = 0; i < 3; ++i) {
        if (same_size(x->mean, others[i])) continue;
        return sizes_differ(x->mean->width, x->mean->height, x->mean->channels, others[i]->width,
                            others[i]->height, others[i]->channels, error);
    }
    return MCV_OK;
}

mcv_result mcv_compare_images(const mcv_measured *x, const mcv_measured *y,
                              mcv_comparison *comparison, mcv_error *error) {
    *comparison = (mcv_comparison){0};
    MCV_TRY(check_sizes(x, y, error));
    if (differ_in_finiteness(x->mean, y->mean, comparison)) return MCV_OK;
    mcv_compared sx = {.measured = x, .replicates = x->replicates},
                 sy = {.measured = y, .replicates = y->replicates};
    return compare(&sx, &sy, x->mean->width, x->mean->height, x->mean->channels, comparison, error);
}

mcv_result mcv_compare_difference(const mcv_measured *x, const mcv_measured *y,
                                  mcv_image *difference, mcv_error *error) {
    MCV_TRY(check_sizes(x, y, error));
    MCV_TRY(mcv_image_new(difference, x->mean->width, x->mean->height, 1, error));
    const size_t plane = (size_t)difference->width * difference->height;
    for (size_t i = 0; i < plane; ++i) {
        double value = 0, error_x = 0, error_y = 0;
        for (size_t at = i; at < plane * x->mean->channels; at += plane) {
            value += (double)x->mean->pixels[at] - (double)y->mean->pixels[at];
            error_x += x->error->pixels[at];
            error_y += y->error->pixels[at];
        }
        difference->pixels[i] = value == 0 ? 0 : (float)(value / hypot(error_x, error_y));
    }
    return MCV_OK;
}
