/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stage: what a surface does to a path. Adds what it emits, then chooses how the path goes on. Each
 * path is continued or ended exactly once.
 */
#ifndef MCVISI_KERNELS_SHADE_HIT_H
#define MCVISI_KERNELS_SHADE_HIT_H

#include "path/identity.h"
#include "stage/roulette.h"
#include "stage/shade_emission.h"
#include "stage/split_path.h"

/* How a path continues from a surface, and whether it does. */
typedef struct mcv_shaded {
    mcv_scattering on;
    mcv_color throughput;
    mcv_split split; /* where it splits */
    uint fate; /* MCV_CONTINUES | MCV_SPLITS, or MCV_UNSHADED: the class does not hold this surface,
                  mcv_shade_surface does */
} mcv_shaded;

/* Chooses how a path continues from the surface that it has met: scattering, splitting, Russian
 * roulette. */
MCV_LOOP_FUNCTION mcv_shaded mcv_shade_hit(mcv_world world, mcv_slot slot,
                                           const mcv_interaction *interaction, mcv_shading shading,
                                           uint depth, uint *unmatched) {
    mcv_shaded shaded;
    mcv_scattering other;
    int unshaded = 0;
    const mcv_pair pair = mcv_draw(slot, depth, MCV_PAIR_SCATTER),
                   choice = mcv_draw_choice(world, slot, depth);
    shaded.throughput = mcv_path_throughput(slot);
    shaded.fate = 0u;
    shaded.on = mcv_scatter_as(world, slot, interaction, shading, pair, choice.x,
                               mcv_may_split(slot), unmatched, &other, &unshaded);
    if (MCV_WITH_SPLIT &&
        (shading.kind == MCV_SHADING_ANY ? other.chance > 0.0f : shading.may_split)) {
        shaded.split = mcv_split_path(
            slot, shaded.on.event == MCV_EVENT_NON_SPECULAR ? shaded.on.remainder : pair.x,
            shaded.throughput, shaded.on, other);
        shaded.on = shaded.split.on;
        MCV_WORD(slot, branch_number, 0) += (uint)shaded.split.splits;
        shaded.fate = shaded.split.branch_lives ? MCV_SPLITS : 0u;
    }
    shaded.throughput = mcv_tint(shaded.throughput, shaded.on.factor);
    const mcv_roulette roulette =
        mcv_play_roulette(depth >= MCV_ROULETTE_DEPTH, mcv_brightest(shaded.throughput),
                          MCV_ROULETTE_WEIGHT, choice.y);
    shaded.throughput = mcv_after_roulette(roulette, shaded.throughput);
    shaded.fate |= roulette.survives ? MCV_CONTINUES : 0u;
    shaded.fate = unshaded ? MCV_UNSHADED : shaded.fate;
    return shaded;
}

/* MCV_CONTINUES: the path, which has met a surface, does; MCV_SPLITS: so does a branch, in the slot
 * beside. */
static uint mcv_shade_surface(mcv_world world, mcv_slot slot, mcv_slot beside, uint depth,
                              uint *unmatched) {
    world = mcv_disperse(world, slot);
    const mcv_interaction interaction = mcv_make_interaction(world, slot);
#if MCV_HAS_EMISSION
    mcv_shade_emitter_hit(world, slot, interaction);
#endif
    mcv_keep_selection(slot);
    const mcv_shaded shaded =
        mcv_shade_hit(world, slot, &interaction, mcv_any_shading(), depth, unmatched);
    if (MCV_WITH_SPLIT && (shaded.fate & MCV_SPLITS))
        mcv_start_branch(world, slot, beside, &interaction, shaded.split);
    if (shaded.fate & MCV_CONTINUES)
        mcv_continue_path(world, slot, &interaction, mcv_any_shading(), shaded.on,
                          shaded.throughput, 0);
    return shaded.fate;
}

/* What the depth limit cuts of the path. */
MCV_FUNCTION uint mcv_cut_path(mcv_slot slot) {
    return mcv_lost_energy(mcv_brightest(mcv_path_throughput(slot)));
}

#endif
