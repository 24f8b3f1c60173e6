/* SPDX-License-Identifier: Apache-2.0 */
/* A receiver, which samples an emitter, and the result: the light sample. */
#ifndef MCVISI_KERNELS_LIGHT_SAMPLE_H
#define MCVISI_KERNELS_LIGHT_SAMPLE_H

#include "mcvisi/offset.h"
#include "path/sampler.h"
#include "world.h"

/* The point that samples an emitter. */
typedef struct mcv_receiver {
    mcv_vec3 point, error, ng;
} mcv_receiver;

/*
 * What a receiver has sampled of an emitter: a shadow ray, and what arrives along it [W/m²] where
 * nothing blocks the ray. A pdf of 0 says that the emitter is a delta light: a beam, a laser, a
 * point or directional light. Its light comes from one direction, which no other ray of the path
 * meets by chance. So MIS has nothing to weigh, and `radiance_over_pdf` is the irradiance of a
 * surface across that direction, over the probability of the choice.
 */
typedef struct mcv_light_sample {
    mcv_vec3 origin, direction;  /* of the shadow ray; without a target it ends at t = 1 */
    uint target;                 /* MCV_NONE, MCV_SKY, or the instance that it must meet first */
    mcv_color radiance_over_pdf; /* 0: nothing comes */
    float pdf;                   /* of the direction [1/sr]; 0: a delta light */
    uint emitter_element; /* of the emitter (light/emitter_element.h); MCV_NONE: its first one, or
                     that where the ray meets it */
} mcv_light_sample;

/* A sample whose shadow ray goes from the receiver in a direction, without light. */
MCV_LOOP_FUNCTION mcv_light_sample mcv_light_sample_along(mcv_receiver at, mcv_vec3 direction,
                                                          uint target, float pdf) {
    mcv_light_sample sample;
    sample.origin = mcv_offset_origin(at.point, at.error, at.ng, direction);
    sample.direction = direction;
    sample.target = target;
    sample.radiance_over_pdf = mcv_grey(0.0f);
    sample.pdf = pdf;
    sample.emitter_element = MCV_NONE;
    return sample;
}

/*
 * An emitter's radiance, times a factor, over the pdf, where the receiver is lit. The emitter is
 * read in any case: what a loop reads on a condition is gathered lane by lane.
 */
MCV_LOOP_FUNCTION mcv_color mcv_radiance_over_pdf(__global const mcv_device_emitter *e, int lit,
                                                  float factor, float pdf) {
    mcv_color light;
    MCV_EACH_CHANNEL(i) {
        const float sent = e->radiance[i] * factor / pdf;
        light.c[i] = lit ? sent : 0.0f;
    }
    return light;
}

#endif
