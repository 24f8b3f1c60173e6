/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's moves of paths to other slots: into the order of their classes, and together
 * where others have ended. Only the paths that are in a wrong place move. */
#ifndef MCVISI_KERNELS_SORT_PATHS_H
#define MCVISI_KERNELS_SORT_PATHS_H

#include "schedule/tile.h"

#include "schedule/compact.h"
#include "schedule/ranges.h"
#include "schedule/vectorize.h"

/* The paths in the slots from[k] move to the slots to[k], with their first `words` words. */
MCV_BATCH void mcv_move_rows(uint *paths, uint words, const uint *from, const uint *to,
                             uint moves) {
    uint moving[MCV_SLOTS];
    for (uint word = 0; moves > 0 && word < words; ++word) {
        uint *row = paths + word * MCV_ROW;
        MCV_VECTORIZE
        for (uint k = 0; k < moves; ++k) moving[k] = row[from[k]];
        for (uint k = 0; k < moves; ++k) row[to[k]] = moving[k];
    }
}

/* The paths in the slots chosen[0 … count - 1], in ascending order, get the slots 0 … count - 1:
 * the last ones move to where others have ended. */
MCV_BATCH void mcv_move_paths(uint *paths, const uint *chosen, uint count) {
    uint from[MCV_SLOTS], to[MCV_SLOTS], moves = 0;
    for (uint slot = 0, next = 0; slot < count; ++slot) {
        if (chosen[next] == slot) {
            ++next;
        } else {
            to[moves] = slot;
            from[moves] = chosen[count - 1u - moves];
            ++moves;
        }
    }
    mcv_move_rows(paths, MCV_PATH_hit, from, to, moves);
}

/* Where the classes end, and in home[i] the class that the slot i is of once the paths are sorted.
 */
MCV_BATCH void mcv_count_classes(const uint *classes, uint count, uint *class_end, uint *home) {
    uint last[MCV_CLASS_MISS] = {0};
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const uint class = i < count ? classes[i] : MCV_CLASS_MISS;
#pragma unroll
        for (uint c = 0; c < MCV_CLASS_MISS; ++c) last[c] += class <= c;
    }
    for (uint c = 0; c < MCV_CLASS_MISS; ++c) class_end[c] = last[c];
    class_end[MCV_CLASS_MISS] = count;
    MCV_VECTORIZE
    for (size_t i = 0; i < mcv_fill_lanes(count); ++i) {
        uint class = 0;
#pragma unroll
        for (uint c = 0; c < MCV_CLASS_MISS; ++c) class += (uint)i >= last[c];
        home[i] = class;
    }
}

/*
 * Puts the paths into the order of their classes and says where each ends. The paths that miss come
 * last: their words are lost. A counting sort of the paths that are not at home: in ascending order
 * the slots that they leave or get are sorted by class already.
 */
MCV_BATCH void mcv_sort_paths(uint *paths, const uint *classes, uint count, uint *class_end) {
    uint home[MCV_ROW], departs[MCV_ROW], receives[MCV_ROW], from[MCV_SLOTS], to[MCV_SLOTS],
        strays[MCV_SLOTS], next[MCV_CLASS_COUNT] = {0};
    mcv_count_classes(classes, count, class_end, home);
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(count); ++i) {
        const int moves = classes[i] != home[i], misses = classes[i] == MCV_CLASS_MISS,
                  ends = home[i] == MCV_CLASS_MISS;
        departs[i] = (uint)(moves & !misses);
        receives[i] = (uint)(moves & !ends);
    }
    const uint moves = mcv_compact_indices(departs, count, strays);
    mcv_compact_indices(receives, count, to);
    for (uint k = 0; k < moves; ++k) ++next[classes[strays[k]] + 1u];
    for (uint c = 1; c < MCV_CLASS_COUNT; ++c) next[c] += next[c - 1u];
    for (uint k = 0; k < moves; ++k) from[next[classes[strays[k]]]++] = strays[k];
    mcv_move_rows(paths, MCV_PATH_hit + 4, from, to, moves);
}

#endif
