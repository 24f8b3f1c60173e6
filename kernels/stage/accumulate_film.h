/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: sums the paths of a block (consecutive samples of one pixel and replicate, a power of two
 * of at most MCV_BLOCK) over a binary tree, as unevaluated pairs of floats: 48 bits without double
 * precision. The value of a path is the sum of its branches'. reads radiance, weight -> writes sums
 */
#include "path/camera_path.h"
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

/* The path's value on the film, 0 (and counted) where it is not finite, or too large to be added.
 */
MCV_FUNCTION float mcv_path_value(mcv_world world, mcv_slot slot, uint channel, uint *nonfinite) {
    const float weight = MCV_LOAD(slot, weight, 0);
    const float value =
        MCV_LOAD(slot, radiance, channel) * weight * world.frame->sensor_index_squared[channel];
    if (mcv_abs(value) <= MCV_LARGEST_VALUE) return value;
    *nonfinite += 1u;
    return 0.0f;
}

#if MCV_TILE
/* No path of this number among its sample's branches has ended yet. */
static __attribute__((noinline)) void mcv_clear_values(float *values, uint branch) {
    for (uint channel = 0; channel < MCV_CHANNELS; ++channel) {
        float *of_branch = values + channel * MCV_SLOTS + branch * MCV_SLICE;
        MCV_VECTORIZE
        for (uint i = 0; i < MCV_SLICE; ++i) of_branch[i] = 0.0f;
    }
}

/*
 * Writes the sums of count / block blocks of a channel's values, MCV_SLICE of each branch: high and
 * low word each. Level by level through all trees at once, from one array to the other, so that a
 * level is a long loop.
 */
static __attribute__((noinline)) void mcv_accumulate_blocks(const float *values, uint branches,
                                                            uint count, uint block,
                                                            __global float *sums) {
    float highs[2][MCV_SLICE];
    float lows[2][MCV_SLICE];
    uint from = 0;
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        highs[0][i] = values[i];
        lows[0][i] = 0.0f;
    }
    for (uint branch = 1; branch < branches; ++branch) {
        const float *of_branch = values + branch * MCV_SLICE;
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) highs[0][i] += of_branch[i];
    }
    for (uint size = block; size > 1u; size /= 2u, from ^= 1u) {
        count /= 2u;
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            const mcv_float_pair a = {highs[from][2u * i], lows[from][2u * i]};
            const mcv_float_pair b = {highs[from][2u * i + 1u], lows[from][2u * i + 1u]};
            const mcv_float_pair both = mcv_add_pairs(a, b);
            highs[from ^ 1u][i] = both.high;
            lows[from ^ 1u][i] = both.low;
        }
    }
    for (uint i = 0; i < count; ++i) {
        sums[2u * MCV_CHANNELS * i] = highs[from][i];
        sums[2u * MCV_CHANNELS * i + 1u] = lows[from][i];
    }
}
#else
/* The sum of numbers high + low, which are lost. */
static mcv_float_pair mcv_tree_sum(float *values, float *lows, uint count) {
    for (uint size = count / 2; size > 0; size /= 2) {
        for (uint i = 0; i < size; ++i) {
            const mcv_float_pair a = {values[2 * i], lows[2 * i]};
            const mcv_float_pair b = {values[2 * i + 1], lows[2 * i + 1]};
            const mcv_float_pair both = mcv_add_pairs(a, b);
            values[i] = both.high;
            lows[i] = both.low;
        }
    }
    const mcv_float_pair sum = {values[0], lows[0]};
    return sum;
}
#endif
