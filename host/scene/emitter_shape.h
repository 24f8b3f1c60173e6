/* SPDX-License-Identifier: Apache-2.0 */
/* What radiometry and the device structs of emitters share: sizes of beams, cones and images. */
#ifndef MCVISI_HOST_SCENE_EMITTER_SHAPE_H
#define MCVISI_HOST_SCENE_EMITTER_SHAPE_H

#include "scene/emitters.h"

#include <math.h>

/* Radius of the disk that a beam leaves, or infinite. */
static inline double mcv_beam_radius(const mcv_collimated_beam_params *p) {
    return p->aperture == MCV_APERTURE_CIRCLE ? fmin(p->size[0], p->size[1]) / 2 : INFINITY;
}

/* sin²(θ/2) */
static inline double mcv_half_sine_squared(double angle) {
    const double s = sin(angle / 2);
    return s * s;
}

/* Tangents of the half-angles that a projector's image fills, seen from the middle of the lens. */
void mcv_image_tangents(const mcv_projector_params *p, const mcv_texture *texture,
                        double tangents[2]);

#endif
