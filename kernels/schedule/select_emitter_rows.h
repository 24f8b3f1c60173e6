/* SPDX-License-Identifier: Apache-2.0 */
/* The tile schedule's loops that choose an emitter for each path: the steps of light/discrete.h and
 * light/tree.h, step by step or digit by digit. */
#ifndef MCVISI_KERNELS_SELECT_EMITTER_ROWS_H
#define MCVISI_KERNELS_SELECT_EMITTER_ROWS_H

#include "schedule/tile.h"

#include "schedule/ranges.h"
#include "schedule/reach_rows.h"
#include "schedule/vectorize.h"
#include "stage/sample_emitters.h"

#if MCV_WITH_NEXT_EVENT
#if MCV_HAS_EMISSION || (MCV_HAS_PLAIN && !MCV_WITH_REACH && !MCV_WITH_LIGHT_TREE)
/* mcv_search_cdf for the chosen paths, by the numbers drawn for a pair. */
MCV_BATCH void mcv_search_cdf_rows(__global const uint *cdf, uint count, mcv_slot slot, uint use,
                                   const uint *chosen, uint chosen_count, uint *found) {
    for (uint i = 0; i < chosen_count; ++i) found[i] = 0;
    for (uint digit = mcv_cdf_digit(count); digit > 0; digit /= 2) {
        MCV_VECTORIZE
        for (uint i = 0; i < chosen_count; ++i) {
            slot.index = chosen[i];
            const mcv_pair drawn = mcv_drawn(slot, use);
            found[i] = mcv_cdf_step(cdf, count, found[i], digit, mcv_cdf_bits(drawn.x, drawn.y));
        }
    }
}
#endif

#if MCV_WITH_LIGHT_TREE
/* The walks of a slice's paths. */
typedef struct mcv_walk_rows {
    uint nodes[MCV_ROW], trails[MCV_ROW], follows[MCV_ROW];
    float numbers[MCV_ROW], chances[MCV_ROW];
} mcv_walk_rows;

MCV_LOOP_FUNCTION mcv_light_walk mcv_walk_in(const mcv_walk_rows *rows, uint i) {
    mcv_light_walk walk;
    walk.node = rows->nodes[i];
    walk.trail = rows->trails[i];
    walk.follows = (int)rows->follows[i];
    walk.xi = rows->numbers[i];
    walk.chance = rows->chances[i];
    return walk;
}

MCV_LOOP_FUNCTION void mcv_keep_walk(mcv_walk_rows *rows, uint i, mcv_light_walk walk) {
    rows->nodes[i] = walk.node;
    rows->trails[i] = walk.trail;
    rows->follows[i] = (uint)walk.follows;
    rows->numbers[i] = walk.xi;
    rows->chances[i] = walk.chance;
}

/* Begins the walks of the paths in the slots first … last - 1. */
MCV_BATCH void mcv_begin_walks(mcv_world world, mcv_slot slot, uint first, uint last,
                               mcv_walk_rows *walks) {
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_pair choice = mcv_drawn(slot, MCV_PAIR_CHOICE);
        mcv_keep_walk(walks, i, mcv_begin_walk(world, choice.x, choice.y));
    }
}

/* mcv_select_by_tree for the paths in the slots first … last - 1, step by step; sides as in
 * mcv_select_by_reach_rows. */
MCV_BATCH void mcv_select_by_tree_rows(mcv_world world, mcv_slot slot, uint first, uint last,
                                       const uint *sides) {
    mcv_walk_rows walks;
    mcv_begin_walks(world, slot, first, last, &walks);
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        mcv_put_walk(slot, mcv_walking_normal(MCV_LOAD_3(slot, ns), sides[i]), 0.0f);
        MCV_STORE_COLOR(slot, shadow_light, mcv_grey(0.0f));
    }
    for (uint level = 0; level < world.frame->light_tree_depth; ++level) {
        MCV_VECTORIZE_MASKED
        for (uint i = first; i < last; ++i) {
            slot.index = i;
            mcv_keep_walk(&walks, i,
                          mcv_walk_on(world, mcv_walk_in(&walks, i), MCV_LOAD_3(slot, point),
                                      MCV_LOAD_3(slot, selection_here)));
        }
    }
    MCV_VECTORIZE
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const mcv_light_walk walk = mcv_walk_in(&walks, i);
        const uint emitter = mcv_emitter_of(world, walk);
        MCV_WORD(slot, emitter, 0) = emitter;
        MCV_STORE(slot, selection_here, 3,
                  mcv_walk_ratio(world, emitter == MCV_NONE ? 0u : emitter, walk));
    }
}
#endif

#if MCV_WITH_REACH || MCV_WITH_LIGHT_TREE
/* By the light tree where the scene has one, else by what reaches surfaces without lobes. */
MCV_FUNCTION void mcv_select_rows(mcv_world world, mcv_slot slot, uint first, uint last,
                                  const uint *sides) {
#if MCV_WITH_LIGHT_TREE
    mcv_select_by_tree_rows(world, slot, first, last, sides);
#else
    mcv_select_by_reach_rows(world, slot, first, last, sides);
#endif
}

/* mcv_choose_emitter for the paths in the slots first … last - 1 on surfaces of any kind. */
MCV_BATCH void mcv_select_any_emitters(mcv_world world, mcv_slot slot, uint first, uint last) {
    uint materials[MCV_ROW], sides[MCV_ROW];
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const int met = MCV_WORD(slot, hit, 3) != MCV_NONE;
        materials[i] = met ? world.instances[mcv_hit_instance(world, slot)].material : 0u;
        sides[i] = met ? world.materials[materials[i]].scattering_sides : 0u;
    }
#if MCV_WITH_REACH && MCV_WITH_GLOSSY
    for (uint begin = first; begin < last; begin += MCV_SELECTION_BLOCK) {
        const uint end = min(begin + MCV_SELECTION_BLOCK, last);
        mcv_lobe_rows lobes;
        for (uint i = begin; i < end; ++i) {
            slot.index = i;
            const mcv_interaction interaction = mcv_make_interaction(world, slot);
            mcv_keep_lobe(&lobes, i - begin,
                          sides[i] == 0u ? mcv_even_lobe()
                                         : mcv_receiver_lobe_at(world, slot, &interaction));
        }
        mcv_select_glossy_block(world, slot, begin, end, sides, &lobes);
    }
#else
    if (first < last) mcv_select_rows(world, slot, first, last, sides);
#endif
    for (uint i = first; i < last; ++i) {
        slot.index = i;
        const uint emitter = MCV_WORD(slot, emitter, 0);
        const int near_specular = (int)world.materials[materials[i]].near_specular;
        const int leaves =
            emitter == MCV_NONE || mcv_leaves_to_light_paths(world, slot, emitter, near_specular);
        MCV_WORD(slot, emitter, 0) = sides[i] == 0u || leaves ? MCV_NONE : emitter;
    }
}
#else
/* The depth does not matter: the pairs are drawn. */
MCV_BATCH void mcv_select_any_emitters(mcv_world world, mcv_slot slot, uint first, uint last) {
    for (slot.index = first; slot.index < last; ++slot.index)
        MCV_WORD(slot, emitter, 0) = mcv_choose_emitter(world, slot, 0);
}
#endif

#if MCV_HAS_PLAIN
/* mcv_pick_emitter for the paths on plain surfaces. What these leave to light paths is left out
 * where they make shadow rays (mcv_respond_as). */
MCV_BATCH void mcv_select_plain_emitters(mcv_world world, mcv_slot slot, const uint *class_end,
                                         uint glossy_material) {
    const uint first = class_end[MCV_LAST_SMOOTH], last = class_end[MCV_LAST_KNOWN];
    uint *emitters = slot.base + MCV_PATH_emitter * MCV_ROW;
    (void)glossy_material;
    if (world.frame->emitter_count == 1u) {
        for (uint i = first; i < last; ++i) emitters[i] = 0u;
        return;
    }
#if MCV_WITH_REACH && MCV_WITH_GLOSSY
    uint sides[MCV_ROW];
    const uint glossy_first = class_end[MCV_LAST_DIFFUSE_EXACT],
               glossy_last = class_end[MCV_LAST_GLOSSY],
               glossy_sides = glossy_material != MCV_NONE
                                  ? world.materials[glossy_material].scattering_sides
                                  : 1u;
    for (uint i = first; i < last; ++i)
        sides[i] = i >= glossy_first && i < glossy_last ? glossy_sides : 1u;
    mcv_select_by_reach_rows(world, slot, first, glossy_first, sides);
    mcv_select_by_reach_rows(world, slot, glossy_last, last, sides);
#define MCV_SELECT(bsdf, begin, end, shading) \
    if (bsdf == MCV_SHADING_GLOSSY) \
        mcv_select_glossy_range(world, slot, begin, end, shading, sides);
    MCV_EACH_RANGE(MCV_SELECT)
#undef MCV_SELECT
#elif MCV_WITH_REACH || MCV_WITH_LIGHT_TREE
    uint sides[MCV_ROW];
    const uint glossy_sides =
        glossy_material != MCV_NONE ? world.materials[glossy_material].scattering_sides : 1u;
    for (uint i = first; i < last; ++i)
        sides[i] = i >= class_end[MCV_LAST_DIFFUSE_EXACT] && i < class_end[MCV_LAST_GLOSSY]
                       ? glossy_sides
                       : 1u;
    mcv_select_rows(world, slot, first, last, sides);
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
