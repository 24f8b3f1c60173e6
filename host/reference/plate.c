/* SPDX-License-Identifier: Apache-2.0 */
#include "reference/plate.h"

/* Both interfaces of a thin sheet and all reflections between them at once. */
static double both_interfaces(double once) { return 2 * once / (1 + once); }

ref_plate ref_plate_at(const mcv_material *material, const ref_interaction *interaction,
                       double outside, const double texture[3]) {
    ref_plate plate = {{0, 0, 0}, {0, 0, 0}};
    switch (material->type) {
    case MCV_MATERIAL_SHEET: {
        const mcv_sheet_params *p = &material->as.sheet;
        const double reflected = both_interfaces(ref_reflectance(interaction, outside, p->ior));
        for (int channel = 0; channel < 3; ++channel) {
            plate.reflected[channel] = reflected;
            plate.passed[channel] = (1 - reflected) * p->transmittance[channel] * texture[channel];
        }
        break;
    }
    case MCV_MATERIAL_BEAM_SPLITTER: {
        const mcv_beam_splitter_params *p = &material->as.beam_splitter;
        for (int channel = 0; channel < 3; ++channel) {
            plate.reflected[channel] = p->reflectance[channel];
            plate.passed[channel] = p->transmittance[channel];
        }
        break;
    }
    default:
        break;
    }
    return plate;
}
