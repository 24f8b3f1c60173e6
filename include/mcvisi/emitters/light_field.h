/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Light field emitter (type "lightField"; report 4.1.3): a rectangle of M x N macro pixels. The
 * image has J x K pixels for each, M·J x N·K in all. The macro pixel is chosen by the point of
 * emission q_i, its pixel by the direction of emission.
 *
 * In the node's frame (x right, y up, emitting along -z) macro pixel (0, 0) lies at -x, +y. With o
 * its centre and d the unit direction of emission, i = o + d lies on the unit hemisphere over o.
 * Projected on the emitter's plane it falls into
 *
 *     column j = min(J - 1, floor((d_x + 1)/2 · J))     row k = min(K - 1, floor((1 - d_y)/2 · K))
 *
 * of the macro pixel. The radiance is L times the image's value there. `angularRange` a is the sine
 * at the edge and replaces d by d/a: the J x K pixels then cover the directions with |d_x| <= a and
 * |d_y| <= a, and no light leaves outside this range. Because d_x and d_y are sines, a pixel emits
 * in proportion to its area within the unit disk: Φ = Σ L A/(M N) (pixel ∩ disk).
 *
 * `image` is given as for the telecentric projector. `radiance` is that of the value 1; power is
 * that of the whole rectangle, per channel.
 *
 *     {"type": "lightField", "image": 0, "size": ["32mm", "24mm"], "radiance": 1,
 *      "spatialResolution": [32, 24], "angularResolution": [9, 9], "angularRange": 0.1}
 */
#ifndef MCVISI_EMITTERS_LIGHT_FIELD_H
#define MCVISI_EMITTERS_LIGHT_FIELD_H

#include "mcvisi/emitters/emitter.h"

#define MCV_LIGHT_FIELD_EMITTER_PARAMS(X) \
    X(int2, spatialResolution, MCV_REQUIRED, 1, 65536, "macro pixels M, N in x and y") \
    X(int2, angularResolution, MCV_REQUIRED, 1, 65536, \
      "directions J, K of a macro pixel in x and y") \
    X(number, angularRange, 1, MCV_POSITIVE, 1, \
      "sine of the largest angle from the normal in x and in y") \
    MCV_IMAGE_PARAMS(X)

typedef struct mcv_light_field_emitter {
    uint macro_width, macro_height;     /* M, N */
    uint angular_width, angular_height; /* J, K */
    float x[3], y[3]; /* the node's axes in the world, divided by the angular range a */
    uint padding[2];
} mcv_light_field_emitter;
MCV_ASSERT_SIZE(mcv_light_field_emitter, 48);

/*
 * The image's pixel for the point (s, t) of the rectangle (from its upper left corner, in units of
 * its sides) and a unit direction of emission. Returns 0 if the direction is out of range.
 */
MCV_LOOP_FUNCTION int mcv_light_field_pixel(MCV_GLOBAL const mcv_light_field_emitter *emitter,
                                            float s, float t, mcv_vec3 direction, uint *column,
                                            uint *row) {
    const float d_x = mcv_dot(direction, mcv_vec(emitter->x[0], emitter->x[1], emitter->x[2]));
    const float d_y = mcv_dot(direction, mcv_vec(emitter->y[0], emitter->y[1], emitter->y[2]));
    const int within = (mcv_abs(d_x) <= 1.0f) & (mcv_abs(d_y) <= 1.0f);
    *column = mcv_cell(s, emitter->macro_width) * emitter->angular_width +
              mcv_cell(within ? 0.5f * d_x + 0.5f : 0.0f, emitter->angular_width);
    *row = mcv_cell(t, emitter->macro_height) * emitter->angular_height +
           mcv_cell(within ? 0.5f - 0.5f * d_y : 0.0f, emitter->angular_height);
    return within;
}

#endif
