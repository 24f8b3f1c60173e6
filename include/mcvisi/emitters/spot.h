/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Spot light (type "spot", and KHR_lights_punctual): a point light along its node's -z. Within the
 * inner cone it has the radiant intensity I, from there to the outer cone I a² with
 *
 *     a = (cosθ - cosθ_o)/(cosθ_i - cosθ_o) = (sin²(θ_o/2) - sin²(θ/2))/(sin²(θ_o/2) -
 * sin²(θ_i/2)),
 *
 * nothing beyond. Φ = 2π I ((1 - cosθ_i) + (cosθ_i - cosθ_o)/3). Distance and `range` count as for
 * the point light. Both angles are half-angles, from the axis; the inner one must not be the
 * larger. Where they are the same the edge is sharp.
 *
 *     {"type": "spot", "intensity": 2, "innerConeAngle": "10deg", "outerConeAngle": "15deg"}
 *
 * From the emitter's side: a direction uniform in one of the cones that smooth bodies fill
 * (mcvisi/light_cone.h), carrying I a² over its density.
 */
#ifndef MCVISI_EMITTERS_SPOT_H
#define MCVISI_EMITTERS_SPOT_H

#include "mcvisi/emitters/emitter.h"

#define MCV_SPOT_PARAMS(X) \
    MCV_INTENSITY_PARAMS(X) \
    X(angle, innerConeAngle, 0, 0, 1.5707963267948966, \
      "half-angle θ_i within which the intensity is full [rad]") \
    X(angle, outerConeAngle, 0.78539816339744831, MCV_POSITIVE, 1.5707963267948966, \
      "half-angle θ_o beyond which there is none [rad]")

typedef struct mcv_spot {
    float position[3];     /* [m] */
    float axis[3];         /* unit; in which it shines */
    float edge;            /* sin²(θ_o/2); a point light: 2, beyond the largest sine */
    float slope;           /* 1/(sin²(θ_o/2) - sin²(θ_i/2)), FLT_MAX at most */
    float inverse_range_4; /* 1/R⁴ [1/m⁴]; 0: no range */
    uint padding[3];
} mcv_spot;
MCV_ASSERT_SIZE(mcv_spot, 48);

/* The share of I that is sent in a direction (unit, away from the light). */
MCV_LOOP_FUNCTION float mcv_spot_evaluate(MCV_GLOBAL const mcv_spot *light, mcv_vec3 direction) {
    /* sin²(θ/2) by the chord: a float32 cosine cannot tell 0.02° from 0. */
    const mcv_vec3 chord =
        mcv_sub(direction, mcv_vec(light->axis[0], light->axis[1], light->axis[2]));
    const float a = (light->edge - 0.25f * mcv_dot(chord, chord)) * light->slope;
    return a <= 0.0f ? 0.0f : a >= 1.0f ? 1.0f : a * a;
}

/* What distance leaves of an intensity: irradiance over intensity [1/m²]. */
MCV_LOOP_FUNCTION float mcv_spot_attenuation(MCV_GLOBAL const mcv_spot *light,
                                             float distance_squared) {
    const float left = mcv_fma(-light->inverse_range_4 * distance_squared, distance_squared, 1.0f);
    return left > 0.0f ? left / distance_squared : 0.0f;
}

#endif
