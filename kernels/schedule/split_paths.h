/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's branches of paths that split, many at once: mcv_start_branch does the same
 * for one, in place of another slot. */
#ifndef MCVISI_KERNELS_SMOOTH_SURFACES_H
#define MCVISI_KERNELS_SMOOTH_SURFACES_H

#if MCV_WITH_SMOOTH && MCV_WITH_SPLIT
/* The branches of the first `last` paths, which have gone on, in the slots from the given one: the
 * same but for where they go. Returns where they end. */
static __attribute__((noinline)) uint mcv_split_paths(mcv_world world, uint *paths,
                                                      const uint *fate, uint last, uint begin) {
    uint branches[MCV_SLOTS], count = 0;
    mcv_slot slot;
    slot.base = paths;
    (void)world;
    MCV_VECTORIZE
    for (uint i = 0; i < last; ++i) {
        branches[i] = (fate[i] & MCV_SPLITS) != 0u;
        count += branches[i];
    }
    if (count == 0) return begin;
    const uint rows[3][2] = {{MCV_PATH_stream, MCV_PATH_sample + 1},
                             {MCV_PATH_weight, MCV_PATH_hit + 4},
                             {MCV_PATH_point, MCV_PATH_AFTER_branch_state + 1}};
    for (uint i = 0; i < 3; ++i) {
        uint *from = paths + rows[i][0] * MCV_ROW;
        mcv_compact_rows(branches, from, rows[i][1] - rows[i][0], MCV_ROW, last, from + begin);
    }
    MCV_VECTORIZE
    for (uint i = begin; i < begin + count; ++i) {
        slot.index = i;
        const mcv_vec3 direction = MCV_LOAD_3(slot, branch_state);
        mcv_name_branch(slot, slot);
        MCV_STORE_3(slot, direction, direction);
        const mcv_vec3 origin = mcv_offset_origin(MCV_LOAD_3(slot, point), MCV_LOAD_3(slot, error),
                                                  MCV_LOAD_3(slot, face), direction);
        MCV_STORE_3(slot, origin, origin);
        MCV_WORD(slot, media, 0) = MCV_WORD(slot, branch_state, 3);
        MCV_EACH_CHANNEL(c) MCV_WORD(slot, throughput, c) = MCV_WORD(slot, branch_state, 5 + c);
#if MCV_WITH_NEXT_EVENT
        MCV_WORD(slot, density, 0) = MCV_WORD(slot, branch_state, 4);
#endif
#if MCV_WITH_SURFACES
        MCV_WORD(slot, origin_surface, 0) =
            mcv_origin_surface_of(world, mcv_make_interaction(world, slot), direction);
#endif
    }
    return begin + count;
}
#endif

#endif
