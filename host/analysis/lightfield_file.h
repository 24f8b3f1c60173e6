/* SPDX-License-Identifier: Apache-2.0 */
/* Light field images in OpenEXR files: `mcvisi render` writes into the header what they are. */
#ifndef MCVISI_HOST_ANALYSIS_LIGHTFIELD_FILE_H
#define MCVISI_HOST_ANALYSIS_LIGHTFIELD_FILE_H

#include "analysis/lightfield.h"
#include "io/exr.h"

typedef struct mcv_light_field_file {
    mcv_exr exr;     /* part 0 is the image */
    mcv_image image; /* its light, Y or R, G, B, above the camera's black level; belongs to exr */
    uint32_t angular[2]; /* J, K */
} mcv_light_field_file;

/*
 * Reads the image; J x K from mcvisi:angularResolution in the header unless `angular` is not {0,
 * 0}. MCV_BAD_INPUT with a sentence for an image that is none of a light field camera or that
 * mcv_light_field_check refuses.
 */
mcv_result mcv_light_field_read(const char *path, const uint64_t angular[2],
                                mcv_light_field_file *file, mcv_error *error);

/* The same of an image in memory, which changes owners, also on failure. */
mcv_result mcv_light_field_of(mcv_exr *exr, const char *path, const uint64_t angular[2],
                              mcv_light_field_file *file, mcv_error *error);
void mcv_light_field_free(mcv_light_field_file *file);

/* A header's numbers. MCV_BAD_INPUT where the attribute is missing or has not `count` of them. */
mcv_result mcv_light_field_attribute(const char *path, const mcv_exr *exr, const char *name,
                                     double *numbers, uint32_t count, mcv_error *error);

/* The light of a part of such a file, as in `image` above; belongs to the part. */
mcv_result mcv_light_field_light(const char *path, const mcv_exr_part *part, mcv_image *light,
                                 mcv_error *error);

#endif
