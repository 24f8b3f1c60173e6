/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/contrast.h"

#include <math.h>

static bool is_inside(const mcv_image *image, const mcv_ring *ring, uint32_t column, uint32_t row) {
    if (!ring) return true;
    const double r = hypot((column + 0.5 - 0.5 * image->width) * ring->pitch[0],
                           (row + 0.5 - 0.5 * image->height) * ring->pitch[1]);
    return r >= ring->inner && r <= ring->outer;
}

/* How many values, the sum of (v - from)^power, the largest v and the largest |v - from|. */
typedef struct moments {
    uint64_t count;
    double sum, largest, farthest;
} moments;

static moments sum_powers(const mcv_image *image, const mcv_ring *ring, double from, int power) {
    moments m = {.largest = -INFINITY};
    for (uint32_t row = 0; row < image->height; ++row) {
        for (uint32_t column = 0; column < image->width; ++column) {
            const double value = image->pixels[(size_t)row * image->width + column];
            if (isnan(value) || !is_inside(image, ring, column, row)) continue;
            ++m.count;
            m.sum += power == 1 ? value - from : (value - from) * (value - from);
            m.largest = fmax(m.largest, value);
            m.farthest = fmax(m.farthest, fabs(value - from));
        }
    }
    return m;
}

mcv_spread mcv_image_spread(const mcv_image *image, const mcv_ring *ring) {
    const moments first = sum_powers(image, ring, 0, 1);
    if (first.count == 0) return (mcv_spread){.mean = NAN, .deviation = NAN, .largest = NAN};
    const double mean = first.sum / (double)first.count;
    const moments second = sum_powers(image, ring, mean, 2);
    return (mcv_spread){.count = first.count,
                        .mean = mean,
                        .deviation =
                            first.count > 1 ? sqrt(second.sum / ((double)first.count - 1)) : NAN,
                        .largest = first.largest};
}

double mcv_peak_to_noise(const mcv_image *image, const mcv_ring *region,
                         const mcv_ring *background) {
    const mcv_spread b = mcv_image_spread(image, background);
    return sum_powers(image, region, b.mean, 1).farthest / b.deviation;
}
