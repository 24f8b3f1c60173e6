/* SPDX-License-Identifier: Apache-2.0 */
/* What paths of the reference renderer need to know of a scene. */
#ifndef MCVISI_HOST_REFERENCE_WORLD_H
#define MCVISI_HOST_REFERENCE_WORLD_H

#include "reference/path.h"

/* How exact: a draft has coarse tables of rough materials. Without sample_emitters, emission is
 * found by hits only. */
typedef struct ref_manner {
    bool sample_emitters, draft;
} ref_manner;

/* Builds it for a sensor. After failure, too, it is freed by ref_world_free. */
mcv_result ref_world_new(const mcv_scene *scene, uint32_t sensor, uint32_t depth, ref_manner how,
                         ref_world *world, mcv_error *error);
void ref_world_free(ref_world *world);

#endif
