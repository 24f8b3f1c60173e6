/* SPDX-License-Identifier: Apache-2.0 */
/* Lights as a catalogue sells them (mcvisi/presets/), in the scene's elements. */
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

/* Checks the parameters, and makes the emitter the element that shines: area, or parallel where a
 * half-angle is given. */
mcv_result mcv_preset_resolve(const mcv_preset *preset, mcv_emitter *emitter,
                              const mcv_json_path *place, mcv_error *error);

#endif
