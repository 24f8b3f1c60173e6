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
MCV_FUNCTION float mcv_path_value(mcv_world world, mcv_slot slot, int channel, uint *nonfinite) {
    const float weight = MCV_LOAD(slot, weight, 0);
    const float value = MCV_LOAD(slot, radiance, channel) * weight * world.frame->sensor_index_squared;
    if (mcv_abs(value) < INFINITY) return value;
    *nonfinite += 1u;
    return 0.0f;
}

/* slot: the block's first path; sums: two words per channel. */
static void mcv_accumulate_block(mcv_world world, mcv_slot slot, uint count, __global float *sums, uint *nonfinite) {
    mcv_float_pair tree[MCV_BLOCK];
    for (int channel = 0; channel < MCV_CHANNELS; ++channel) {
        for (uint i = 0; i < count; ++i) {
            mcv_slot path = slot;
            path.index += i;
            tree[i].high = mcv_path_value(world, path, channel, nonfinite);
            tree[i].low = 0.0f;
        }
        for (uint size = count; size > 1; size /= 2) {
            for (uint i = 0; i < size / 2; ++i) tree[i] = mcv_add_pairs(tree[2 * i], tree[2 * i + 1]);
        }
        sums[2 * channel] = tree[0].high;
        sums[2 * channel + 1] = tree[0].low;
    }
}
