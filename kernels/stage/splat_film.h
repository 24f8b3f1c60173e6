/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: adds what a light path brings to a pixel, in 64-bit fixed point of two words each:
 * integers have the same sum in any order. A word that wraps round tells so by its old value, so
 * that the carry is known without reading the other. Values are rounded at random, up with the
 * probability of what is cut off: on the average nothing is lost, however small they are.
 */
#ifndef MCVISI_KERNELS_SPLAT_FILM_H
#define MCVISI_KERNELS_SPLAT_FILM_H

#include "path/identity.h"
#include "path/sensor_ray.h"
#include "stage/record_light.h"

#if MCV_WITH_LIGHT_TRACING
/* sum: the number of the sum of one replicate, channel and pixel, which is not mcv_film_cell.
 * Returns 0 if it no longer fits. */
MCV_FUNCTION int mcv_add_splat(__global uint *splats, size_t sum, float units, float xi) {
    if (!(units < 9.0e18f)) return 0;
    ulong whole = (ulong)units;
    if (units < 16777216.0f && xi < units - (float)whole) ++whole;
    if (whole == 0) return 1;
    const uint low = (uint)whole;
    uint high = (uint)(whole >> 32);
    const uint before = atomic_add(splats + 2 * sum, low);
    if (before + low < before) ++high;
    if (high == 0) return 1;
    const uint above = atomic_add(splats + 2 * sum + 1, high);
    return above + high >= above;
}

MCV_FUNCTION int mcv_is_on_film(__constant const mcv_frame *frame, mcv_film_point place) {
    return place.column >= 0.0f && place.column < (float)frame->width && place.row >= 0.0f &&
           place.row < (float)frame->height;
}

/* The light is recorded instead where the launch records: its splats could not be taken back if
 * the launch is repeated. */
static void mcv_splat(mcv_world world, __global uint *splats, uint replicate, mcv_film_point place,
                      mcv_color value, uint emitter_element, float xi,
                      uint counts[MCV_COUNTER_COUNT]) {
    const uint width = world.frame->width;
    const uint height = world.frame->height;
    if (!mcv_is_on_film(world.frame, place)) return;
#if MCV_WITH_RECORDS
    if (mcv_records(world)) {
        mcv_append_record(
            world, mcv_film_cell(world.frame, (uint)place.column, (uint)place.row, replicate),
            emitter_element, mcv_dim(value, world.frame->splat_weight));
        return;
    }
#endif
    (void)emitter_element;
    const size_t pixel = (size_t)(uint)place.row * width + (uint)place.column;
    for (uint channel = 0; channel < MCV_CHANNELS; ++channel) {
        const size_t sum = ((size_t)replicate * MCV_CHANNELS + channel) * width * height + pixel;
        if (!(mcv_abs(value.c[channel]) < INFINITY))
            ++counts[MCV_COUNTER_nonfinite];
        else if (!mcv_add_splat(splats, sum, value.c[channel] * world.frame->splat_scale, xi))
            ++counts[MCV_COUNTER_saturated];
    }
}
#endif

#endif
