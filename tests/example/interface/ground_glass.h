/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Ground glass (type "groundGlass"): the example of "A refracting material" in
 * docs/adding-an-element.md.
 *
 * A body whose surface is so rough that it scatters diffusely to both sides. Light that comes from
 * the side of the lower index n is returned with the share ρ and enters with the share T = 1 - ρ.
 * Light from the other side, of the index n', leaves with the share T (n/n')². Reciprocity demands
 * that factor, and so does equilibrium: a cavity of even radiance L/n² stays one. Nothing is
 * absorbed at the surface.
 *
 * Where the indices are equal, such as between two bodies that touch, the surface has no effect.
 *
 * Source: Lambert's law on both sides; for (n/n')², E. Veach, Robust Monte Carlo Methods for Light
 * Transport Simulation, 1997, 5.2.
 *
 *     {"type": "groundGlass", "ior": 1.5, "absorption": 50, "diffuseReflectance": 0.25}
 */
#ifndef MCVISI_MATERIALS_GROUND_GLASS_H
#define MCVISI_MATERIALS_GROUND_GLASS_H

#include "mcvisi/materials/material.h"

/* The parameters of the medium come first: the loader, the tables of media, absorption, dispersion
 * and the checks of bodies then know the material. Those of the surface follow. */
#define MCV_GROUND_GLASS_PARAMS(X) \
    MCV_MEDIUM_PARAMS(X) \
    X(number, diffuseReflectance, MCV_REQUIRED, 0, 1, \
      "share ρ that the surface returns to the side of the lower index")

/* What the device needs beside the medium: words of 4 bytes, at most 8. */
typedef struct mcv_ground_glass {
    float passed; /* 1 - ρ */
} mcv_ground_glass;

/* The share of the light of one side that comes to the other. eta: the index of the first side over
 * that of the other. Host and device compile it. */
MCV_FUNCTION float mcv_ground_glass_transmittance(float passed, float eta) {
    return eta > 1.0f ? passed / (eta * eta) : passed;
}

#endif
