/* SPDX-License-Identifier: Apache-2.0 */
/* What was found in an image of a part before a backlight goes back to where the part's contour
 * is. */
#ifndef MCVISI_HOST_CHECK_NOMINAL_H
#define MCVISI_HOST_CHECK_NOMINAL_H

#include "analysis/found.h"
#include "check/growth.h"

/* How an image shows a part. Nothing is owned. */
typedef struct mcv_part_view {
    const mcv_scene *scene;
    const mcv_camera_model *model; /* of the image */
    const mcv_growth *growth;      /* of the edges in it */
    const double *pixel;           /* width and height in the object plane [m] */
} mcv_part_view;

/*
 * Takes off by how much the edges have grown, and adds what is not known of it to the
 * uncertainties. MCV_FAILED where the part has no contour there, with a sentence.
 */
mcv_result mcv_nominal_put_back(const mcv_part_view *view, mcv_found *found, mcv_error *error);

#endif
