/* SPDX-License-Identifier: Apache-2.0 */
/* The image of one set of parameters: light, as mcv_exr_read would give it of a file. */
#ifndef MCVISI_HOST_EXPERIMENT_SET_IMAGE_H
#define MCVISI_HOST_EXPERIMENT_SET_IMAGE_H

#include "film/film.h"
#include "io/picture_header.h"

/* exr points to its other members: it must not be copied. */
typedef struct mcv_set_image {
    mcv_exr exr;
    mcv_exr_part parts[2]; /* the image and, of two replicates or more, its standard error */
    mcv_attribute attributes[MCV_PICTURE_PARAMETERS + 3];
    char names[MCV_PICTURE_PARAMETERS][MCV_EXR_ATTRIBUTE_NAME];
} mcv_set_image;

/* Develops a film of a sensor. After failure, too, the image is freed by mcv_set_image_free. */
mcv_result mcv_set_image_develop(const mcv_scene *scene, uint32_t sensor, const mcv_film *film,
                                 mcv_set_image *image, mcv_error *error);
void mcv_set_image_free(mcv_set_image *image);

/* Develops a film and writes it to the OpenEXR file `path`; `overrides`, the set as "PATH=VALUE"
 * lines, and the seed of the render stand in its header. */
mcv_result mcv_set_image_keep(const char *path, const mcv_scene *scene, uint32_t sensor,
                              const mcv_film *film, uint32_t seed, const char *overrides,
                              mcv_error *error);

#endif
