/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of MCVISI_defects, for parser and schema. */
#ifndef MCVISI_HOST_SCENE_DEFECT_PARAMS_H
#define MCVISI_HOST_SCENE_DEFECT_PARAMS_H

#include "mcvisi/defects.h"
#include "scene/scene.h"

extern const char *const mcv_defect_types[MCV_DEFECT_COUNT];
mcv_param_table mcv_defect_table(uint32_t type);

#endif
