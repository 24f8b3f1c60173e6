/* SPDX-License-Identifier: Apache-2.0 */
/* Adaptive sampling: the number of samples of each pixel, chosen so that the error of the whole
 * image is least. */
#ifndef MCVISI_HOST_RENDER_ADAPTIVE_H
#define MCVISI_HOST_RENDER_ADAPTIVE_H

#include "film/film.h"

enum { MCV_LOWEST_LEVEL = -3, MCV_HIGHEST_LEVEL = 3 };

/*
 * Writes levels[row][column]: the pixel gets 2^level times the samples. The variances come from the
 * replicates (at least four) of a pilot render. A pixel's variance falls as samples^-fall. The sum
 * over the image is least for samples in proportion to variance^(1/(1 + fall)); they are rounded to
 * powers of two. Their mean is at most `budget` times the samples of level 0.
 *
 * The variance of a pixel is estimated from its surroundings. Their size is the one with which one
 * half of the replicates best predicts the other half. *gain is the predicted ratio of the sums
 * without and with adaptive sampling, for equal numbers of samples (with a fall of 1).
 */
mcv_result mcv_allocate_samples(const mcv_film *look, double fall, double budget,
                                signed char *levels, double *gain, mcv_error *error);

#endif
