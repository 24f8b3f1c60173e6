/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/channel.h"

#include <math.h>

static mcv_result begin(uint64_t chosen, const char *path, const mcv_image *image, mcv_image *out,
                        mcv_error *error) {
    if (chosen > image->channels && chosen > 1)
        return mcv_fail(error, MCV_USAGE, "%s has %u channel%s: leave out --channel", path,
                        image->channels, image->channels > 1 ? "s" : "");
    return mcv_image_new(out, image->width, image->height, 1, error);
}

/* Sums over the channels of a pixel that were chosen. */
typedef struct sums {
    double values, squares, count;
} sums;

static sums sums_at(uint64_t chosen, const mcv_image *image, size_t pixel) {
    const size_t plane = (size_t)image->width * image->height;
    sums s = {0};
    for (uint32_t c = 0; c < image->channels; ++c) {
        const double value = image->pixels[c * plane + pixel];
        if (chosen != 0 && chosen - 1 != c) continue;
        s.values += value;
        s.squares += value * value;
        ++s.count;
    }
    return s;
}

mcv_result mcv_choose_channel(uint64_t chosen, const char *path, const mcv_image *image,
                              mcv_image *out, mcv_error *error) {
    MCV_TRY(begin(chosen, path, image, out, error));
    for (size_t i = 0; i < (size_t)image->width * image->height; ++i) {
        const sums s = sums_at(chosen, image, i);
        out->pixels[i] = (float)(s.values / s.count);
    }
    return MCV_OK;
}

mcv_result mcv_choose_errors(uint64_t chosen, const char *path, const mcv_image *errors,
                             const mcv_image *render, double shared, mcv_image *out,
                             mcv_error *error) {
    MCV_TRY(begin(chosen, path, errors, out, error));
    for (size_t i = 0; i < (size_t)errors->width * errors->height; ++i) {
        const sums s = sums_at(chosen, errors, i);
        double variance = s.squares;
        if (render) {
            const sums r = sums_at(chosen, render, i);
            variance += shared * (r.values * r.values - r.squares);
        }
        out->pixels[i] = (float)(sqrt(fmax(0, variance)) / s.count);
    }
    return MCV_OK;
}
