/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Emitters with a surface whose radiance depends on the angle from its normal alone
 * (MCV_SURFACE_LIGHTS) on the device: one type, MCV_EMITTER_AREA. Each has a struct mcv_<name> and
 * a function mcv_<name>_profile of the angle's cosine.
 */
#ifndef MCVISI_SURFACE_LIGHT_H
#define MCVISI_SURFACE_LIGHT_H

#include "mcvisi/elements.h"

#if !MCV_ON_DEVICE || MCV_WITH_AREA
typedef struct mcv_surface_light {
    uint distribution; /* MCV_EMITTER_… of MCV_SURFACE_LIGHTS */
    union {
#define MCV_X(name, key, NAME) mcv_##name name;
        MCV_SURFACE_LIGHTS(MCV_X)
#undef MCV_X
        uint words[5]; /* the most that one has */
    } as;
} mcv_surface_light;
MCV_ASSERT_SIZE(mcv_surface_light, 24);

/* The radiance at an angle of the given cosine, over L. Without conditional jumps: a loop over
 * paths calls it. */
MCV_LOOP_FUNCTION float mcv_surface_light_profile(MCV_GLOBAL const mcv_surface_light *light,
                                                  float cosine) {
    float profile = 0.0f;
#define MCV_X(name, key, NAME) \
    profile = light->distribution == MCV_EMITTER_##NAME \
                  ? mcv_##name##_profile(&light->as.name, cosine) \
                  : profile;
    MCV_SURFACE_LIGHTS(MCV_X)
#undef MCV_X
    return profile;
}
#endif

#endif
