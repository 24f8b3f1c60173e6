/* SPDX-License-Identifier: Apache-2.0 */
/* The files of one rendered sensor: the OpenEXR image with all that a repetition needs, and the
 * preview. */
#ifndef MCVISI_HOST_CLI_PICTURE_H
#define MCVISI_HOST_CLI_PICTURE_H

#include "options/command.h"
#include "io/png.h"
#include "render/render.h"
#include "verbs/render_picture.h"

#include <limits.h>

typedef struct mcv_render_files {
    char exr[PATH_MAX], png[PATH_MAX];
    char grey[PATH_MAX]; /* of --camera, or "" */
    const char *unit;    /* "W/(m^2 sr)" */
} mcv_render_files;

/*
 * Chooses the files of a sensor, which must be writable: SCENE.exr beside the scene or --output,
 * with -SENSOR before the ending if `several` sensors are rendered; the same with .png, or --png;
 * the grey values of --camera.
 */
mcv_result mcv_render_files_plan(const mcv_command *command, const mcv_scene *scene,
                                 uint32_t sensor, bool several, mcv_render_files *picture,
                                 mcv_error *error);

/* Writes the image and the preview, and returns the preview's white level. */
mcv_result mcv_render_files_write(const mcv_render_files *files, const mcv_command *command,
                                  const mcv_scene *scene, uint32_t sensor,
                                  const mcv_render_options *options, const mcv_film *film,
                                  const mcv_render_stats *stats, mcv_preview *preview,
                                  mcv_error *error);

#endif
