/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The film: sums of the samples' values per pixel, channel and replicate, in double on the host. R replicates are
 * independent scrambles of the same Sobol' points; the standard error comes from the spread of their means (R - 1 degrees
 * of freedom), because the variance inside a pixel is meaningless with low-discrepancy samples.
 *
 * Sums are taken over a fixed binary tree of the sample index, so that any schedule, slice size and split into aligned
 * power-of-two ranges gives the same bits: the device sums blocks, mcv_film_add adds the blocks of one round pairwise.
 */
#ifndef MCVISI_HOST_FILM_FILM_H
#define MCVISI_HOST_FILM_FILM_H

#include "mcvisi/mcvisi.h"

typedef struct mcv_film {
    uint32_t width, height, channels, replicates;
    uint64_t samples; /* per replicate and pixel, so far */
    double *sums;     /* [replicate][channel][row][column] */
} mcv_film;

/* Zeroed. Fails with a sentence that says how much memory it would take. */
mcv_result mcv_film_new(mcv_film *film, uint32_t width, uint32_t height, uint32_t channels, uint32_t replicates, mcv_error *error);
void mcv_film_free(mcv_film *film);

/* a += b, for the aligned sample range that follows a's. Fails where sizes differ. */
mcv_result mcv_film_merge(mcv_film *a, const mcv_film *b, mcv_error *error);

/* A plane of floats per channel, as written to files: [channel][row][column]. */
typedef struct mcv_image {
    uint32_t width, height, channels;
    float *pixels;
} mcv_image;
mcv_result mcv_image_new(mcv_image *image, uint32_t width, uint32_t height, uint32_t channels, mcv_error *error);
void mcv_image_free(mcv_image *image);

/* The mean over samples and replicates, and its standard error (NaN with fewer than two replicates). Both images are made here; error_image
 * may be NULL. */
mcv_result mcv_film_develop(const mcv_film *film, mcv_image *mean, mcv_image *error_image, mcv_error *error);

/* √(mean over pixels and channels of SE²) / mean of the image: what --error compares with. Infinite for a black image with an error. */
double mcv_film_relative_error(const mcv_film *film);

#endif
