/* SPDX-License-Identifier: Apache-2.0 */
/* Grey values by the options of `mcvisi camera`, which `mcvisi render` takes as well. */
#ifndef MCVISI_HOST_CLI_CAMERA_H
#define MCVISI_HOST_CLI_CAMERA_H

#include "cli/options.h"

/* Do the options make a camera whose grey values can be written to the file `grey`? */
mcv_result mcv_camera_check(const mcv_command *command, const char *grey, mcv_error *error);

/* Reads the OpenEXR file `image`, writes `grey`, warns where values are saturated and, where asked to, tells of the exposure. */
mcv_result mcv_camera_write(const mcv_command *command, const char *image, const char *grey, bool told, mcv_error *error);

#endif
