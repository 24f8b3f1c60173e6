/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Smooth interface between media of refractive indices n1 (where the path is) and n2: Snell's law
 * and Fresnel's formulas for unpolarised light, free of cancellation. The host computes η = n1/n2
 * and δ = (n2 - n1)(n2 + n1)/n2² in double. In this form
 *
 *     c2² = c1² + s1² δ                         (δ may be negative; c2² <= 0: total reflection)
 *     r_s = -δ/(η c1 + c2)²                      R_s = r_s²
 *     R_p = R_s ((c1 c2 - s1 s2)/(c1 c2 + s1 s2))²       s1 s2 = η s1²
 *     t   = η d - δ/(η c1 + c2) n                (because η c1 - c2 = -δ/(η c1 + c2))
 *
 * keep their digits for tiny index steps and for grazing light. If n1 = n2, δ is 0 and the
 * interface is exactly transparent. Light is taken as unpolarised at each interface, which is not
 * exact behind the first one: a slab of n = 1.5 transmits 1.4 % less at 60° than with polarisation.
 */
#ifndef MCVISI_INTERFACE_H
#define MCVISI_INTERFACE_H

#include "mcvisi/dialect.h"
#include "mcvisi/vector.h"

/* What Snell's law and Fresnel's formulas need from a medium (index n1) to another (n2); computed
 * in double. */
typedef struct mcv_device_interface {
    float eta;   /* n1/n2 */
    float delta; /* (n2 - n1)(n2 + n1)/n2² */
    float scale; /* with a coating R = scale F + offset; without one 1 and 0 */
    float offset;
} mcv_device_interface;
MCV_ASSERT_SIZE(mcv_device_interface, 16);

/* c2, the cosine behind the interface, or 0 at total reflection. c1 lies in [0, 1]. */
MCV_LOOP_FUNCTION float mcv_refracted_cosine(mcv_device_interface between, float c1) {
    const float squared = mcv_fma(c1, c1, mcv_fma(-c1, c1, 1.0f) * between.delta);
    return squared > 0.0f ? mcv_sqrt(squared) : 0.0f;
}

/* The reflectance R for unpolarised light; c2 comes from mcv_refracted_cosine. */
MCV_LOOP_FUNCTION float mcv_fresnel(mcv_device_interface between, float c1, float c2) {
    const float sum = mcv_fma(between.eta, c1, c2);
    if (!(c2 > 0.0f)) return 1.0f;
    const float r_s = between.delta / (sum * sum);
    const float s1_s2 = between.eta * mcv_fma(-c1, c1, 1.0f);
    const float ratio = mcv_fma(c1, c2, -s1_s2) / mcv_fma(c1, c2, s1_s2);
    const float reflected = 0.5f * r_s * r_s * mcv_fma(ratio, ratio, 1.0f);
    return reflected < 1.0f ? reflected : 1.0f;
}

/* The reflectance of a body's surface, with its coating. */
MCV_LOOP_FUNCTION float mcv_interface_reflectance(mcv_device_interface between, float c1,
                                                  float c2) {
    const float bare = mcv_fresnel(between, c1, c2);
#if MCV_ON_DEVICE && MCV_WITH_COATING
    const float coated = mcv_fma(between.scale, bare, between.offset);
    if (c2 > 0.0f) return coated > 0.0f ? (coated < 1.0f ? coated : 1.0f) : 0.0f;
#endif
    return bare;
}

/* The refracted unit vector t. d is unit; n is unit and points to the side that d comes from; c1 =
 * -d·n; c2 > 0. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_refract(mcv_device_interface between, mcv_vec3 d, mcv_vec3 n,
                                       float c1, float c2) {
    const float bend = -between.delta / mcv_fma(between.eta, c1, c2);
    return mcv_normalize(mcv_along(mcv_scale(d, between.eta), bend, n));
}

/* d reflected at the plane with the unit normal n. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_reflect(mcv_vec3 d, mcv_vec3 n) {
    return mcv_renormalize(mcv_along(d, -2.0f * mcv_dot(d, n), n));
}

#endif
