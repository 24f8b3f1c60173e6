/* SPDX-License-Identifier: Apache-2.0 */
/* Adaptive sampling: how many samples each pixel takes, so that the whole image has the least
 * error. */
#ifndef MCVISI_HOST_RENDER_ADAPTIVE_H
#define MCVISI_HOST_RENDER_ADAPTIVE_H

#include "film/film.h"

enum { MCV_LOWEST_LEVEL = -3, MCV_HIGHEST_LEVEL = 3 };

/*
 * levels[row][column]: the pixel is to take 2^level times the samples, from the variance that a
 * first look's replicates (four or more) show. A pixel's variance falls as samples^-fall: the sum
 * over the image is least for samples in proportion to variance^(1/(1 + fall)), which are rounded
 * to powers of two. The mean over all pixels is at most `budget` times the samples of level 0. A
 * pixel's variance is known from its surroundings, as large as tell best of one half of the
 * replicates what the other half shows. *gain: how many times smaller the sum would be for the same
 * samples, as the halves foretell it for each other (with a fall of 1).
 */
mcv_result mcv_allocate_samples(const mcv_film *look, double fall, double budget,
                                signed char *levels, double *gain, mcv_error *error);

#endif
