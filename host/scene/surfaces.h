/* SPDX-License-Identifier: Apache-2.0 */
/* The parameters of MCVISI_surfaces, for parser and schema. */
#ifndef MCVISI_HOST_SCENE_SURFACES_H
#define MCVISI_HOST_SCENE_SURFACES_H

#include "mcvisi/surfaces/surfaces.h"
#include "scene/scene.h"

extern const char *const mcv_body_types[MCV_BODY_COUNT];
mcv_param_table mcv_body_table(uint32_t type);
mcv_param_table mcv_lens_surface_table(void);

#endif
