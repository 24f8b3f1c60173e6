/* SPDX-License-Identifier: Apache-2.0 */
/* Grey values by the options of `mcvisi camera`, which `mcvisi render` takes as well. */
#ifndef MCVISI_HOST_CLI_CAMERA_H
#define MCVISI_HOST_CLI_CAMERA_H

#include "analysis/read_out.h"
#include "cli/command.h"

#include <limits.h>

/* Checks whether the options make a camera whose grey values can be written to the file `grey`. */
mcv_result mcv_camera_check(const mcv_command *command, const char *grey, mcv_error *error);

/* Reads the OpenEXR file `image`, writes `grey`, warns of saturated values and, on request, reports
 * the exposure. */
mcv_result mcv_camera_write(const mcv_command *command, const char *image, const char *grey,
                            bool told, mcv_error *error);

/* The 8-bit preview beside grey values that viewers show black or cannot show: all except OpenEXR,
 * and PNG and TIFF of 8 bits. */
bool mcv_camera_preview(const mcv_command *command, const char *grey, char preview[PATH_MAX]);

/* The camera of the options. The texts belong to the command. */
mcv_camera_settings mcv_camera_settings_of(const mcv_command *command);

#endif
