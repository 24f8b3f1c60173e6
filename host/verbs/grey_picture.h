/* SPDX-License-Identifier: Apache-2.0 */
/* The grey values that a camera reads from an image of light, as a picture and as files. */
#ifndef MCVISI_HOST_VERBS_GREY_PICTURE_H
#define MCVISI_HOST_VERBS_GREY_PICTURE_H

#include "analysis/read_out.h"
#include "options/command.h"
#include "verbs/report.h"

/* The camera of the options. The texts belong to the command. */
mcv_camera_settings mcv_camera_settings_of(const mcv_command *command);

/*
 * The picture of grey values: the parts image, error and, where it is known, the render's error,
 * with the header of the light and that of the camera. The light is blurred in place. What is left
 * in `out` are numbers only; its exposure has no images any more. `path` is for messages. On
 * failure nothing is owned. mcv_grey_expose takes settings that are not the command's.
 */
mcv_result mcv_grey_make(const mcv_command *command, const char *path, mcv_exr *light,
                         mcv_read_out *out, mcv_exr *grey, mcv_error *error);
mcv_result mcv_grey_expose(const mcv_camera_settings *settings, const char *path, mcv_exr *light,
                           mcv_read_out *out, mcv_exr *grey, mcv_error *error);

/* Writes the values alone into .png, .tif or .npy, of 8 bits for a camera of 8 bits or fewer, else
 * of 16; the header tells the camera model and the render's error. */
mcv_result mcv_grey_write(const char *path, const mcv_exr *grey, mcv_error *error);

/* Are the values grey values? */
bool mcv_grey_is(const mcv_exr *exr);

/* grey_report.c: tells of the exposure; `preview` may be NULL. Warns where values are saturated. */
void mcv_grey_report(const mcv_command *command, const char *path, const char *preview,
                     const mcv_exr *grey, const mcv_read_out *out, mcv_report *report);
void mcv_grey_warn(const char *path, const mcv_exr *grey, const mcv_read_out *out,
                   mcv_report *report);

#endif
