/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parameters of the materials. In a scene they stand in the extension object MCVISI_materials of a glTF material,
 * {"type": …, parameters}; core glTF materials are mapped to them (see the README). Their optics for the device stand in
 * mcvisi/materials/<name>.h.
 *
 * A path carries L/n² (so a smooth interface multiplies by its transmittance only); pixel = n_sensor² Σ … L_e/n_emitter².
 */
#ifndef MCVISI_MATERIALS_MATERIAL_H
#define MCVISI_MATERIALS_MATERIAL_H

#include "mcvisi/params.h"

/* Lambert reflection on both sides. */
#define MCV_DIFFUSE_PARAMS(X) X(spectrum, reflectance, 0.5, 0, 1, "share of the light that is reflected")

/*
 * A smooth body of glass, fluid or gas, bounded by a closed mesh. Where bodies overlap the one with the larger
 * priority fills the space: an air bubble in glass is a dielectric of ior 1 and priority 1 inside one of priority 0.
 */
#define MCV_DIELECTRIC_PARAMS(X) \
    X(number, ior, 1.5, 1, 10, "refractive index n") \
    X(spectrum, absorption, 0, 0, 1e30, "absorption coefficient σ: transmittance exp(-σ d) over a path d [1/m]") \
    X(number, priority, 0, -1000, 1000, "where bodies overlap the larger one fills the space (an integer)")

/* A thin smooth sheet (glTF transmission without volume): both interfaces at once, no offset. */
#define MCV_SHEET_PARAMS(X) \
    X(number, ior, 1.5, 1, 10, "refractive index n") \
    X(spectrum, transmittance, 1, 0, 1, "share of the refracted light that passes")

/* A smooth opaque mirror. */
#define MCV_MIRROR_PARAMS(X) X(spectrum, reflectance, 1, 0, 1, "share of the light that is reflected")

/* Takes all light: black walls, stops. X has no parameters. */
#define MCV_ABSORBER_PARAMS(X)

#endif
