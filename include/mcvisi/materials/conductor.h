/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Conductor (type "conductor"): an opaque metal of complex index n - ik that reflects by Fresnel's
 * formulas. With roughness 0 it is smooth, else it consists of microfacets
 * (mcvisi/materials/microfacet.h) with α = roughness². Roughness between 0 and 0.032 is taken as
 * 0.032.
 *
 * Light that several microfacets reflect is tabulated from random walks between microfacets (Heitz
 * et al. 2016, host/device/multiple.c), so that a metal that absorbs nothing stays white.
 * `anisotropy` s in (0, 1] describes brushed and turned metal: it widens the highlight along the
 * mesh's tangent, α_t = α + (1 - α) s² (KHR_materials_anisotropy). Its multiple reflection is
 * tabulated for pairs of directions (mcvisi/materials/brushed.h); where a texture gives the
 * roughness it is right in its sum only (Kulla and Conty 2017).
 *
 * n and k are given as numbers or by the name of a metal. A name takes them from the table in
 * host/scene/metals.c at the wavelengths of the scene (MCVISI_spectrum, docs/scene-format.md).
 *
 *     {"type": "conductor", "metal": "copper", "roughness": 0.3}
 *     {"type": "conductor", "n": [0.27, 0.68, 1.32], "k": [3.61, 2.63, 2.29]}
 */
#ifndef MCVISI_MATERIALS_CONDUCTOR_H
#define MCVISI_MATERIALS_CONDUCTOR_H

#include "mcvisi/materials/material.h"

#define MCV_CONDUCTOR_PARAMS(X) \
    X(spectrum, n, MCV_UNSET, 0, 100, \
      "real part of the refractive index n - ik, in place of a metal's name") \
    X(spectrum, k, MCV_UNSET, 0, 100, "extinction coefficient k of n - ik") \
    MCV_ROUGHNESS_PARAMS(X, 0) \
    X(choice, metal, 0, 0, 7, "name of a metal; n and k are taken at the scene's wavelengths")

#endif
