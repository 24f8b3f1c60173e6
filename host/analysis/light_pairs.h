/* SPDX-License-Identifier: Apache-2.0 */
/* Two pictures of light with their replicates, as the pairs of electrons that a detection takes
 * (analysis/detect.h). */
#ifndef MCVISI_HOST_ANALYSIS_LIGHT_PAIRS_H
#define MCVISI_HOST_ANALYSIS_LIGHT_PAIRS_H

#include "analysis/detect.h"
#include "analysis/read_out.h"

/* A picture of light: its mean and header, and the film with its replicates; all borrowed. */
typedef struct mcv_light_picture {
    const char *path; /* for messages */
    const mcv_exr *exr;
    const mcv_film *film; /* of the size of the first part, with two replicates or more */
} mcv_light_picture;

typedef struct mcv_light_pairs {
    mcv_pairs pairs; /* of all pixels; points to `electrons` */
    mcv_camera camera;
    char lens[128]; /* what blurs, in words */
    double *electrons[2];
} mcv_light_pairs;

/*
 * What a camera collects of the picture with the defect, then of the one without, which --expose-to
 * takes its level from. Both must be of equal size and replicates. Freed by mcv_light_pairs_free,
 * after failure as well.
 */
mcv_result mcv_light_pairs_read(const mcv_camera_settings *settings,
                                const mcv_light_picture pictures[2], mcv_light_pairs *read,
                                mcv_error *error);
void mcv_light_pairs_free(mcv_light_pairs *read);

#endif
