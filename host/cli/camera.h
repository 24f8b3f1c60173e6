/* SPDX-License-Identifier: Apache-2.0 */
/* Grey values by the options of `mcvisi camera`, which `mcvisi render` takes as well. */
#ifndef MCVISI_HOST_CLI_CAMERA_H
#define MCVISI_HOST_CLI_CAMERA_H

#include "analysis/camera.h"
#include "analysis/region.h"
#include "cli/options.h"
#include "io/exr.h"

#include <limits.h>

/* Do the options make a camera whose grey values can be written to the file `grey`? */
mcv_result mcv_camera_check(const mcv_command *command, const char *grey, mcv_error *error);

/* Reads the OpenEXR file `image`, writes `grey`, warns where values are saturated and, where asked
 * to, tells of the exposure. */
mcv_result mcv_camera_write(const mcv_command *command, const char *image, const char *grey,
                            bool told, mcv_error *error);

/* The 8-bit preview beside grey values that viewers show as black or not at all: all but OpenEXR
 * and PNG and TIFF of 8 bits. */
bool mcv_camera_preview(const mcv_command *command, const char *grey, char preview[PATH_MAX]);

/* Is there an exposure among the options? */
bool mcv_camera_wanted(const mcv_command *command);

/* The same without files: do the options make a camera, and is the scale of light given once? */
mcv_result mcv_camera_check_options(const mcv_command *command, mcv_error *error);

/*
 * What the camera reads from an image of light as mcv_exr_read gives it, with the header's
 * attributes; the light is blurred in place, which correlates its errors. `path` is for messages.
 * The caller frees the exposure.
 */
mcv_result mcv_camera_read_out(const mcv_command *command, const char *path, mcv_exr *exr,
                               mcv_exposure *exposure, mcv_correlation *correlation,
                               mcv_error *error);

#endif
