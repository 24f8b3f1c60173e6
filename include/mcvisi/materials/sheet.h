/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Thin smooth sheet (type "sheet", and glTF transmission without volume): both interfaces and all
 * reflections between them at once, R' = 2 R/(1 + R). Transmitted light continues straight, without
 * the offset of a thick plate, times the transmittance.
 *
 *     {"type": "sheet", "ior": 1.5, "transmittance": 0.99}
 */
#ifndef MCVISI_MATERIALS_SHEET_H
#define MCVISI_MATERIALS_SHEET_H

#include "mcvisi/materials/material.h"

#define MCV_SHEET_PARAMS(X) \
    X(number, ior, 1.5, 1, 10, "refractive index n") \
    X(spectrum, transmittance, 1, 0, 1, "share of the refracted light that is transmitted")

/* What the device needs beside the transmittance, in vacuum. */
typedef struct mcv_sheet {
    float eta;   /* 1/n */
    float delta; /* (n - 1)(n + 1)/n² */
} mcv_sheet;

/* R' for the cosine of incidence; `into` is the interface from the medium outside into the
 * sheet. */
MCV_FUNCTION float mcv_sheet_reflectance(mcv_device_interface into, float cosine) {
    const float once = mcv_fresnel(into, cosine, mcv_refracted_cosine(into, cosine));
    return 2.0f * once / (1.0f + once);
}

#endif
