/* SPDX-License-Identifier: Apache-2.0 */
/* Path splitting at glass, sheets and beam splitters: the path takes one lobe, a branch the other.
 */
#ifndef MCVISI_KERNELS_SPLIT_PATH_H
#define MCVISI_KERNELS_SPLIT_PATH_H

#include "stage/continue_path.h"
#include "stage/roulette.h"

/*
 * By which factor more often than by its chance the less likely lobe is followed, e below. That
 * lobe contributes little where all emitters are narrow; wide ones may be met in any direction.
 */
#define MCV_SPLIT_EFFORT \
    (MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE || MCV_WITH_AREA || MCV_WITH_LIGHT_FIELD \
         ? 8.0f \
         : 1.0f)

MCV_LOOP_FUNCTION int mcv_may_split(mcv_slot slot) {
    return MCV_WITH_SPLIT && MCV_WORD(slot, branch_number, 0) + 1u < MCV_BRANCHES;
}

/* The result of splitting. */
typedef struct mcv_split {
    mcv_scattering on, other; /* the path's and the branch's lobe, */
    mcv_color carried;        /* what the branch carries, */
    int splits, branch_lives; /* and whether there are both */
} mcv_split;

/*
 * The path takes the likelier of two lobes instead of the chosen one, and a branch takes the other.
 * Their chances are p >= q, p + q = 1, and what comes along them is P and Q. Without splitting the
 * path finds P with the chance p, else Q: p P + q Q on average, which is R + T.
 *
 * The branch lives with the chance l = min(1, q max(1, e w)), w the path's mean throughput. Path
 * and branch then bring
 *
 *     p P + (q/l) Q, if xi < l;     p P otherwise
 *
 * Under an environment P and Q are about the same, and what is carried shall not depend on xi.
 * Where l < 1 they bring
 *
 *     (1 - q/l) P + (q/l) Q, if xi < l;     P otherwise
 *
 * The mean of both is p P + q Q again. xi: the number that has chosen the lobe, or its remainder;
 * it has no other use any more.
 */
MCV_LOOP_FUNCTION mcv_split mcv_split_path(mcv_slot slot, float xi, mcv_color throughput,
                                           mcv_scattering on, mcv_scattering other) {
    mcv_split split;
    const int swaps = (other.chance > on.chance) |
                      ((other.chance == on.chance) & (other.event == MCV_EVENT_REFLECT));
    const mcv_scattering likelier = mcv_either_scattering(swaps, other, on);
    split.other = mcv_either_scattering(swaps, on, other);
    const float effort = MCV_SPLIT_EFFORT * mcv_average(throughput);
    const float wanted = split.other.chance * (effort > 1.0f ? effort : 1.0f);
    const float lives = wanted < 1.0f ? wanted : 1.0f;
    float weight = likelier.chance;
    split.splits = (other.chance > 0.0f) & mcv_may_split(slot);
    if (MCV_WITH_ENVIRONMENT || MCV_WITH_ENVIRONMENT_IMAGE) {
        /* No splitting where a part would carry less than the weight at which roulette begins: its
         * noise is more than that of one lobe, which finds an even environment without any. */
        const float branch_weight = split.other.chance / lives,
                    goes_on = lives < 1.0f ? 1.0f - branch_weight : likelier.chance;
        const float least =
            mcv_brightest(throughput) * (goes_on < branch_weight ? goes_on : branch_weight);
        split.splits &= !(least < MCV_ROULETTE_WEIGHT * (1.0f - 8.0f * MCV_UNIT_ROUNDOFF));
        weight = lives < 1.0f ? xi < lives ? goes_on : 1.0f : weight;
    }
    split.on = mcv_either_scattering(split.splits, likelier, on);
    split.on.factor = mcv_dim(split.on.factor, split.splits ? weight : 1.0f);
    split.carried = mcv_dim(mcv_tint(throughput, split.other.factor), split.other.chance / lives);
    split.branch_lives = split.splits & (xi < lives) & (mcv_brightest(split.carried) > 0.0f);
    return split;
}

/* What mcv_continue_branch asks for, in branch_state. */
MCV_LOOP_FUNCTION void mcv_store_split(mcv_slot slot, mcv_split split) {
    MCV_STORE_3(slot, branch_state, split.other.direction);
    MCV_WORD(slot, branch_state, 3) = split.other.media;
    MCV_STORE(slot, branch_state, 4, split.other.density);
    MCV_EACH_CHANNEL(c) MCV_STORE(slot, branch_state, 5 + c, split.carried.c[c]);
}

MCV_LOOP_FUNCTION mcv_split mcv_load_split(mcv_slot slot) {
    mcv_split split;
    split.other.direction = MCV_LOAD_3(slot, branch_state);
    split.other.media = MCV_WORD(slot, branch_state, 3);
    split.other.density = MCV_LOAD(slot, branch_state, 4);
    split.other.event = MCV_EVENT_NON_SPECULAR;
    MCV_EACH_CHANNEL(c) split.carried.c[c] = MCV_LOAD(slot, branch_state, 5 + c);
    return split;
}

/* A copy of a path becomes its branch: it has its own random numbers, no radiance so far, and the
 * other lobe. */
MCV_LOOP_FUNCTION void mcv_continue_branch(mcv_world world, mcv_slot slot,
                                           const mcv_interaction *interaction, mcv_shading shading,
                                           mcv_split split) {
    const uint number = MCV_WORD(slot, branch_number, 0);
    MCV_WORD(slot, branch_number, 0) = MCV_BRANCHES + number;
    MCV_WORD(slot, stream, 0) = mcv_hash_2(MCV_WORD(slot, stream, 0), number);
    MCV_EACH_CHANNEL(i) MCV_STORE(slot, radiance, i, 0.0f);
    mcv_continue_path(world, slot, interaction, shading, split.other, split.carried, 0);
    if (MCV_OFFSETS_TOGETHER) {
        const mcv_vec3 origin = mcv_onward_origin(*interaction, split.other.direction);
        MCV_STORE_3(slot, origin, origin);
    }
}

/* The branch begins in the slot beside; the path has not continued yet. */
MCV_FUNCTION void mcv_start_branch(mcv_world world, mcv_slot slot, mcv_slot beside,
                                   const mcv_interaction *interaction, mcv_split split) {
    for (uint word = 0; word < MCV_PATH_hit; ++word) {
        const uint row = word * MCV_CAPACITY(slot);
        beside.base[row + beside.index] = slot.base[row + slot.index];
    }
    if (MCV_WITH_MIXED) MCV_WORD(beside, hit, 0) = MCV_WORD(slot, hit, 0);
    mcv_continue_branch(world, beside, interaction, mcv_any_shading(), split);
}

#endif
