/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Metallic-roughness (type "metallicRoughness", and glTF's core materials): plastics, paint, coarse
 * metal. A specular layer of microfacets (mcvisi/materials/microfacet.h) has Schlick's reflectance
 * F0 + (1 - F0)(1 - c)^5. F0 is ((n - 1)/(n + 1))² for a non-metal, the base colour for a metal,
 * and interpolated between.
 *
 * Below the layer, the non-metallic part scatters the remaining light diffusely in the base colour:
 * f = base/π (1 - E(o))(1 - E(i))/(1 - mean E) with the layer's directional albedo E (Kulla and
 * Conty 2017). This is reciprocal and loses no energy. Of this light, the share `transmission`
 * passes a thin wall instead, with the same roughness as the reflection. Of the rest, the share
 * `diffuseTransmission` leaves diffusely on the other side. Both sides are alike. One texture
 * multiplies the base colour, a second one roughness (green) and metallic (blue).
 *
 *     {"type": "metallicRoughness", "baseColor": [0.8, 0.1, 0.1], "metallic": 0, "roughness": 0.4}
 */
#ifndef MCVISI_MATERIALS_METALLIC_ROUGHNESS_H
#define MCVISI_MATERIALS_METALLIC_ROUGHNESS_H

#include "mcvisi/materials/material.h"

#define MCV_METALLIC_ROUGHNESS_PARAMS(X) \
    X(spectrum, baseColor, 1, 0, 1, "reflectance of the diffuse part, and F0 of the metal") \
    X(number, metallic, 0, 0, 1, "share of the surface that is metal") \
    X(number, ior, 1.5, 1, 10, "refractive index of the layer on the non-metallic part") \
    X(number, transmission, 0, 0, 1, \
      "share of the light below the layer that is transmitted, as by a thin wall") \
    X(number, diffuseTransmission, 0, 0, 1, \
      "share of the remaining light that leaves diffusely on the other side") \
    MCV_ROUGHNESS_PARAMS(X, 1)

#endif
