/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: sums the paths of a block (consecutive samples of one pixel and replicate, a power of two of at most MCV_BLOCK) over
 * a binary tree, as unevaluated pairs of floats: 48 bits without double precision. reads radiance, weight -> writes sums
 */
#include "path.h"
#include "world.h"

typedef struct mcv_float_pair {
    float high, low;
} mcv_float_pair;

/* a + b with a relative error of a few 2^-48 (Knuth's two-sum; Dekker 1971). */
MCV_FUNCTION mcv_float_pair mcv_add_pairs(mcv_float_pair a, mcv_float_pair b) {
    mcv_float_pair sum;
    const float high = a.high + b.high;
    const float part = high - a.high;
    const float low = ((a.high - (high - part)) + (b.high - part)) + (a.low + b.low);
    sum.high = high + low;
    sum.low = low - (sum.high - high);
    return sum;
}

/* The path's value on the film, 0 (and counted) where it is not finite. */
MCV_FUNCTION float mcv_path_value(mcv_world world, mcv_slot slot, uint channel, uint *nonfinite) {
    const float weight = MCV_LOAD(slot, weight, 0);
    const float value = MCV_LOAD(slot, radiance, channel) * weight * world.frame->sensor_index_squared;
    if (mcv_abs(value) < INFINITY) return value;
    *nonfinite += 1u;
    return 0.0f;
}

/* Writes the sum of the values, which are lost: high and low word. */
static void mcv_accumulate_block(float *values, uint count, __global float *sum) {
    float lows[MCV_BLOCK];
    for (uint i = 0; i < count; ++i) lows[i] = 0.0f;
    for (uint size = count / 2; size > 0; size /= 2) {
        for (uint i = 0; i < size; ++i) {
            const mcv_float_pair a = {values[2 * i], lows[2 * i]};
            const mcv_float_pair b = {values[2 * i + 1], lows[2 * i + 1]};
            const mcv_float_pair both = mcv_add_pairs(a, b);
            values[i] = both.high;
            lows[i] = both.low;
        }
    }
    sum[0] = values[0];
    sum[1] = lows[0];
}
