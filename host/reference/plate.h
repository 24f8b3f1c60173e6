/* SPDX-License-Identifier: Apache-2.0 */
/* Plates without thickness (MCV_PLATES): they reflect one share of the light and pass another
 * straight on. */
#ifndef MCVISI_HOST_REFERENCE_PLATE_H
#define MCVISI_HOST_REFERENCE_PLATE_H

#include "reference/interface.h"
#include "scene/scene.h"

/* The shares by channel; what is left is absorbed. */
typedef struct ref_plate {
    double reflected[3], passed[3];
} ref_plate;

/* outside: the index of the medium around it; texture: the value there of the material's texture.
 */
ref_plate ref_plate_at(const mcv_material *material, const ref_interaction *interaction,
                       double outside, const double texture[3]);

#endif
