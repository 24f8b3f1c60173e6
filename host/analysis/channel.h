/* SPDX-License-Identifier: Apache-2.0 */
/* One channel of a colour image. */
#ifndef MCVISI_HOST_ANALYSIS_CHANNEL_H
#define MCVISI_HOST_ANALYSIS_CHANNEL_H

#include "film/film.h"

/* One channel of an image (0: the mean of all). `path` is for messages. */
mcv_result mcv_choose_channel(uint64_t chosen, const char *path, const mcv_image *image,
                              mcv_image *out, mcv_error *error);

/*
 * The standard error of the same. `render`: the part of the errors that is the render's own, or
 * NULL. All channels of a pixel come from the same paths, so that the render's errors of a pair of
 * them have a correlation, `shared` (mcv_film_channel_correlation). The other part of the errors is
 * independent.
 */
mcv_result mcv_choose_errors(uint64_t chosen, const char *path, const mcv_image *errors,
                             const mcv_image *render, double shared, mcv_image *out,
                             mcv_error *error);

#endif
