/* SPDX-License-Identifier: Apache-2.0 */
/* What `mcvisi detect` does. */
#ifndef MCVISI_HOST_VERBS_DETECT_H
#define MCVISI_HOST_VERBS_DETECT_H

#include "analysis/detect.h"
#include "io/exr.h"
#include "options/command.h"
#include "scene/scene.h"
#include "verbs/report.h"

/* What was found, and with which camera. */
typedef struct mcv_detected {
    mcv_detection detection;
    mcv_camera camera;
    mcv_image sigmas; /* |difference| in deviations of the noise; owned */
    mcv_image truth;  /* share of each pixel that sees a defect; owned, or empty */
    char *setup;      /* HTML: the rig from the side; owned, or NULL */
    char lens[128];   /* what blurs, in words */
    bool same_seed, same_sampling;
    double light_paths[2]; /* a sample of each picture; NaN: not told */
    double step;           /* of a parameter between the pictures [SI]; 0: not told */
} mcv_detected;

/* Of two pictures of light with all their replicates; the paths are for messages. After failure
 * nothing is owned. */
mcv_result mcv_detect_pictures(const mcv_command *command, const mcv_exr *with,
                               const char *with_path, const mcv_exr *without,
                               const char *without_path, mcv_detected *detected, mcv_error *error);

/* Whether one picture is known to have more light paths than the other: a render's own pilot
 * decides how many there are. */
bool mcv_detect_lights_differ(const mcv_detected *detected);

void mcv_detected_free(mcv_detected *detected);

/* detect_truth.c: looks through the scene of --rig, where there is one; writes --truth. */
mcv_result mcv_detect_look(const mcv_command *command, mcv_detected *detected, mcv_error *error);
void mcv_detect_report_truth(const mcv_command *command, const mcv_detected *detected,
                             mcv_report *report);

/* What --html shows. */
typedef struct mcv_detect_view {
    const mcv_command *command;
    const mcv_detected *detected;
    const mcv_exr *with, *without;
    const char *with_path, *without_path;
} mcv_detect_view;

/* detect_page.c: writes the page. */
mcv_result mcv_detect_write_page(const char *path, const mcv_detect_view *view, mcv_error *error);

/* The set-up from the side as HTML, to be freed; NULL without memory. */
char *mcv_detect_draw(const mcv_scene *scene, uint32_t sensor);

/* Writes the mask of --output. */
mcv_result mcv_detect_save(const mcv_command *command, const mcv_detected *detected,
                           mcv_error *error);

void mcv_detect_report(const mcv_command *command, const mcv_detected *detected,
                       mcv_report *report);

#endif
