/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: sums the paths of a block (consecutive samples of one pixel and replicate, a power of two
 * of at most MCV_BLOCK) over a binary tree, as unevaluated sums of two floats: 48 bits without
 * double precision. The value of a path is the sum of its branches'.
 */
#ifndef MCVISI_KERNELS_ACCUMULATE_FILM_H
#define MCVISI_KERNELS_ACCUMULATE_FILM_H

#include "path/camera_path.h"
#include "schedule/vectorize.h"
#include "world.h"

typedef struct mcv_double_float {
    float high, low;
} mcv_double_float;

/* a + b with a relative error of a few 2^-48 (Knuth's two-sum; Dekker 1971). */
MCV_FUNCTION mcv_double_float mcv_add_double_floats(mcv_double_float a, mcv_double_float b) {
    mcv_double_float sum;
    const float high = a.high + b.high;
    const float part = high - a.high;
    const float low = ((a.high - (high - part)) + (b.high - part)) + (a.low + b.low);
    sum.high = high + low;
    sum.low = low - (sum.high - high);
    return sum;
}

/* What radiance, L/n², adds to the film along a sensor's ray of this weight. */
MCV_LOOP_FUNCTION float mcv_film_value(mcv_world world, float weight, float radiance,
                                       uint channel) {
    return radiance * weight * world.frame->sensor_index_squared[channel];
}

/* The path's value on the film, 0 (and counted) where it is not finite, or too large to be added.
 */
MCV_FUNCTION float mcv_path_value(mcv_world world, mcv_slot slot, uint channel, uint *nonfinite) {
    const float value = mcv_film_value(world, MCV_LOAD(slot, weight, 0),
                                       MCV_LOAD(slot, radiance, channel), channel);
    if (mcv_abs(value) <= MCV_LARGEST_VALUE) return value;
    *nonfinite += 1u;
    return 0.0f;
}

/* So many numbers mcv_tree_sums adds. */
#define MCV_SUMMED (MCV_TILE ? MCV_SLICE : MCV_BLOCK)

/* Adds the numbers high + low of each block of so many: block i's sum is then number i. Level by
 * level through the trees of all blocks at once. */
MCV_LOOP_FUNCTION void mcv_tree_sums(float *highs, float *lows, uint count, uint block) {
    float high_sums[MCV_SUMMED / 2], low_sums[MCV_SUMMED / 2];
    for (uint size = block; size > 1u; size /= 2u) {
        count /= 2u;
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            const mcv_double_float a = {highs[2u * i], lows[2u * i]};
            const mcv_double_float b = {highs[2u * i + 1u], lows[2u * i + 1u]};
            const mcv_double_float both = mcv_add_double_floats(a, b);
            high_sums[i] = both.high;
            low_sums[i] = both.low;
        }
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            highs[i] = high_sums[i];
            lows[i] = low_sums[i];
        }
    }
}

#endif
