/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The film: sums of the samples' values per pixel, channel and replicate, in double on the host. R
 * replicates are independent scrambles of the same Sobol' points. The standard error comes from the
 * spread of their means (R - 1 degrees of freedom); the variance within a replicate has no meaning
 * for low-discrepancy samples.
 *
 * Sums are taken over a fixed binary tree of the sample index. Any schedule, slice size and split
 * into aligned power-of-two ranges therefore gives the same bits. The device sums blocks;
 * mcv_film_add adds the blocks of one round pairwise.
 */
#ifndef MCVISI_HOST_FILM_FILM_H
#define MCVISI_HOST_FILM_FILM_H

#include "core/error.h"

typedef struct mcv_film {
    uint32_t width, height, channels, replicates;
    uint64_t samples; /* per replicate and pixel, so far */
    double *sums;     /* [replicate][channel][row][column] */
    /* With light paths, else NULL: the camera paths' part of the sums. Splats are integers, so
     * their order does not matter. */
    double *camera_sums;
    uint64_t *splats;
    double splat_value; /* value of one splat unit */
    /* Adaptive sampling, else NULL: a pixel has 2^levels[row][column] times the samples, each with
     * the inverse weight. */
    signed char *levels;
} mcv_film;

enum { MCV_MAX_REPLICATES = 64 };

/* Makes an empty film. Fails for a size of 0, for too many replicates, or without memory; the
 * sentence then says how much is needed. */
mcv_result mcv_film_new(mcv_film *film, uint32_t width, uint32_t height, uint32_t channels,
                        uint32_t replicates, mcv_error *error);
void mcv_film_free(mcv_film *film);

/* Samples over all replicates of one pixel, and their mean over the pixels. */
double mcv_film_samples_at(const mcv_film *film, uint32_t column, uint32_t row);
double mcv_film_mean_samples(const mcv_film *film);

/*
 * The sum of `count` (a power of two) values at values[i * stride], over the fixed binary tree. The
 * sums of aligned halves are the halves of the sum, so blocks that are summed separately and then
 * added give the same bits.
 */
double mcv_pairwise_sum(const double *values, size_t count, size_t stride);

/*
 * a += b, for the aligned sample range after a's. Fails if sizes differ, or if a is not empty and
 * has another number of samples than b, because the tree would differ.
 */
mcv_result mcv_film_merge(mcv_film *a, const mcv_film *b, mcv_error *error);

/* Prepares the film for splats. To be called before the first samples. */
mcv_result mcv_film_take_splats(mcv_film *film, double value, mcv_error *error);

/* Adds a round of camera paths, laid out as the sums. film->splats holds those of all samples so
 * far. */
void mcv_film_add(mcv_film *film, const double *round, uint64_t samples);

/*
 * Planes of floats as in files: [channel][row][column]. `description` is the text in the file: of a
 * PNG the entry MCV_CAMERA_MODEL_KEY (scene/camera_model.h), of a TIFF the ImageDescription. It is
 * owned; NULL: none.
 */
typedef struct mcv_image {
    uint32_t width, height, channels;
    float *pixels;
    char *description;
} mcv_image;
mcv_result mcv_image_new(mcv_image *image, uint32_t width, uint32_t height, uint32_t channels,
                         mcv_error *error);
void mcv_image_free(mcv_image *image);

/* A mean with its uncertainty: the variance of the mean (not of one value) and its degrees of
 * freedom. */
typedef struct mcv_estimate {
    double mean, variance, freedom;
} mcv_estimate;

/* The estimate from the means of independent replicates, with R - 1 degrees of freedom. The
 * variance of a single one is NaN. */
mcv_estimate mcv_estimate_replicates(const double *means, uint32_t replicates);

/* Makes the image of means over samples and replicates, and that of their standard errors (NaN with
 * fewer than two replicates). error_image may be NULL. */
mcv_result mcv_film_develop(const mcv_film *film, mcv_image *mean, mcv_image *error_image,
                            mcv_error *error);

/*
 * How the channels share the errors of mcv_film_develop: the covariance of pairs of channels over
 * the product of their standard errors, both summed over pixels and pairs. Channels come from the
 * same paths: 1 for light of one colour everywhere. 1 for a film of one channel, or without error.
 */
double mcv_film_channel_correlation(const mcv_film *film);

/* The mean over pixels and channels. NaN for a film without samples. */
double mcv_film_mean(const mcv_film *film);

/* √(mean over pixels and channels of SE²) / mean of the image, which --error limits. A black image
 * has infinity with an error and 0 without one. NaN for a single replicate or no samples. */
double mcv_film_relative_error(const mcv_film *film);

/* The same without the MCV_FILM_WORST values of the largest standard error, over the mean of the
 * whole image: what is left where a few pixels hold nearly all of the error, such as the mirror
 * image of a small lamp. */
enum { MCV_FILM_WORST = 16 };
double mcv_film_error_of_rest(const mcv_film *film);

/* The number of values in its sums, over all replicates. */
size_t mcv_film_values(const mcv_film *film);

#endif
