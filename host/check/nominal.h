/* SPDX-License-Identifier: Apache-2.0 */
/* Corrects measurements of a part before a backlight: from the edges in the image to the part's
 * contour. */
#ifndef MCVISI_HOST_CHECK_NOMINAL_H
#define MCVISI_HOST_CHECK_NOMINAL_H

#include "analysis/found.h"
#include "check/growth.h"

/* How an image shows a part. All pointers are borrowed. */
typedef struct mcv_part_view {
    const mcv_scene *scene;
    const mcv_camera_model *model; /* of the image */
    const mcv_growth *growth;      /* of the edges in it */
    const double *pixel;           /* width and height in the object plane [m] */
} mcv_part_view;

/*
 * Subtracts the growth of the edges and adds its uncertainty. MCV_FAILED with a sentence if the
 * part has no contour there.
 */
mcv_result mcv_nominal_put_back(const mcv_part_view *view, mcv_found *found, mcv_error *error);

#endif
