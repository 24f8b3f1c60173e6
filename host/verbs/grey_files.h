/* SPDX-License-Identifier: Apache-2.0 */
/* The files of grey values, which `mcvisi camera` and `mcvisi render --camera` write. */
#ifndef MCVISI_HOST_VERBS_GREY_FILES_H
#define MCVISI_HOST_VERBS_GREY_FILES_H

#include "verbs/grey_picture.h"

/* Checks whether the options make a camera whose grey values can be written to the file `grey`. */
mcv_result mcv_grey_check_file(const mcv_command *command, const char *grey, mcv_error *error);

/* Writes the grey values of `light` into the file `path`, with a preview beside values that viewers
 * show black or cannot show: all except OpenEXR, and PNG and TIFF of 8 bits. */
mcv_result mcv_grey_save(const mcv_command *command, const mcv_exr *light, const mcv_exr *grey,
                         const char *path, mcv_error *error);

/* Tells of grey values in a file, and warns where they are saturated. */
void mcv_grey_tell(const mcv_command *command, const char *path, const mcv_exr *grey,
                   const mcv_read_out *out, mcv_report *report);

#endif
