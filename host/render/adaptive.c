/* SPDX-License-Identifier: Apache-2.0 */
#include "render/adaptive.h"

#include <math.h>
#include <stdlib.h>

/* A tile that has met less than its neighbours may have missed what they have met: it takes so much of the mean around it. */
static const double share_of_neighbours = 0.1;

enum { BISECTIONS = 100 };

typedef struct tile {
    double pixels;   /* within the image */
    double variance; /* of a pixel, summed over its channels */
} tile;

static tile measure_tile(const mcv_film *film, uint32_t tile_column, uint32_t tile_row) {
    const size_t pixels = (size_t)film->width * film->height, stride = pixels * film->channels;
    const double *sums = film->splats ? film->camera_sums : film->sums; /* light paths are the same for all tiles */
    tile t = {0, 0};
    for (uint32_t row = 8 * tile_row; row < 8 * tile_row + 8 && row < film->height; ++row) {
        for (uint32_t column = 8 * tile_column; column < 8 * tile_column + 8 && column < film->width; ++column, ++t.pixels) {
            for (uint32_t c = 0; c < film->channels; ++c) {
                const double *values = sums + c * pixels + (size_t)row * film->width + column;
                double means[MCV_MAX_REPLICATES];
                for (uint32_t r = 0; r < film->replicates; ++r) means[r] = values[r * stride] / (double)film->samples;
                t.variance += mcv_estimate_replicates(means, film->replicates).variance;
            }
        }
    }
    t.variance /= t.pixels;
    return t;
}

/* The mean over a tile and those around it. */
static double variance_around(const tile *tiles, uint32_t columns, uint32_t rows, uint32_t column, uint32_t row) {
    double sum = 0, count = 0;
    for (uint32_t y = row > 0 ? row - 1 : 0; y <= row + 1 && y < rows; ++y)
        for (uint32_t x = column > 0 ? column - 1 : 0; x <= column + 1 && x < columns; ++x, ++count) sum += tiles[y * columns + x].variance;
    return sum / count;
}

/* What each tile would take with the exact power: 1 on the average over the pixels. false: no tile has noise. */
static bool share_samples(const mcv_film *film, double fall, tile *tiles, double *shares) {
    const uint32_t columns = (film->width + 7) / 8, rows = (film->height + 7) / 8;
    double sum = 0, pixels = 0;
    for (uint32_t row = 0; row < rows; ++row)
        for (uint32_t column = 0; column < columns; ++column) tiles[row * columns + column] = measure_tile(film, column, row);
    for (uint32_t row = 0; row < rows; ++row) {
        for (uint32_t column = 0; column < columns; ++column) {
            const uint32_t i = row * columns + column;
            const double variance =
                tiles[i].variance + share_of_neighbours * (variance_around(tiles, columns, rows, column, row) - tiles[i].variance);
            shares[i] = pow(variance, 1 / (1 + fall));
            sum += shares[i] * tiles[i].pixels;
            pixels += tiles[i].pixels;
        }
    }
    if (!(sum > 0)) return false;
    for (uint32_t i = 0; i < rows * columns; ++i) shares[i] *= pixels / sum;
    return true;
}

static int level_of(double share) {
    if (!(share > 0)) return MCV_LOWEST_LEVEL;
    return (int)fmin(fmax(nearbyint(log2(share)), MCV_LOWEST_LEVEL), MCV_HIGHEST_LEVEL);
}

/* The largest factor of the shares, at most 2, that keeps the mean within the budget. */
static double fitting_factor(const tile *tiles, const double *shares, size_t count, double budget) {
    double low = 0, high = 2;
    for (int turn = 0; turn < BISECTIONS; ++turn) {
        const double factor = 0.5 * (low + high);
        double samples = 0, pixels = 0;
        for (size_t i = 0; i < count; ++i) {
            samples += ldexp(tiles[i].pixels, level_of(factor * shares[i]));
            pixels += tiles[i].pixels;
        }
        if (samples <= budget * pixels)
            low = factor;
        else
            high = factor;
    }
    return low;
}

mcv_result mcv_allocate_samples(const mcv_film *film, double fall, double budget, signed char *levels, double *gain, mcv_error *error) {
    const size_t count = mcv_film_tiles(film);
    tile *tiles = malloc(count * sizeof *tiles);
    double *shares = malloc(count * sizeof *shares);
    *gain = 1;
    for (size_t i = 0; i < count; ++i) levels[i] = 0;
    if (tiles && shares && share_samples(film, fall, tiles, shares)) {
        double all_alike = 0, left = 0, samples = 0, pixels = 0;
        const double factor = fitting_factor(tiles, shares, count, budget);
        for (size_t i = 0; i < count; ++i) {
            levels[i] = (signed char)level_of(factor * shares[i]);
            samples += ldexp(tiles[i].pixels, levels[i]);
            pixels += tiles[i].pixels;
            all_alike += tiles[i].pixels * tiles[i].variance;
            left += tiles[i].pixels * tiles[i].variance * pow(2, -fall * levels[i]);
        }
        *gain = pow(all_alike / left, 1 / fall) * pixels / samples;
    }
    const bool enough = tiles && shares;
    free(tiles);
    free(shares);
    return enough ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for %zu tiles", count);
}
