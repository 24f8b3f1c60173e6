/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What all materials share. In a scene a material is the extension object MCVISI_materials of a
 * glTF material, {"type": …, parameters}. glTF's core materials are mapped to them
 * (docs/scene-format.md).
 *
 * A path carries L/n², so that a smooth interface multiplies it by its transmittance only; pixel =
 * n_sensor² Σ … L_e/n_emitter². Interpolated normals decide how light is reflected or refracted,
 * the triangle's own normal decides on which side it continues.
 *
 * A material is one header with
 *     MCV_<NAME>_PARAMS(X)    its parameters (mcvisi/params.h)
 *     mcv_<name>              of MCV_OWN_BSDFS and MCV_PLATES: what the device needs beside the
 *                             reflectance or transmittance
 *     its optics              for the device; kernels/bsdf/ combines it with the path
 * and one line in MCV_OWN_BSDFS, MCV_PLATES or MCV_MATERIALS (mcvisi/elements.h). A material that
 * fills a body is in MCV_MEDIUM_MATERIALS, too.
 */
#ifndef MCVISI_MATERIALS_MATERIAL_H
#define MCVISI_MATERIALS_MATERIAL_H

#include "mcvisi/interface.h"
#include "mcvisi/params.h"
#include "mcvisi/sampling.h"

/* Parameters of the medium that fills a body: the first ones of its material. */
#define MCV_MEDIUM_PARAMS(X) \
    X(spectrum, ior, 1.5, 1, 10, "refractive index n; with an abbeNumber, n at the d line") \
    X(spectrum, absorption, 0, 0, 1e30, \
      "absorption coefficient σ: transmittance exp(-σ d) over a path d [1/m]") \
    X(number, priority, 0, -1000, 1000, \
      "where bodies overlap, the one with the larger priority fills the space (an integer)") \
    X(choice, glass, 0, 0, 25, \
      "glass of the catalogue; its index is taken at the scene's wavelengths") \
    X(number, abbeNumber, 0, 0, 1e30, \
      "V_d = (n_d - 1)/(n_F - n_C), which makes n depend on the wavelength; 0: no dispersion")

/* Parameters of a surface that may consist of microfacets. */
#define MCV_ROUGHNESS_PARAMS(X, smoothest) \
    X(number, roughness, smoothest, 0, 1, "perceptual roughness: α is its square; 0: smooth") \
    X(number, anisotropy, 0, 0, 1, \
      "how much rougher the surface is along the tangent than across") \
    X(angle, anisotropyRotation, 0, -100, 100, \
      "angle of the rougher direction from the tangent, counter-clockwise [rad]")

#endif
