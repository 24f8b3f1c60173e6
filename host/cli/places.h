/* SPDX-License-Identifier: Apache-2.0 */
/* The options of `measure` and `sweep` that say where: those in a part's coordinates become pixels
 * of an image. */
#ifndef MCVISI_HOST_CLI_PLACES_H
#define MCVISI_HOST_CLI_PLACES_H

#include "cli/options.h"
#include "scene/camera_model.h"

/* X(field, "name"): options that are lists of places. */
#define MCV_PLACE_OPTIONS(X) \
    X(region, "--region") \
    X(edge, "--edge") \
    X(line, "--line") \
    X(caliper, "--caliper") \
    X(circle, "--circle") \
    X(arc, "--arc")

/*
 * A copy of the command whose places, and --background, are pixels (analysis/part_place.h). model:
 * of the image, or NULL. The copy shares the rest with the command, must not outlive it and is
 * freed by mcv_places_free, after failure as well.
 */
mcv_result mcv_places_resolve(const mcv_command *command, const mcv_camera_model *model,
                              mcv_command *resolved, mcv_error *error);
void mcv_places_free(mcv_command *resolved);

#endif
