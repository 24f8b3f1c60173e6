/* SPDX-License-Identifier: Apache-2.0 */
#include "film/film.h"

#include <math.h>
#include <stdlib.h>

/* a b c d, or 0 if that many elements of the given size cannot be addressed. */
static size_t element_count(uint64_t a, uint64_t b, uint64_t c, uint64_t d, size_t size) {
    uint64_t n = a;
    const uint64_t factors[] = {b, c, d, size};
    for (size_t i = 0; i < 4; ++i) {
        if (__builtin_mul_overflow(n, factors[i], &n)) return 0;
    }
    return n <= PTRDIFF_MAX ? (size_t)(n / size) : 0;
}

mcv_result mcv_film_new(mcv_film *film, uint32_t width, uint32_t height, uint32_t channels,
                        uint32_t replicates, mcv_error *error) {
    *film = (mcv_film){0};
    if (replicates > MCV_MAX_REPLICATES) {
        return mcv_fail(error, MCV_USAGE, "%u replicates are too many: at most %d are possible",
                        replicates, MCV_MAX_REPLICATES);
    }
    if (width == 0 || height == 0 || channels == 0 || replicates == 0) {
        return mcv_fail(
            error, MCV_USAGE,
            "a film of %u x %u pixels, %u channels and %u replicates is not possible: each must "
            "be at least 1",
            width, height, channels, replicates);
    }
    *film = (mcv_film){
        .width = width, .height = height, .channels = channels, .replicates = replicates};
    const size_t count = element_count(width, height, channels, replicates, sizeof *film->sums);
    if (count > 0) film->sums = calloc(count, sizeof *film->sums);
    if (!film->sums) {
        *film = (mcv_film){0};
        return mcv_fail(
            error, MCV_FAILED,
            "a film of %u x %u pixels, %u channels and %u replicates needs %.3g GB of memory, "
            "more than is free",
            width, height, channels, replicates, 8e-9 * width * height * channels * replicates);
    }
    return MCV_OK;
}

void mcv_film_free(mcv_film *film) {
    free(film->sums);
    free(film->camera_sums);
    free(film->splats);
    free(film->levels);
    *film = (mcv_film){0};
}

double mcv_film_samples_at(const mcv_film *film, uint32_t column, uint32_t row) {
    const int level = film->levels ? film->levels[(size_t)row * film->width + column] : 0;
    return ldexp((double)film->samples * film->replicates, level);
}

double mcv_film_mean_samples(const mcv_film *film) {
    double sum = 0;
    for (uint32_t row = 0; row < film->height; ++row)
        for (uint32_t column = 0; column < film->width; ++column)
            sum += mcv_film_samples_at(film, column, row);
    return sum / ((double)film->width * film->height);
}

double mcv_pairwise_sum(const double *values, size_t count, size_t stride) {
    if (count == 1) return values[0];
    const size_t half = count / 2;
    return mcv_pairwise_sum(values, half, stride) +
           mcv_pairwise_sum(values + half * stride, half, stride);
}

mcv_result mcv_film_merge(mcv_film *a, const mcv_film *b, mcv_error *error) {
    if (a->width != b->width || a->height != b->height || a->channels != b->channels ||
        a->replicates != b->replicates) {
        return mcv_fail(error, MCV_FAILED,
                        "films of %u x %u pixels, %u channels, %u replicates and of %u x %u, %u, "
                        "%u cannot be merged: sizes must be the same",
                        a->width, a->height, a->channels, a->replicates, b->width, b->height,
                        b->channels, b->replicates);
    }
    if (a->levels || b->levels)
        return mcv_fail(
            error, MCV_FAILED,
            "films of adaptive sampling cannot be merged: their pixels differ in samples");
    if (a->samples != 0 && a->samples != b->samples) {
        return mcv_fail(
            error, MCV_FAILED,
            "films of %llu and %llu samples cannot be merged: both must hold the same number",
            (unsigned long long)a->samples, (unsigned long long)b->samples);
    }
    const size_t count = (size_t)a->width * a->height * a->channels * a->replicates;
    if (a->samples == 0 && b->splats && !a->splats)
        MCV_TRY(mcv_film_take_splats(a, b->splat_value, error));
    if (!a->splats != !b->splats || (a->splats && a->splat_value != b->splat_value))
        return mcv_fail(
            error, MCV_FAILED,
            "films with different light paths cannot be merged: both must have the same");
    for (size_t i = 0; a->splats && i < count; ++i) a->splats[i] += b->splats[i];
    mcv_film_add(a, b->splats ? b->camera_sums : b->sums, b->samples);
    return MCV_OK;
}

mcv_result mcv_film_take_splats(mcv_film *film, double value, mcv_error *error) {
    const size_t count = (size_t)film->width * film->height * film->channels * film->replicates;
    film->camera_sums = calloc(count, sizeof *film->camera_sums);
    film->splats = calloc(count, sizeof *film->splats);
    film->splat_value = value;
    if (film->camera_sums && film->splats) return MCV_OK;
    return mcv_fail(
        error, MCV_FAILED,
        "a film of %u x %u pixels needs %.3g GB of memory more for light paths, more than is "
        "free",
        film->width, film->height, 16e-9 * (double)count);
}

void mcv_film_add(mcv_film *film, const double *round, uint64_t samples) {
    const size_t count = (size_t)film->width * film->height * film->channels * film->replicates;
    double *sums = film->splats ? film->camera_sums : film->sums;
    for (size_t i = 0; i < count; ++i) sums[i] = film->samples == 0 ? round[i] : sums[i] + round[i];
    for (size_t i = 0; film->splats && i < count; ++i)
        film->sums[i] = sums[i] + film->splat_value * (double)film->splats[i];
    film->samples += samples;
}

mcv_result mcv_image_new(mcv_image *image, uint32_t width, uint32_t height, uint32_t channels,
                         mcv_error *error) {
    *image = (mcv_image){0};
    if (width == 0 || height == 0 || channels == 0) {
        return mcv_fail(
            error, MCV_USAGE,
            "an image of %u x %u pixels and %u channels is not possible: each must be at least 1",
            width, height, channels);
    }
    *image = (mcv_image){.width = width, .height = height, .channels = channels};
    const size_t count = element_count(width, height, channels, 1, sizeof *image->pixels);
    if (count > 0) image->pixels = calloc(count, sizeof *image->pixels);
    if (!image->pixels) {
        *image = (mcv_image){0};
        return mcv_fail(
            error, MCV_FAILED,
            "an image of %u x %u pixels and %u channels needs %.3g GB of memory, more than is "
            "free",
            width, height, channels, 4e-9 * width * height * channels);
    }
    return MCV_OK;
}

void mcv_image_free(mcv_image *image) {
    free(image->pixels);
    free(image->description);
    *image = (mcv_image){0};
}

mcv_estimate mcv_estimate_replicates(const double *means, uint32_t replicates) {
    double mean = 0, squares = 0;
    for (uint32_t r = 0; r < replicates; ++r) mean += means[r];
    mean /= replicates;
    for (uint32_t r = 0; r < replicates; ++r) squares += (means[r] - mean) * (means[r] - mean);
    const double freedom = (double)replicates - 1;
    return (mcv_estimate){.mean = mean,
                          .variance = freedom > 0 ? squares / freedom / replicates : NAN,
                          .freedom = freedom};
}

/* The estimate at one place of the film, counted from its first channel's first pixel. */
static mcv_estimate estimate_at(const mcv_film *film, size_t at) {
    const size_t stride = (size_t)film->width * film->height * film->channels;
    double means[MCV_MAX_REPLICATES];
    for (uint32_t r = 0; r < film->replicates; ++r)
        means[r] = film->sums[r * stride + at] / (double)film->samples;
    return mcv_estimate_replicates(means, film->replicates);
}

mcv_result mcv_film_develop(const mcv_film *film, mcv_image *mean, mcv_image *error_image,
                            mcv_error *error) {
    *mean = (mcv_image){0};
    if (error_image) *error_image = (mcv_image){0};
    if (film->samples == 0)
        return mcv_fail(error, MCV_FAILED, "the film has no samples: nothing was rendered");
    MCV_TRY(mcv_image_new(mean, film->width, film->height, film->channels, error));
    if (error_image &&
        mcv_image_new(error_image, film->width, film->height, film->channels, error) != MCV_OK) {
        mcv_image_free(mean);
        return MCV_FAILED;
    }
    const size_t count = (size_t)film->width * film->height * film->channels;
    for (size_t i = 0; i < count; ++i) {
        const mcv_estimate estimate = estimate_at(film, i);
        mean->pixels[i] = (float)estimate.mean;
        if (error_image) error_image->pixels[i] = (float)sqrt(estimate.variance);
    }
    return MCV_OK;
}

/* Adds a pixel's covariances of pairs of channels, and the products of their deviations; both of
 * sums over the replicates, whose number cancels out. */
static void add_pairs(const mcv_film *film, size_t pixel, double *covariance, double *product) {
    const size_t plane = (size_t)film->width * film->height;
    double sum = 0, squares = 0, roots = 0;
    double shared[MCV_MAX_REPLICATES] = {0};
    for (uint32_t c = 0; c < film->channels; ++c) {
        double mean = 0, own = 0;
        for (uint32_t r = 0; r < film->replicates; ++r)
            mean += film->sums[(r * film->channels + c) * plane + pixel] / film->replicates;
        for (uint32_t r = 0; r < film->replicates; ++r) {
            const double off = film->sums[(r * film->channels + c) * plane + pixel] - mean;
            shared[r] += off;
            own += off * off;
        }
        squares += own;
        roots += sqrt(own);
    }
    for (uint32_t r = 0; r < film->replicates; ++r) sum += shared[r] * shared[r];
    *covariance += sum - squares;
    *product += roots * roots - squares;
}

double mcv_film_channel_correlation(const mcv_film *film) {
    double covariance = 0, product = 0;
    for (size_t i = 0; film->channels > 1 && i < (size_t)film->width * film->height; ++i)
        add_pairs(film, i, &covariance, &product);
    /* Rounding may put it a little beyond. */
    return product > 0 ? fmax(-1, fmin(covariance / product, 1)) : 1;
}

double mcv_film_mean(const mcv_film *film) {
    const size_t count = (size_t)film->width * film->height * film->channels * film->replicates;
    double sum = 0;
    for (size_t i = 0; i < count; ++i) sum += film->sums[i];
    return sum / (double)count / (double)film->samples;
}

double mcv_film_relative_error(const mcv_film *film) {
    const size_t count = (size_t)film->width * film->height * film->channels;
    double mean = 0, variance = 0;
    for (size_t i = 0; i < count; ++i) {
        const mcv_estimate estimate = estimate_at(film, i);
        mean += estimate.mean;
        variance += estimate.variance;
    }
    if (variance == 0) return 0;
    return sqrt(variance / (double)count) / fabs(mean / (double)count);
}

/* Puts a variance among the largest, which ascend; returns what falls out. */
static double keep_largest(double largest[MCV_FILM_WORST], double variance) {
    int i = 0;
    const double out = fmin(largest[0], variance);
    for (; i + 1 < MCV_FILM_WORST && largest[i + 1] < variance; ++i) largest[i] = largest[i + 1];
    if (variance > out) largest[i] = variance;
    return out;
}

double mcv_film_error_of_rest(const mcv_film *film) {
    const size_t count = (size_t)film->width * film->height * film->channels;
    double largest[MCV_FILM_WORST] = {0}, mean = 0, variance = 0;
    for (size_t i = 0; i < count; ++i) {
        const mcv_estimate estimate = estimate_at(film, i);
        mean += estimate.mean;
        variance += isnan(estimate.variance) ? NAN : keep_largest(largest, estimate.variance);
    }
    if (variance == 0) return 0;
    return sqrt(variance / (double)count) / fabs(mean / (double)count);
}

size_t mcv_film_values(const mcv_film *film) {
    return (size_t)film->width * film->height * film->channels * film->replicates;
}
