/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Diffuse area emitter (type "area", and any glTF material with emissiveFactor): radiance L in
 * every direction of the front side (Lambert), exitance π L. A glTF emissive texture modulates L.
 * The glTF factor times KHR_materials_emissive_strength is taken as a radiance in W/(m² sr).
 *
 *     {"type": "area", "size": ["100mm", "100mm"], "power": 5}
 */
#ifndef MCVISI_EMITTERS_AREA_H
#define MCVISI_EMITTERS_AREA_H

#include "mcvisi/emitters/emitter.h"

#define MCV_AREA_PARAMS(X) MCV_RADIANCE_PARAMS(X)

typedef struct mcv_area {
    uint nothing; /* C has no empty structs */
} mcv_area;

MCV_LOOP_FUNCTION float mcv_area_profile(MCV_GLOBAL const mcv_area *light, float cosine) {
    (void)light;
    return cosine > 0.0f ? 1.0f : 0.0f;
}

#endif
