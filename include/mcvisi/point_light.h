/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Emitters without extent (MCV_POINT_LIGHTS) on the device: one type, MCV_EMITTER_POINT. Each has a
 * struct mcv_<name> and a function mcv_<name>_profile of the angle θ from the axis. The angle is
 * given as q = sin²(θ/2), from the chord, because a float32 cosine cannot tell 0.02° from 0.
 */
#ifndef MCVISI_POINT_LIGHT_H
#define MCVISI_POINT_LIGHT_H

#include "mcvisi/elements.h"
#include "mcvisi/vector.h"

#if !MCV_ON_DEVICE || MCV_WITH_PUNCTUAL
typedef struct mcv_point_light {
    float position[3];     /* [m] */
    float axis[3];         /* unit; the direction of emission */
    float edge;            /* q at which emission ends; 1: it emits in all directions */
    float inverse_range_4; /* 1/R⁴ [1/m⁴]; 0: unlimited range */
    uint distribution;     /* MCV_EMITTER_… of MCV_POINT_LIGHTS */
    union {
#define MCV_X(name, key, NAME) mcv_##name name;
        MCV_POINT_LIGHTS(MCV_X)
#undef MCV_X
        uint words[3]; /* the size of the largest member */
    } as;
} mcv_point_light;
MCV_ASSERT_SIZE(mcv_point_light, 48);

/* The intensity in a direction (unit, away from the light), over I. It has no conditional jumps,
 * because a vectorised loop over paths calls it. */
MCV_LOOP_FUNCTION float mcv_point_light_profile(MCV_GLOBAL const mcv_point_light *light,
                                                mcv_vec3 direction) {
    const mcv_vec3 chord =
        mcv_sub(direction, mcv_vec(light->axis[0], light->axis[1], light->axis[2]));
    const float q = 0.25f * mcv_dot(chord, chord);
    float profile = 0.0f;
#define MCV_X(name, key, NAME) \
    profile = light->distribution == MCV_EMITTER_##NAME \
                  ? mcv_##name##_profile(&light->as.name, light->edge, q) \
                  : profile;
    MCV_POINT_LIGHTS(MCV_X)
#undef MCV_X
    return profile;
}

/* Irradiance over intensity at a distance [1/m²], including the range. */
MCV_LOOP_FUNCTION float mcv_point_light_attenuation(MCV_GLOBAL const mcv_point_light *light,
                                                    float distance_squared) {
    const float left = mcv_fma(-light->inverse_range_4 * distance_squared, distance_squared, 1.0f);
    return left > 0.0f ? left / distance_squared : 0.0f;
}
#endif

#endif
