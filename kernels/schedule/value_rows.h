/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The values of the paths of a slice, once these have ended, and stage accumulate_film over a
 * slice. A sample's paths are told apart by the number of their branch: channel c of sample i's
 * branch b is values[c * MCV_SLOTS + b * MCV_SLICE + i].
 */
#ifndef MCVISI_KERNELS_VALUE_ROWS_H
#define MCVISI_KERNELS_VALUE_ROWS_H

#include "schedule/tile.h"

#include "schedule/vectorize.h"
#include "stage/accumulate_film.h"

/* No path of this branch has ended yet. */
MCV_BATCH void mcv_clear_values(float *values, uint branch) {
    for (uint channel = 0; channel < MCV_CHANNELS; ++channel) {
        float *of_branch = values + channel * MCV_SLOTS + branch * MCV_SLICE;
        MCV_VECTORIZE
        for (uint i = 0; i < MCV_SLICE; ++i) of_branch[i] = 0.0f;
    }
}

/* The path has ended. Returns how many of its values are not finite. */
MCV_LOOP_FUNCTION uint mcv_terminate_path(mcv_world world, mcv_slot slot, float *values) {
    const uint place = mcv_branch_of(slot) * MCV_SLICE + MCV_WORD(slot, sample_place, 0);
    uint nonfinite = 0;
    MCV_EACH_CHANNEL(c)
    values[c * MCV_SLOTS + place] = mcv_path_value(world, slot, (uint)c, &nonfinite);
    return nonfinite;
}

/* The listed paths have ended. */
MCV_BATCH uint mcv_terminate_paths(mcv_world world, uint *paths, const uint *listed, uint count,
                                   float *values) {
    uint nonfinite = 0;
    mcv_slot slot = mcv_slot_at(paths, 0);
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = listed[i];
        nonfinite += mcv_terminate_path(world, slot, values);
    }
    return nonfinite;
}

/* Writes the sums of the blocks of the launch's paths first … first + count - 1, high and low word
 * each. */
MCV_BATCH void mcv_accumulate_values(mcv_world world, const float *values, uint branches,
                                     uint first, uint count, __global float *sums) {
    const uint block = mcv_block_size(world.frame->log2_samples);
    float highs[MCV_SLICE], lows[MCV_SLICE];
    sums += (size_t)(first / block) * MCV_CHANNELS * 2u;
    for (uint channel = 0; channel < MCV_CHANNELS; ++channel, values += MCV_SLOTS, sums += 2) {
        MCV_VECTORIZE
        for (uint i = 0; i < count; ++i) {
            highs[i] = values[i];
            lows[i] = 0.0f;
        }
        for (uint branch = 1; branch < branches; ++branch) {
            const float *of_branch = values + branch * MCV_SLICE;
            MCV_VECTORIZE
            for (uint i = 0; i < count; ++i) highs[i] += of_branch[i];
        }
        mcv_tree_sums(highs, lows, count, block);
        for (uint i = 0; i < count / block; ++i) {
            sums[2u * MCV_CHANNELS * i] = highs[i];
            sums[2u * MCV_CHANNELS * i + 1u] = lows[i];
        }
    }
}

#endif
