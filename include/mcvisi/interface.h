/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Smooth interface between media of refractive indices n1 (where the path is) and n2: Snell and
 * unpolarised Fresnel, free of cancellation. The host gives η = n1/n2 and δ = (n2 - n1)(n2 +
 * n1)/n2² from double, so that
 *
 *     c2² = c1² + s1² δ                         (δ may be negative; c2² <= 0: total reflection)
 *     r_s = -δ/(η c1 + c2)²                      R_s = r_s²
 *     R_p = R_s ((c1 c2 - s1 s2)/(c1 c2 + s1 s2))²       s1 s2 = η s1²
 *     t   = η d - δ/(η c1 + c2) n                (because η c1 - c2 = -δ/(η c1 + c2))
 *
 * keep their digits for tiny index steps and grazing light. n1 = n2 has δ = 0: exactly transparent.
 * Unpolarised light at each interface: a slab's transmittance deviates from the polarised truth
 * (1.4 % at 60°, n = 1.5).
 */
#ifndef MCVISI_INTERFACE_H
#define MCVISI_INTERFACE_H

#include "mcvisi/dialect.h"
#include "mcvisi/vector.h"

/* What Snell and Fresnel need to go from one medium (index n1) to another (n2); computed in double.
 */
typedef struct mcv_device_interface {
    float eta;   /* n1/n2 */
    float delta; /* (n2 - n1)(n2 + n1)/n2² */
    float scale; /* with a coating R = scale F + offset; 1 and 0: it has none */
    float offset;
} mcv_device_interface;
MCV_ASSERT_SIZE(mcv_device_interface, 16);

/* c2, the cosine behind the interface, or 0 at total reflection. c1 in [0, 1]. */
MCV_LOOP_FUNCTION float mcv_refracted_cosine(mcv_device_interface between, float c1) {
    const float squared = mcv_fma(c1, c1, mcv_fma(-c1, c1, 1.0f) * between.delta);
    return squared > 0.0f ? mcv_sqrt(squared) : 0.0f;
}

/* The share R of unpolarised light that is reflected; c2 from mcv_refracted_cosine. */
MCV_LOOP_FUNCTION float mcv_fresnel(mcv_device_interface between, float c1, float c2) {
    const float sum = mcv_fma(between.eta, c1, c2);
    if (!(c2 > 0.0f)) return 1.0f;
    const float r_s = between.delta / (sum * sum);
    const float s1_s2 = between.eta * mcv_fma(-c1, c1, 1.0f);
    const float ratio = mcv_fma(c1, c2, -s1_s2) / mcv_fma(c1, c2, s1_s2);
    const float reflected = 0.5f * r_s * r_s * mcv_fma(ratio, ratio, 1.0f);
    return reflected < 1.0f ? reflected : 1.0f;
}

/* The share that a body's surface reflects, coating and all. */
MCV_LOOP_FUNCTION float mcv_interface_reflectance(mcv_device_interface between, float c1,
                                                  float c2) {
    const float bare = mcv_fresnel(between, c1, c2);
#if MCV_ON_DEVICE && MCV_WITH_COATING
    const float coated = mcv_fma(between.scale, bare, between.offset);
    if (c2 > 0.0f) return coated > 0.0f ? (coated < 1.0f ? coated : 1.0f) : 0.0f;
#endif
    return bare;
}

/* The unit vector t; d is unit, n unit on the side d comes from, c1 = -d·n, c2 > 0. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_refract(mcv_device_interface between, mcv_vec3 d, mcv_vec3 n,
                                       float c1, float c2) {
    const float bend = -between.delta / mcv_fma(between.eta, c1, c2);
    return mcv_normalize(mcv_along(mcv_scale(d, between.eta), bend, n));
}

/* d reflected at the plane of the unit normal n. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_reflect(mcv_vec3 d, mcv_vec3 n) {
    return mcv_renormalize(mcv_along(d, -2.0f * mcv_dot(d, n), n));
}

#endif
