/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Diffuse material (type "diffuse"): Lambert reflection on both sides, f = reflectance/π.
 * Directions are chosen with the density cosθ/π, so that a path is multiplied by the reflectance
 * alone. A glTF base colour texture multiplies the reflectance.
 *
 * With a transmittance it is a thin translucent sheet, such as paper or opal glass: this share
 * leaves diffusely on the other side, f = transmittance/π, in the same medium. The texture
 * multiplies it too. Reflectance and transmittance add up to at most 1.
 *
 *     {"type": "diffuse", "reflectance": [0.8, 0.7, 0.6], "transmittance": 0.1}
 */
#ifndef MCVISI_MATERIALS_DIFFUSE_H
#define MCVISI_MATERIALS_DIFFUSE_H

#include "mcvisi/materials/material.h"

#define MCV_DIFFUSE_PARAMS(X) \
    X(spectrum, reflectance, 0.5, 0, 1, "share of the light that is reflected") \
    X(spectrum, transmittance, 0, 0, 1, \
      "share of the light that leaves diffusely on the other side")

/* The density [1/sr] of a direction from its cosine with the normal; also f cosθ of a white
 * surface. */
MCV_FUNCTION float mcv_diffuse_density(float cosine) { return cosine * (1.0f / MCV_PI); }

/* A direction about the unit normal; *density gets its density. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_diffuse_sample(mcv_vec3 normal, float xi, float eta,
                                              float *density) {
    const mcv_vec3 about = mcv_sample_cosine(xi, eta);
    *density = mcv_diffuse_density(about.z);
    return mcv_normalize(mcv_from_frame(about, normal));
}

#endif
