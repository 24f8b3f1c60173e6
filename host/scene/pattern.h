/* SPDX-License-Identifier: Apache-2.0 */
/* Sequences of patterns (mcvisi/pattern.h). */
#ifndef MCVISI_HOST_SCENE_PATTERN_H
#define MCVISI_HOST_SCENE_PATTERN_H

#include "mcvisi/pattern.h"
#include "scene/params.h"

extern const char *const mcv_pattern_types[MCV_PATTERN_COUNT];
mcv_param_table mcv_pattern_table(uint32_t type);

/* Reads the value of a parameter `pattern`. */
mcv_result mcv_pattern_parse(const json_t *value, mcv_pattern *pattern, const mcv_json_path *place,
                             mcv_error *error);

/* How many images the sequence has. */
uint32_t mcv_pattern_count(const mcv_pattern *pattern);

/* The value of the pixel `at` across the stripes in the image `index`. */
double mcv_pattern_value(const mcv_pattern *pattern, uint32_t index, uint32_t at);

/* Makes the image, one pixel wide along the stripes; its texture is stretched over them. The caller
 * frees texture->linear. */
mcv_result mcv_pattern_image(const mcv_pattern *pattern, uint32_t index, mcv_texture *texture,
                             const mcv_json_path *place, mcv_error *error);

#endif
