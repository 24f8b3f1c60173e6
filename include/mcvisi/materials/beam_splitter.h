/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Beam splitter (type "beamSplitter"): an infinitely thin smooth plate. It reflects one share of
 * the light and transmits another straight on, both independent of the angle and the side, and
 * absorbs the rest. Per channel, reflectance + transmittance <= 1. At 45° before a lens it makes
 * the coaxial illumination of a camera.
 *
 *     {"type": "beamSplitter", "reflectance": 0.5, "transmittance": 0.5}
 */
#ifndef MCVISI_MATERIALS_BEAM_SPLITTER_H
#define MCVISI_MATERIALS_BEAM_SPLITTER_H

#include "mcvisi/materials/material.h"

#define MCV_BEAM_SPLITTER_PARAMS(X) \
    X(spectrum, reflectance, 0.5, 0, 1, "share of the light that is reflected") \
    X(spectrum, transmittance, 0.5, 0, 1, "share of the light that is transmitted")

typedef struct mcv_beam_splitter {
    uint nothing; /* C has no empty structs */
} mcv_beam_splitter;

#endif
