/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Dielectric (type "dielectric"): a body of glass, fluid or gas, bounded by a closed mesh with
 * outward normals. Its surface refracts or reflects light (mcvisi/interface.h); one of the two is
 * chosen with Fresnel's probability. The body absorbs light along a path of length d: exp(-σ d).
 * Where bodies overlap, the one with the larger priority fills the space: an air bubble in glass is
 * a dielectric of ior 1 and priority 1 inside one of priority 0. A boundary with the same medium on
 * both sides has no effect.
 *
 * With a roughness the surface consists of microfacets that reflect and refract
 * (mcvisi/materials/microfacet.h); roughness between 0 and 0.032 is taken as 0.032. Single
 * reflection has the height-correlated masking of one side, single refraction that of opposite
 * sides (mcv_opposite_masking). Light that meets several microfacets is tabulated on both sides
 * from random walks (host/device/multiple_interface.c). Brushed glass is the exception: there this
 * light leaves with a cosine distribution on either side, as reciprocity requires.
 *
 * Dispersion. `glass`, in place of ior, names a glass of the catalogue in host/scene/glasses.c; its
 * index is taken at the wavelength of each channel (MCVISI_spectrum). An abbeNumber V_d, or
 * KHR_materials_dispersion (20/V_d), determines the two terms of Cauchy's formula n = A + B/λ² that
 * have n_d = ior and V_d at the lines d, F, C (587.5618, 486.1327, 656.2725 nm). Three numbers as
 * ior are the indices of the channels. If these indices differ, a path keeps one channel from the
 * first dielectric on, chosen by its throughput. A scene in which nothing else has a colour stays
 * grey, at one wavelength, unless it states three wavelengths or a material has an abbeNumber.
 *
 * Light is taken as unpolarised at each interface. Behind the first one this is not exact: a plate
 * of n = 1.5 transmits 1.4 % less at 60° than with polarisation (84.81 %).
 *
 * A coating changes the reflectance at every angle from Fresnel's F, which is F0 at normal
 * incidence, to
 *
 *     R = R0 + (1 - R0) (F - F0)/(1 - F0)        R0 = coating; not below 0
 *
 * from both sides. Total reflection stays total, and at grazing incidence all light is reflected.
 * This is not a model of layers, because a datasheet says little more than R0; interference colours
 * are left out. The coating exists only where the body borders on an index below 1.1: cemented or
 * wetted surfaces have none.
 *
 *     {"type": "dielectric", "ior": 1.5168, "absorption": 2.0, "priority": 0, "coating": 0.004}
 *     {"type": "dielectric", "glass": "N-BK7"}
 *     {"type": "dielectric", "ior": 1.72, "abbeNumber": 29}
 */
#ifndef MCVISI_MATERIALS_DIELECTRIC_H
#define MCVISI_MATERIALS_DIELECTRIC_H

#include "mcvisi/materials/material.h"

#define MCV_DIELECTRIC_PARAMS(X) \
    MCV_MEDIUM_PARAMS(X) \
    MCV_ROUGHNESS_PARAMS(X, 0) \
    X(number, coating, 0, 0, 1, \
      "reflectance at normal incidence of a coating, against gas or vacuum; 0: none")

#endif
