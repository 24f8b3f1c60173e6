/* SPDX-License-Identifier: Apache-2.0 */
/* The files of rendered sensors: the OpenEXR image with all that a repetition needs, the preview,
 * and the grey values of --camera. */
#ifndef MCVISI_HOST_VERBS_RENDER_FILES_H
#define MCVISI_HOST_VERBS_RENDER_FILES_H

#include "io/png.h"
#include "verbs/render_picture.h"
#include "verbs/report.h"

#include <limits.h>

typedef struct mcv_render_files {
    char exr[PATH_MAX], png[PATH_MAX];
    char grey[PATH_MAX]; /* of --camera, or "" */
    char film[PATH_MAX]; /* the checkpoint, or "" */
    char part[PATH_MAX]; /* of --film, or "" */
} mcv_render_files;

/* What --resolution and --lasers make of a sensor's film and the scene's light. */
mcv_result mcv_render_resize(const mcv_command *command, mcv_scene *scene, uint32_t sensor,
                             mcv_error *error);

/* Which sensors the options ask for, with the pixels of --resolution; MCV_USAGE for an exposure
 * without --camera. */
mcv_result mcv_render_sensors(const mcv_command *command, mcv_scene *scene, uint32_t *first,
                              uint32_t *count, mcv_error *error);

/*
 * Chooses the files of a sensor, which must be writable: SCENE.exr beside the scene or --output,
 * with -SENSOR before the ending if `several` sensors are rendered; the same with .png, or --png;
 * the grey values of --camera.
 */
mcv_result mcv_render_files_plan(const mcv_command *command, const mcv_scene *scene,
                                 uint32_t sensor, bool several, mcv_render_files *files,
                                 mcv_error *error);

/* Plans the files of all, before rendering: a missing folder must be reported at once, not hours
 * later. */
mcv_result mcv_render_files_check(const mcv_command *command, const mcv_scene *scene,
                                  uint32_t first, uint32_t count, mcv_error *error);

/* Whether a finished image lies under the name of this one: an interrupted one must not replace it.
 */
bool mcv_render_files_finished(const mcv_render_files *files);

/*
 * Whether the image of the render with this hash lies under its name, finished, and with --film its
 * part. Its preview is written then: the one that lies there may be an early one.
 */
bool mcv_render_files_kept(const mcv_render_files *files, const char hash[MCV_RENDER_HASH],
                           const char *unit);

/* Other names for the files of an interrupted render, with -interrupted before their endings. */
mcv_result mcv_render_files_rename(const mcv_render_files *files, mcv_render_files *others,
                                   mcv_error *error);

/* Writes the image and the preview, and returns the preview's white level. */
mcv_result mcv_render_files_write(const mcv_render_files *files, const mcv_rendered *rendered,
                                  mcv_preview *preview, mcv_error *error);

/* Writes the grey values of the image that was written, and tells of them; in JSON only what is
 * odd. */
mcv_result mcv_render_files_expose(const mcv_command *command, const mcv_render_files *files,
                                   mcv_report *report, mcv_error *error);

#endif
