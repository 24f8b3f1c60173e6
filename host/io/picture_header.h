/* SPDX-License-Identifier: Apache-2.0 */
/* The sensor's part of an image's header. */
#ifndef MCVISI_HOST_IO_PICTURE_HEADER_H
#define MCVISI_HOST_IO_PICTURE_HEADER_H

#include "io/exr.h"
#include "scene/scene.h"

/* Gives an image of a sensor its description: where the scene's points lie in it
 * (scene/camera_model.h). */
mcv_result mcv_header_describe(const mcv_scene *scene, uint32_t sensor, mcv_image *image,
                               mcv_error *error);

enum { MCV_PICTURE_PARAMETERS = 17 };

/* The word for an aperture that is no full disc; its numbers stand beside it. */
#define MCV_PICTURE_APERTURE "mcvisi:aperture"

/* What a mask's cells pass, as a text: the number of rows, and the numbers of each row. */
#define MCV_PICTURE_MASK "mcvisi:apertureMask"

/* That text of a sensor, which the caller frees; NULL with *has for want of memory, or without a
 * mask. */
char *mcv_header_mask(const mcv_sensor *sensor, bool *has);

/* Reads such a text; false where it is none. */
bool mcv_header_read_mask(const char *text, mcv_mask *mask);

/*
 * The sensor's numbers as mcvisi:focalLength, mcvisi:angularResolution …, from its parameter table,
 * and the shape of its aperture. Returns how many; names holds the attributes' names.
 */
uint32_t mcv_header_attributes(const mcv_sensor *sensor,
                               mcv_attribute attributes[MCV_PICTURE_PARAMETERS],
                               char names[MCV_PICTURE_PARAMETERS][MCV_EXR_ATTRIBUTE_NAME]);

#endif
