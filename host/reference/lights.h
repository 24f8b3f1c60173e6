/* SPDX-License-Identifier: Apache-2.0 */
/* Emitters that no direction chosen otherwise can meet: beams, lasers, lights without extent. */
#ifndef MCVISI_HOST_REFERENCE_LIGHTS_H
#define MCVISI_HOST_REFERENCE_LIGHTS_H

#include "reference/geometry.h"
#include "reference/random.h"

/* What such an emitter sends through a point. */
typedef struct ref_light {
    ref_vec direction;    /* unit, towards the emitter */
    double distance;      /* of the emitter; infinite for a directional light [m] */
    uint32_t instance;    /* that lies there, or MCV_NONE */
    double irradiance[3]; /* on a plane across the direction [W/m²] */
} ref_light;

/* False where the emitter is of another kind, or sends nothing there. A laser draws numbers for the
 * ray that it sends through the point. */
bool ref_light_at(const mcv_scene *scene, const mcv_emitter *emitter, ref_vec point,
                  ref_random *random, ref_light *light);

#endif
