/* SPDX-License-Identifier: Apache-2.0 */
/* Adaptive sampling: how many samples each tile of 8 x 8 pixels takes, so that the whole image has the least error. */
#ifndef MCVISI_HOST_RENDER_ADAPTIVE_H
#define MCVISI_HOST_RENDER_ADAPTIVE_H

#include "film/film.h"

enum { MCV_LOWEST_LEVEL = -3, MCV_HIGHEST_LEVEL = 3 };

/*
 * levels[i]: tile i (mcv_film_tiles) is to take 2^levels[i] times the samples, from the variances that the film's replicates show. A
 * tile's variance falls as samples^-fall: the sum over the image is least for samples in proportion to variance^(1/(1 + fall)), which are
 * rounded to powers of two. The mean over all pixels is at most `budget` times the samples of level 0. *gain: how many times
 * the samples that all tiles would need alike for the same sum.
 */
mcv_result mcv_allocate_samples(const mcv_film *film, double fall, double budget, signed char *levels, double *gain, mcv_error *error);

#endif
