/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parallel emitter (type "parallel"; report 4.1.1): every point of the surface emits the radiance L
 * into the cone of half-angle β about the surface normal q_n. With c = q_d·q_n it emits if c > 0
 * and |q_d x q_n|² <= tan²β c² (a float32 cosine cannot tell 0.02° from 0). Its solid angle is 4π
 * sin²(β/2), its exitance π L sin²β. β lies in (0, 90°]. β = 0 is the collimated beam, another
 * type, because a camera ray hits it with probability 0.
 *
 *     {"type": "parallel", "size": ["60mm", "60mm"], "halfAngle": "0.5deg", "radiance": 1}
 */
#ifndef MCVISI_EMITTERS_PARALLEL_H
#define MCVISI_EMITTERS_PARALLEL_H

#include "mcvisi/emitters/emitter.h"

#define MCV_PARALLEL_PARAMS(X) \
    X(angle, halfAngle, MCV_REQUIRED, MCV_POSITIVE, 1.5707963267948966, \
      "half-angle β of the emission cone [rad]") \
    MCV_RADIANCE_PARAMS(X)

typedef struct mcv_parallel {
    float tangent_squared; /* tan²β */
    float sin_half;        /* sin(β/2) */
    float solid_angle;     /* 4π sin²(β/2) [sr] */
    uint from_receiver; /* 1: all points have one normal, so that a receiver may choose directions
                           in the cone */
    float axis[3];      /* that normal */
    uint padding;
} mcv_parallel;
MCV_ASSERT_SIZE(mcv_parallel, 32);

MCV_FUNCTION float mcv_parallel_evaluate(MCV_GLOBAL const mcv_parallel *emitter, mcv_vec3 direction,
                                         mcv_vec3 normal) {
    const float c = mcv_dot(direction, normal);
    const mcv_vec3 s = mcv_cross(direction, normal);
    const int within = (c > 0.0f) & (mcv_dot(s, s) <= emitter->tangent_squared * c * c);
    return within ? 1.0f : 0.0f;
}

#endif
