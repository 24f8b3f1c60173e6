/* SPDX-License-Identifier: Apache-2.0 */
/* What is inside of the public mcv_picture (mcvisi/mcvisi.h). */
#ifndef MCVISI_HOST_VERBS_PICTURE_H
#define MCVISI_HOST_VERBS_PICTURE_H

#include "io/exr.h"

struct mcv_picture {
    mcv_exr exr; /* part 0 is the image */
    char *path;  /* the file it was read from; of others a name for messages */
    bool values; /* read from a file of grey values, which has no parts and attributes but its
                    description */
    bool srgb;   /* such a file says that its values are coded for the eye */
};

/* A picture of an image in memory, which changes owners, also on failure. */
mcv_result mcv_picture_of(mcv_exr *exr, const char *name, mcv_picture **picture, mcv_error *error);

#endif
