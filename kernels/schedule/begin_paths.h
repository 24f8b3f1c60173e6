/* SPDX-License-Identifier: Apache-2.0 */
/* Stage of the tile schedule: begins the paths of a slice at the sensor. */
#ifndef MCVISI_KERNELS_BEGIN_PATHS_H
#define MCVISI_KERNELS_BEGIN_PATHS_H

#include "schedule/tile.h"

#include "schedule/sort_paths.h"
#include "stage/generate_rays.h"

/* Begins the paths first … first + count - 1 of the launch; returns how many have begun. */
MCV_BATCH uint mcv_begin_paths(mcv_world world, uint *paths, uint first, uint count) {
    uint columns[MCV_SLOTS], rows[MCV_SLOTS], cells[MCV_SLOTS], begins[MCV_SLOTS], begun[MCV_SLOTS];
    const uint samples = 1u << world.frame->log2_samples;
    for (uint from = 0, to; from < count; from = to) {
        const mcv_identity id = mcv_identify(world, first + from);
        to = min(count, from + samples - ((first + from) & (samples - 1u)));
        MCV_VECTORIZE
        MCV_EACH_PATH (slot, paths, from, to) {
            columns[slot.index] = id.column;
            rows[slot.index] = id.row;
            cells[slot.index] = id.cell;
            MCV_WORD(slot, stream, 0) = id.stream;
            MCV_WORD(slot, sample, 0) = id.sample + (slot.index - from);
        }
    }
    MCV_VECTORIZE
    MCV_EACH_PATH (slot, paths, 0, count) {
        mcv_identity id;
        id.column = columns[slot.index];
        id.row = rows[slot.index];
        id.cell = cells[slot.index];
        id.stream = MCV_WORD(slot, stream, 0);
        id.sample = MCV_WORD(slot, sample, 0);
        mcv_generate_ray(world, slot, id);
        MCV_WORD(slot, sample_place, 0) = slot.index;
        begins[slot.index] = MCV_LOAD(slot, weight, 0) > 0.0f;
    }
    const uint alive = mcv_compact_indices(begins, count, begun);
    if (alive < count) mcv_move_paths(paths, begun, alive);
    return alive;
}

#endif
