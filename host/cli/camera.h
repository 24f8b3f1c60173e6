/* SPDX-License-Identifier: Apache-2.0 */
/* Grey values by the options of `mcvisi camera`, which `mcvisi render` takes as well. */
#ifndef MCVISI_HOST_CLI_CAMERA_H
#define MCVISI_HOST_CLI_CAMERA_H

#include "verbs/grey_picture.h"

#include <limits.h>

/* Checks whether the options make a camera whose grey values can be written to the file `grey`. */
mcv_result mcv_camera_check(const mcv_command *command, const char *grey, mcv_error *error);

/* Reads the OpenEXR file `image`, writes `path`, warns where values are saturated and, where asked
 * to, tells of the exposure. */
mcv_result mcv_camera_write(const mcv_command *command, const char *image, const char *path,
                            bool told, mcv_error *error);

/* The 8-bit preview beside grey values that viewers show black or cannot show: all except OpenEXR,
 * and PNG and TIFF of 8 bits. */
bool mcv_camera_preview(const mcv_command *command, const char *grey, char preview[PATH_MAX]);

#endif
