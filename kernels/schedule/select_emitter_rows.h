/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's loops that choose an emitter for each path: the steps of light/discrete.h and
 * light/selection.h, emitter by emitter or digit by digit. */
#ifndef MCVISI_KERNELS_SELECT_EMITTER_ROWS_H
#define MCVISI_KERNELS_SELECT_EMITTER_ROWS_H

#include "schedule/tile.h"

#include "schedule/ranges.h"
#include "schedule/vectorize.h"
#include "stage/sample_emitters.h"

#if MCV_WITH_NEXT_EVENT
#if MCV_WITH_EMISSION || (MCV_WITH_PLAIN && !MCV_WITH_REACH)
/* mcv_search_cdf for the chosen paths, by the numbers drawn for a pair. */
MCV_BATCH void mcv_search_cdf_rows(__global const uint *cdf, uint count, mcv_slot slot, uint pair,
                                   const uint *chosen, uint chosen_count, uint *found) {
    for (uint i = 0; i < chosen_count; ++i) found[i] = 0;
    for (uint digit = mcv_cdf_digit(count); digit > 0; digit /= 2) {
        MCV_VECTORIZE
        for (uint i = 0; i < chosen_count; ++i) {
            slot.index = chosen[i];
            const mcv_pair drawn = mcv_draw(slot, 0, pair);
            found[i] = mcv_cdf_step(cdf, count, found[i], digit, mcv_cdf_bits(drawn.x, drawn.y));
        }
    }
}
#endif

#if MCV_WITH_PLAIN
#if MCV_WITH_REACH
/* mcv_select_emitter for the paths in the slots first … last - 1; both sides of the surfaces of
 * those from two_sided to two_sided_end scatter light. */
MCV_BATCH void mcv_select_emitter_rows(mcv_world world, mcv_slot slot, uint first, uint last,
                                       uint two_sided, uint two_sided_end) {
    const uint count = min(world.frame->emitter_count, (uint)MCV_MOST_REACHING);
    float importances[MCV_MOST_REACHING][MCV_SLOTS], sums[MCV_SLOTS], numbers[MCV_SLOTS];
    for (uint i = first; i < last; ++i) sums[i] = numbers[i] = 0.0f;
    for (uint k = 0; k < count; ++k) {
        __global const mcv_device_emitter *e = world.emitters + k;
        float *of_emitter = importances[k];
        MCV_VECTORIZE
        for (uint i = first; i < last; ++i) {
            slot.index = i;
            mcv_reaching all = {sums[i], numbers[i]};
            const int is_two_sided = (i >= two_sided) & (i < two_sided_end);
            of_emitter[i] =
                mcv_add_reaching(e, MCV_LOAD_3(slot, point), MCV_LOAD_3(slot, face),
                                 MCV_LOAD_3(slot, normal), is_two_sided ? 2u : 1u, &all);
            sums[i] = all.sum;
            numbers[i] = all.count;
        }
    }
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_reaching all = {sums[i], numbers[i]};
        mcv_put_selection(slot, mcv_make_light_selection(all));
        MCV_WORD(slot, emitter, 0) = MCV_NONE;
        MCV_STORE_COLOR(slot, shadow_light, mcv_grey(0.0f));
        sums[i] = 0.0f; /* of the chances of those asked */
    }
    for (uint k = 0; k < count; ++k) {
        const float *of_emitter = importances[k];
        MCV_VECTORIZE
        for (uint i = first; i < last; ++i) {
            slot.index = i;
            const mcv_emitter_choice so_far = {MCV_WORD(slot, emitter, 0), sums[i]};
            const mcv_emitter_choice choice =
                mcv_ask_emitter(so_far, k, of_emitter[i], mcv_selection_in(slot),
                                MCV_LOAD(slot, drawn, 2 * MCV_PAIR_CHOICE));
            MCV_WORD(slot, emitter, 0) = choice.emitter;
            sums[i] = choice.chances;
        }
    }
}
#endif

/* mcv_pick_emitter for the paths on plain surfaces. What these leave to light paths is left out
 * where they make shadow rays (mcv_respond_as). */
MCV_BATCH void mcv_select_plain_emitters(mcv_world world, mcv_slot slot, const uint *class_end,
                                         uint gloss) {
    const uint first = class_end[MCV_LAST_SMOOTH], last = class_end[MCV_LAST_KNOWN];
    uint *emitters = slot.base + MCV_PATH_emitter * MCV_ROW;
    (void)gloss;
    if (world.frame->emitter_count == 1u) {
        for (uint i = first; i < last; ++i) emitters[i] = 0u;
        return;
    }
#if MCV_WITH_REACH
    const int two_sided = gloss != MCV_NONE && world.materials[gloss].scattering_sides == 2u;
    mcv_select_emitter_rows(world, slot, first, last, class_end[MCV_LAST_DIFFUSE_EXACT],
                            two_sided ? class_end[MCV_LAST_GLOSS]
                                      : class_end[MCV_LAST_DIFFUSE_EXACT]);
#else
    uint chosen[MCV_SLOTS];
    for (uint i = first; i < last; ++i) chosen[i] = i;
    mcv_search_cdf_rows(world.emitter_cdf, world.frame->emitter_count, slot, MCV_PAIR_CHOICE,
                        chosen + first, last - first, emitters + first);
#endif
}
#endif
#endif

#endif
