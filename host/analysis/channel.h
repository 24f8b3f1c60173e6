/* SPDX-License-Identifier: Apache-2.0 */
/* One channel of a colour image. */
#ifndef MCVISI_HOST_ANALYSIS_CHANNEL_H
#define MCVISI_HOST_ANALYSIS_CHANNEL_H

#include "film/film.h"

/* One channel of an image (0: the mean of all); of deviations, those of the mean of independent
 * channels. `path` is for messages. */
mcv_result mcv_choose_channel(uint64_t chosen, const char *path, const mcv_image *image,
                              bool deviations, mcv_image *out, mcv_error *error);

#endif
