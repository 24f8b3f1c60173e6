/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's loops that choose an emitter for each path by what reaches its surface and by
 * its lobe: the steps of light/selection.h, emitter by emitter. */
#ifndef MCVISI_KERNELS_REACH_ROWS_H
#define MCVISI_KERNELS_REACH_ROWS_H

#include "schedule/tile.h"

#include "schedule/ranges.h"
#include "schedule/vectorize.h"
#include "stage/sample_emitters.h"

#if MCV_WITH_NEXT_EVENT
#if MCV_WITH_REACH
/* Paths whose importances are kept at a time: they stay in the first cache. */
#define MCV_SELECTION_BLOCK 256u

/* What the surfaces of a block's paths make of light: rows of the words of mcv_receiver_lobe. */
typedef struct mcv_lobe_rows {
    float words[sizeof(mcv_receiver_lobe) / sizeof(float)][MCV_SELECTION_BLOCK];
} mcv_lobe_rows;

MCV_LOOP_FUNCTION mcv_receiver_lobe mcv_lobe_in(const mcv_lobe_rows *rows, uint i) {
    const mcv_receiver_lobe lobe = {{rows->words[0][i], rows->words[1][i], rows->words[2][i]},
                                    rows->words[3][i],
                                    rows->words[4][i],
                                    rows->words[5][i],
                                    rows->words[6][i],
                                    rows->words[7][i]};
    return lobe;
}

MCV_LOOP_FUNCTION void mcv_keep_lobe(mcv_lobe_rows *rows, uint i, mcv_receiver_lobe lobe) {
    rows->words[0][i] = lobe.along.x;
    rows->words[1][i] = lobe.along.y;
    rows->words[2][i] = lobe.along.z;
    rows->words[3][i] = lobe.along_squared;
    rows->words[4][i] = lobe.across_squared;
    rows->words[5][i] = lobe.microfacet;
    rows->words[6][i] = lobe.spread;
    rows->words[7][i] = lobe.even;
}

/* mcv_select_emitter for the paths of one block; glossy: as of mcv_add_reaching. */
MCV_LOOP_FUNCTION void mcv_select_block(mcv_world world, mcv_slot slot, uint first, uint last,
                                        const uint *sides, const mcv_lobe_rows *lobes, int glossy) {
    const uint count = min(world.frame->emitter_count, (uint)MCV_MOST_REACHING);
    float weights[MCV_MOST_REACHING][MCV_SELECTION_BLOCK];
    float sums[4][MCV_SELECTION_BLOCK], scales[MCV_SELECTION_BLOCK], leasts[MCV_SELECTION_BLOCK];
    for (uint k = 0; k < 4; ++k)
        for (uint i = 0; i < last - first; ++i) sums[k][i] = 0.0f;
    for (uint k = 0; k < count; ++k) {
        __global const mcv_device_emitter *e = world.emitters + k;
        float *of_emitter = weights[k];
        MCV_VECTORIZE
        for (uint i = first; i < last; ++i) {
            const uint j = i - first;
            slot.index = i;
            mcv_reaching all = {sums[0][j], sums[1][j], sums[2][j], sums[3][j]};
            of_emitter[j] =
                mcv_add_reaching(e, MCV_LOAD_3(slot, point), MCV_LOAD_3(slot, ng),
                                 MCV_LOAD_3(slot, ns), sides[i], MCV_LOAD_3(slot, direction),
                                 glossy ? mcv_lobe_in(lobes, j) : mcv_even_lobe(), glossy, &all);
            sums[0][j] = all.sum;
            sums[1][j] = all.count;
            sums[2][j] = all.received;
            sums[3][j] = all.squares;
        }
    }
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) {
        const uint j = i - first;
        slot.index = i;
        const mcv_reaching all = {sums[0][j], sums[1][j], sums[2][j], sums[3][j]};
        const mcv_light_selection selection = mcv_make_light_selection(all, glossy);
        mcv_put_selection(slot, selection);
        scales[j] = selection.pmf_scale;
        leasts[j] = selection.pmf_least;
        MCV_WORD(slot, emitter, 0) = MCV_NONE;
        if (MCV_WITH_GLOSSY) MCV_STORE(slot, selection_here, 2, 0.0f);
        MCV_STORE_COLOR(slot, shadow_light, mcv_grey(0.0f));
        sums[0][j] = 0.0f; /* of the chances of those asked */
    }
    for (uint k = 0; k < count; ++k) {
        const float *of_emitter = weights[k];
        MCV_VECTORIZE
        for (uint i = first; i < last; ++i) {
            const uint j = i - first;
            slot.index = i;
            const mcv_emitter_choice so_far = {MCV_WORD(slot, emitter, 0), sums[0][j],
                                               MCV_WITH_GLOSSY ? MCV_LOAD(slot, selection_here, 2)
                                                               : 0.0f};
            const mcv_emitter_choice choice =
                mcv_ask_emitter(so_far, k, of_emitter[j], scales[j], leasts[j],
                                MCV_LOAD(slot, drawn, 2 * MCV_PAIR_CHOICE));
            MCV_WORD(slot, emitter, 0) = choice.emitter;
            if (MCV_WITH_GLOSSY) MCV_STORE(slot, selection_here, 2, choice.chance);
            sums[0][j] = choice.chances;
        }
    }
}

/* Paths of surfaces without lobes. */
MCV_BATCH void mcv_select_even_block(mcv_world world, mcv_slot slot, uint first, uint last,
                                     const uint *sides) {
    mcv_select_block(world, slot, first, last, sides, 0, 0);
}

/* mcv_select_emitter for the paths in the slots first … last - 1, whose surfaces have no lobes and
 * scatter light on so many sides. */
MCV_BATCH void mcv_select_by_reach_rows(mcv_world world, mcv_slot slot, uint first, uint last,
                                        const uint *sides) {
    for (uint begin = first; begin < last; begin += MCV_SELECTION_BLOCK)
        mcv_select_even_block(world, slot, begin, min(begin + MCV_SELECTION_BLOCK, last), sides);
}

#if MCV_WITH_GLOSSY
MCV_BATCH void mcv_select_glossy_block(mcv_world world, mcv_slot slot, uint first, uint last,
                                       const uint *sides, const mcv_lobe_rows *lobes) {
    mcv_select_block(world, slot, first, last, sides, lobes, 1);
}

#if MCV_HAS_PLAIN
/* The same on plain glossy surfaces of one material. */
MCV_LOOP_FUNCTION void mcv_select_glossy_range(mcv_world world, mcv_slot slot, uint first,
                                               uint last, mcv_shading shading, const uint *sides) {
    if (shading.type == MCV_MATERIAL_DIELECTRIC) {
        mcv_select_by_reach_rows(world, slot, first, last, sides);
        return;
    }
    for (uint begin = first; begin < last; begin += MCV_SELECTION_BLOCK) {
        const uint end = min(begin + MCV_SELECTION_BLOCK, last);
        mcv_lobe_rows lobes;
        MCV_VECTORIZE_MASKED
        for (uint i = begin; i < end; ++i) {
            slot.index = i;
            const mcv_interaction interaction = mcv_make_interaction(world, slot);
            const mcv_glossy_interaction m = mcv_make_plain_glossy_interaction(
                world, slot, &interaction, shading, mcv_path_media(slot));
            mcv_keep_lobe(&lobes, i - begin, mcv_lobe_of_glossy(&m));
        }
        mcv_select_glossy_block(world, slot, begin, end, sides, &lobes);
    }
}
#endif
#endif
#endif
#endif

#endif
