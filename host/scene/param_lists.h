/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters that are arrays of arrays (mcvisi/params.h): masks and curves. */
#ifndef MCVISI_HOST_SCENE_PARAM_LISTS_H
#define MCVISI_HOST_SCENE_PARAM_LISTS_H

#include "core/json.h"
#include "mcvisi/params.h"

mcv_result mcv_mask_parse(const json_t *rows, mcv_mask *mask, const mcv_json_path *place,
                          mcv_error *error);
mcv_result mcv_curve_parse(const mcv_param *param, const json_t *pairs, mcv_curve *curve,
                           const mcv_json_path *place, mcv_error *error);

/* The curve at a length, straight between its pairs and beyond them; 1 for none. */
double mcv_curve_at(const mcv_curve *curve, double at);

/* params.c: one number of a parameter's kind. */
mcv_result mcv_param_number(const mcv_param *param, const json_t *value, double *number,
                            const mcv_json_path *place, mcv_error *error);

#endif
