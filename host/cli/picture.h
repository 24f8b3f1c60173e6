/* SPDX-License-Identifier: Apache-2.0 */
/* The files of one rendered sensor: the OpenEXR image with all that a repetition needs, and the
 * preview. */
#ifndef MCVISI_HOST_CLI_PICTURE_H
#define MCVISI_HOST_CLI_PICTURE_H

#include "cli/command.h"
#include "io/picture_header.h"
#include "io/png.h"
#include "render/render.h"

#include <limits.h>

/* Name of the part with a replicate's means. */
#define MCV_PICTURE_REPLICATE "replicate %u"

typedef struct mcv_picture {
    char exr[PATH_MAX], png[PATH_MAX];
    char grey[PATH_MAX];         /* of --camera, or "" */
    const char *quantity, *unit; /* "radiance", "W/(m^2 sr)" */
} mcv_picture;

/*
 * Chooses the files of a sensor, which must be writable: SCENE.exr beside the scene or --output,
 * with -SENSOR before the ending if `several` sensors are rendered; the same with .png, or --png;
 * the grey values of --camera.
 */
mcv_result mcv_picture_plan(const mcv_command *command, const mcv_scene *scene, uint32_t sensor,
                            bool several, mcv_picture *picture, mcv_error *error);

/* Writes the image and the preview, and returns the preview's white level. */
mcv_result mcv_picture_write(const mcv_picture *picture, const mcv_command *command,
                             const mcv_scene *scene, uint32_t sensor,
                             const mcv_render_options *options, const mcv_film *film,
                             const mcv_render_stats *stats, mcv_preview *preview, mcv_error *error);

/* The options of a render from the command line: --spp, --error, --time …; 1 % or 60 s if none of
 * them is given (render.c). */
mcv_result mcv_render_options_read(const mcv_command *command, mcv_render_options *options,
                                   mcv_error *error);

#endif
