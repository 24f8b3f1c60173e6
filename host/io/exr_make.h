/* SPDX-License-Identifier: Apache-2.0 */
/* Images as mcv_exr_read gives them, made in memory. */
#ifndef MCVISI_HOST_IO_EXR_MAKE_H
#define MCVISI_HOST_IO_EXR_MAKE_H

#include "io/exr.h"

/* Adds a part at the end. The image changes owners, also on failure. channel_names are copied;
 * NULL: "Y" for one channel, "R" "G" "B" for three, else "0", "1" … */
mcv_result mcv_exr_add_part(mcv_exr *exr, const char *name, mcv_image image,
                            const char *const *channel_names, mcv_error *error);

/* Sets attributes, which are copied: those of the same names are replaced. */
mcv_result mcv_exr_set_attributes(mcv_exr *exr, const mcv_attribute *attributes, uint32_t count,
                                  mcv_error *error);

/* A copy of the image, its pixels included. On failure `copy` is empty. */
mcv_result mcv_exr_copy(const mcv_exr *exr, mcv_exr *copy, mcv_error *error);

/* A copy of one image, its description included. */
mcv_result mcv_image_copy(const mcv_image *image, mcv_image *copy, mcv_error *error);

#endif
