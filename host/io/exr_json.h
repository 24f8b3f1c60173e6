/* SPDX-License-Identifier: Apache-2.0 */
/* The attributes of a picture as a JSON object of texts, numbers and lists of numbers. */
#ifndef MCVISI_HOST_IO_EXR_JSON_H
#define MCVISI_HOST_IO_EXR_JSON_H

#include "io/exr_make.h"

#include <jansson.h>

/* All attributes; what JSON cannot hold is null: numbers that are not finite, texts that are no
 * UTF-8. NULL without memory. */
json_t *mcv_attributes_json(const mcv_exr *exr);

/* Sets attributes from such an object without null. MCV_USAGE names what is wrong. */
mcv_result mcv_attributes_set_json(mcv_exr *exr, const json_t *object, mcv_error *error);

#endif
