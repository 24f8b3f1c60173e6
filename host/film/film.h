/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The film: sums of the samples' values per pixel, channel and replicate, in double on the host. R
 * replicates are independent scrambles of the same Sobol' points; the standard error comes from the
 * spread of their means (R - 1 degrees of freedom), because the variance inside a pixel is
 * meaningless with low-discrepancy samples.
 *
 * Sums are taken over a fixed binary tree of the sample index, so that any schedule, slice size and
 * split into aligned power-of-two ranges gives the same bits: the device sums blocks, mcv_film_add
 * adds the blocks of one round pairwise.
 */
#ifndef MCVISI_HOST_FILM_FILM_H
#define MCVISI_HOST_FILM_FILM_H

#include "core/error.h"

typedef struct mcv_film {
    uint32_t width, height, channels, replicates;
    uint64_t samples; /* per replicate and pixel, so far */
    double *sums;     /* [replicate][channel][row][column] */
    /* Where light paths add to the film, else NULL: the sums' parts, of which splats are exact in
     * any order. */
    double *camera_sums;
    uint64_t *splats;
    double splat_value; /* of one unit */
    /* Adaptive sampling, else NULL: a pixel has 2^levels[row][column] times the samples, and what
     * they bring counts so much less. */
    signed char *levels;
} mcv_film;

enum { MCV_MAX_REPLICATES = 64 };

/* Zeroed. Fails for a size of 0 or more replicates than there can be, or with a sentence that says
 * how much memory it would take. */
mcv_result mcv_film_new(mcv_film *film, uint32_t width, uint32_t height, uint32_t channels,
                        uint32_t replicates, mcv_error *error);
void mcv_film_free(mcv_film *film);

/* Samples per pixel over all replicates: of the pixel at a place; their mean over the pixels. */
double mcv_film_samples_at(const mcv_film *film, uint32_t column, uint32_t row);
double mcv_film_mean_samples(const mcv_film *film);

/*
 * The sum of `count` (a power of two) values at values[i * stride], over the fixed binary tree: the
 * sums of aligned halves are the halves of the sum, so blocks summed apart and then added give the
 * same bits.
 */
double mcv_pairwise_sum(const double *values, size_t count, size_t stride);

/*
 * a += b, for the aligned sample range that follows a's. Fails where sizes differ, or where a is
 * neither empty nor holds as many samples as b (the tree would be another one).
 */
mcv_result mcv_film_merge(mcv_film *a, const mcv_film *b, mcv_error *error);

/* Before the first samples: the film is to have splats, too. */
mcv_result mcv_film_take_splats(mcv_film *film, double value, mcv_error *error);

/* Adds a round of camera paths, laid out as the sums; film->splats are those of all samples so far
 * already. */
void mcv_film_add(mcv_film *film, const double *round, uint64_t samples);

/*
 * A plane of floats per channel, as written to files: [channel][row][column]. `description` is the
 * text beside them in the file, of PNG under MCV_CAMERA_MODEL_KEY (scene/camera_model.h), of TIFF
 * its ImageDescription; owned, NULL for none.
 */
typedef struct mcv_image {
    uint32_t width, height, channels;
    float *pixels;
    char *description;
} mcv_image;
mcv_result mcv_image_new(mcv_image *image, uint32_t width, uint32_t height, uint32_t channels,
                         mcv_error *error);
void mcv_image_free(mcv_image *image);

/* A mean that is known with an error: the variance of the mean (not of one value) and its degrees
 * of freedom. */
typedef struct mcv_estimate {
    double mean, variance, freedom;
} mcv_estimate;

/* The estimate from independent replicates' means: R - 1 degrees of freedom; the variance of a
 * single one is NaN. */
mcv_estimate mcv_estimate_replicates(const double *means, uint32_t replicates);

/* The mean over samples and replicates, and its standard error (NaN with fewer than two
 * replicates). Both images are made here; error_image may be NULL. */
mcv_result mcv_film_develop(const mcv_film *film, mcv_image *mean, mcv_image *error_image,
                            mcv_error *error);

/* The mean over pixels and channels. NaN for a film without samples. */
double mcv_film_mean(const mcv_film *film);

/* √(mean over pixels and channels of SE²) / mean of the image: what --error compares with. Infinite
 * for a black image with an error, 0 for one without; NaN for a single replicate or no samples. */
double mcv_film_relative_error(const mcv_film *film);

/* How many values its sums hold: those of all replicates. */
size_t mcv_film_values(const mcv_film *film);

#endif
