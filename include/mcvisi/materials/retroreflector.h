/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Retroreflector (type "retroreflector"): sends light back to where it comes from, at any angle of
 * incidence θ. It is for tape, reflex foil and corner cubes. By default it is ideal: the share
 * `reflectance` returns exactly along its way. A real one
 *
 *   - loses light with the angle of incidence: the share that returns is reflectance times s²(θ),
 *     s²(θ) = 1/(1 + (tanθ/tanθ_h)⁴). It is half at the `entranceAngle` θ_h.
 *   - spreads the returned light about the way back, by the angle δ to it, with the density
 *     p(δ) = a² cosδ/(π (a² cos²δ + sin²δ)²) [1/sr]. Half of the light lies within the
 *     `divergence`, whose tangent is a. The tails fall with the fourth power of δ.
 *   - scatters the share `diffuseReflectance` as a diffuse surface does.
 *
 *     f(o, i) = reflectance s(θ_o) s(θ_i) p(δ)/max(cosθ_o, cosθ_i) + diffuseReflectance/π
 *
 * This is reciprocal and reflects at most reflectance + diffuseReflectance, whose sum is at most 1.
 * Light that would return below the surface is absorbed. Both sides are alike. A divergence between
 * 0 and 1e-4 is taken as 1e-4. The functions are phenomenological: they have the shape that the
 * photometry of sheeting describes (CIE 54.2:2001), a coefficient of retroreflection by entrance
 * and observation angle.
 *
 *     {"type": "retroreflector", "reflectance": 0.5, "entranceAngle": "35deg",
 *      "divergence": "0.3deg", "diffuseReflectance": 0.1}
 */
#ifndef MCVISI_MATERIALS_RETROREFLECTOR_H
#define MCVISI_MATERIALS_RETROREFLECTOR_H

#include "mcvisi/materials/material.h"

#define MCV_RETROREFLECTOR_PARAMS(X) \
    X(spectrum, reflectance, 1, 0, 1, "share of light at normal incidence that returns") \
    X(angle, entranceAngle, 1.5707963267948966, MCV_POSITIVE, 1.5707963267948966, \
      "angle of incidence at which half as much returns; 90deg: the same at all angles [rad]") \
    X(angle, divergence, 0, 0, 1.5, \
      "angle to the way back within which half of the returned light lies; 0: all returns " \
      "exactly " \
      "[rad]") \
    X(spectrum, diffuseReflectance, 0, 0, 1, "share of the light that is scattered diffusely")

/* What the device needs beside the reflectances. */
typedef struct mcv_retroreflector {
    float spread; /* tangent of the divergence; 0: light returns exactly */
    float fall;   /* 1/tangent of the entrance angle */
} mcv_retroreflector;

/* The smallest divergence: directions in float32 have an error of 1e-7. */
#define MCV_LEAST_DIVERGENCE 1e-4f

/* s²(θ); `fall` is 1/tanθ_h, the cosine is above 0. */
MCV_FUNCTION float mcv_retroreflector_efficiency(float fall, float cosine) {
    const float c = cosine < 1.0f ? cosine : 1.0f;
    const float slope = fall * mcv_sqrt(mcv_fma(-c, c, 1.0f)) / c;
    const float squared = slope * slope;
    return 1.0f / mcv_fma(squared, squared, 1.0f);
}

/* p(δ) for two unit vectors; `spread` is a. The cross product keeps the digits of small angles. */
MCV_FUNCTION float mcv_retroreflector_density(float spread, mcv_vec3 o, mcv_vec3 i) {
    const mcv_vec3 across = mcv_cross(o, i);
    const float c = mcv_dot(o, i);
    const float size = spread * c;
    const float sum = mcv_fma(size, size, mcv_dot(across, across));
    return c > 0.0f ? spread * spread * c / (MCV_PI * sum * sum) : 0.0f;
}

/* A direction about o with that density: tan²δ = a² u/(1 - u). */
MCV_FUNCTION mcv_vec3 mcv_retroreflector_sample(float spread, mcv_vec3 o, float xi, float eta) {
    float cosine, sine;
    const float r = mcv_disk(xi, eta, &cosine, &sine);
    const float side = spread * r;
    return mcv_normalize(
        mcv_from_frame(mcv_vec(side * cosine, side * sine, mcv_sqrt(mcv_fma(-r, r, 1.0f))), o));
}

#endif
