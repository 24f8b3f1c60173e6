/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Spot light (type "spot", and KHR_lights_punctual): a point light along its node's -z. Its radiant
 * intensity is I within the inner cone, 0 outside the outer cone, and between them I a² with
 *
 *     a = (cosθ - cosθ_o)/(cosθ_i - cosθ_o)
 *       = (sin²(θ_o/2) - sin²(θ/2))/(sin²(θ_o/2) - sin²(θ_i/2)).
 *
 * Φ = 2π I ((1 - cosθ_i) + (cosθ_i - cosθ_o)/3). Distance and `range` have the same effect as for
 * the point light. Both angles are half-angles from the axis; the inner one must not be larger. If
 * they are equal, the edge is sharp.
 *
 *     {"type": "spot", "intensity": 2, "innerConeAngle": "10deg", "outerConeAngle": "15deg"}
 *
 * Emission: a direction uniform in one of the cones of smooth bodies (mcvisi/light_cone.h); the
 * path carries I a² over its density.
 */
#ifndef MCVISI_EMITTERS_SPOT_H
#define MCVISI_EMITTERS_SPOT_H

#include "mcvisi/emitters/emitter.h"

#define MCV_SPOT_PARAMS(X) \
    MCV_INTENSITY_PARAMS(X) \
    X(angle, innerConeAngle, 0, 0, 1.5707963267948966, \
      "half-angle θ_i of the cone of full intensity [rad]") \
    X(angle, outerConeAngle, 0.78539816339744831, MCV_POSITIVE, 1.5707963267948966, \
      "half-angle θ_o of the cone outside which the intensity is 0 [rad]")

typedef struct mcv_spot {
    float slope; /* 1/(sin²(θ_o/2) - sin²(θ_i/2)), FLT_MAX at most */
} mcv_spot;

/* a²; the outer edge lies at sin²(θ_o/2). */
MCV_LOOP_FUNCTION float mcv_spot_profile(MCV_GLOBAL const mcv_spot *light, float edge, float q) {
    const float a = (edge - q) * light->slope;
    return a <= 0.0f ? 0.0f : a >= 1.0f ? 1.0f : a * a;
}

#endif
