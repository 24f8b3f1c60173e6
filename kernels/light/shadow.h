/* SPDX-License-Identifier: Apache-2.0 */
/* A receiver, which samples an emitter, and the result: a shadow ray and its light. */
#ifndef MCVISI_KERNELS_SHADOW_H
#define MCVISI_KERNELS_SHADOW_H

#include "mcvisi/offset.h"
#include "path/sampler.h"
#include "world.h"

/* The point that samples an emitter. */
typedef struct mcv_receiver {
    mcv_vec3 point, error, face;
} mcv_receiver;

typedef struct mcv_shadow {
    mcv_vec3 origin, direction;
    uint target;
    mcv_color light; /* radiance over the density of the choice; 0: nothing comes */
    float density; /* of the choice [1/sr]; 0: the only direction there is, and light is irradiance
                      over the chance of the choice */
    uint emitter_element; /* of the emitter (light/emitter_element.h); MCV_NONE: its first one, or
                     that where the ray meets it */
} mcv_shadow;

/* A shadow ray from the receiver, without light. */
MCV_LOOP_FUNCTION mcv_shadow mcv_shadow_along(mcv_receiver at, mcv_vec3 direction, uint target,
                                              float density) {
    mcv_shadow shadow;
    shadow.origin = mcv_offset_origin(at.point, at.error, at.face, direction);
    shadow.direction = direction;
    shadow.target = target;
    shadow.light = mcv_grey(0.0f);
    shadow.density = density;
    shadow.emitter_element = MCV_NONE;
    return shadow;
}

/*
 * An emitter's light over the density of its choice, where the receiver is lit. The emitter is read
 * in any case: what a loop reads on a condition is gathered lane by lane.
 */
MCV_LOOP_FUNCTION mcv_color mcv_light_over(__global const mcv_device_emitter *e, int lit,
                                           float factor, float density) {
    mcv_color light;
    MCV_EACH_CHANNEL(i) {
        const float sent = e->radiance[i] * factor / density;
        light.c[i] = lit ? sent : 0.0f;
    }
    return light;
}

#endif
