/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Beam splitter (type "beamSplitter"): an infinitely thin smooth plate that reflects one share of
 * the light and passes another straight, whatever the angle and the side; the rest is absorbed. Per
 * channel reflectance + transmittance <= 1. The coaxial illumination of a camera: a plate at 45°
 * before its lens.
 *
 *     {"type": "beamSplitter", "reflectance": 0.5, "transmittance": 0.5}
 */
#ifndef MCVISI_MATERIALS_BEAM_SPLITTER_H
#define MCVISI_MATERIALS_BEAM_SPLITTER_H

#include "mcvisi/materials/material.h"

#define MCV_BEAM_SPLITTER_PARAMS(X) \
    X(spectrum, reflectance, 0.5, 0, 1, "share of the light that is reflected") \
    X(spectrum, transmittance, 0.5, 0, 1, "share of the light that passes")

typedef struct mcv_beam_splitter {
    uint nothing; /* C has no empty structs */
} mcv_beam_splitter;

#endif
