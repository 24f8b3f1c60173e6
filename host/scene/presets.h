/* SPDX-License-Identifier: Apache-2.0 */
/* Presets: lights as catalogues offer them (mcvisi/presets/), made of the scene's elements. */
#ifndef MCVISI_HOST_SCENE_PRESETS_H
#define MCVISI_HOST_SCENE_PRESETS_H

#include "core/json_path.h"
#include "scene/scene.h"

typedef struct mcv_preset {
    uint32_t type; /* MCV_PRESET_…, or MCV_NONE */
    union {
#define MCV_X(name, key, NAME) mcv_##name##_params name;
        MCV_PRESETS(MCV_X)
#undef MCV_X
    } as;
} mcv_preset;

/* Checks the parameters and fills in the element that emits: area, or parallel with a
 * half-angle. */
mcv_result mcv_preset_resolve(const mcv_preset *preset, mcv_emitter *emitter,
                              const mcv_json_path *place, mcv_error *error);

#endif
