/* SPDX-License-Identifier: Apache-2.0 */
/* The image of one set of parameters, in the form in which mcv_exr_read returns a file. */
#ifndef MCVISI_HOST_EXPERIMENT_SET_IMAGE_H
#define MCVISI_HOST_EXPERIMENT_SET_IMAGE_H

#include "film/film.h"
#include "io/picture_header.h"

/* exr points to other members of the struct: it must not be copied. */
typedef struct mcv_set_image {
    mcv_exr exr;
    mcv_exr_part parts[2]; /* the image and, with two or more replicates, its standard error */
    mcv_attribute attributes[MCV_PICTURE_PARAMETERS + 5];
    char names[MCV_PICTURE_PARAMETERS][MCV_EXR_ATTRIBUTE_NAME];
} mcv_set_image;

/* Develops a film of a sensor. The image must be freed by mcv_set_image_free even after a
 * failure. */
mcv_result mcv_set_image_develop(const mcv_scene *scene, uint32_t sensor, const mcv_film *film,
                                 mcv_set_image *image, mcv_error *error);
void mcv_set_image_free(mcv_set_image *image);

/* Develops a film and writes it to the OpenEXR file `path`. Its header contains `overrides`, the
 * set as "PATH=VALUE" lines, and the seed of the render. */
mcv_result mcv_set_image_keep(const char *path, const mcv_scene *scene, uint32_t sensor,
                              const mcv_film *film, uint32_t seed, const char *overrides,
                              mcv_error *error);

#endif
