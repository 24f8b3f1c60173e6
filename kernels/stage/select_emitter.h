/* SPDX-License-Identifier: Apache-2.0 */
/* Which emitter a surface that a path has met samples: part of stage sample_emitters. */
#ifndef MCVISI_KERNELS_SELECT_EMITTER_H
#define MCVISI_KERNELS_SELECT_EMITTER_H

#include "geometry/path_interaction.h"
#include "light/mis.h"
#include "light/selection.h"
#include "light/tree.h"
#include "path/identity.h"
#include "stage/receiver_lobe.h"

#if MCV_WITH_NEXT_EVENT
/* The surrogate by which MIS weighs emitters at the surface that the path has met. */
MCV_LOOP_FUNCTION void mcv_put_selection(mcv_slot slot, mcv_light_selection selection) {
    MCV_STORE(slot, selection_here, 0, selection.mis_scale);
    MCV_STORE(slot, selection_here, 1, selection.mis_least);
}

#if MCV_WITH_LIGHT_TREE
/* The normal by which a walk through the light tree weighs emitters. */
MCV_LOOP_FUNCTION mcv_vec3 mcv_walking_normal(mcv_vec3 normal, uint sides) {
    return mcv_either(sides == 2u, mcv_vec(0.0f, 0.0f, 0.0f), normal);
}

/* The same as mcv_put_selection, of a choice by the light tree. */
MCV_LOOP_FUNCTION void mcv_put_walk(mcv_slot slot, mcv_vec3 normal, float ratio) {
    MCV_STORE_3(slot, selection_here, normal);
    MCV_STORE(slot, selection_here, 3, ratio);
}
#endif

/* One of the emitters, or MCV_NONE. */
MCV_FUNCTION uint mcv_pick_emitter(mcv_world world, mcv_slot slot, uint depth) {
    if (MCV_WORD(slot, hit, 3) == MCV_NONE) return MCV_NONE;
    const uint material = world.instances[mcv_hit_instance(world, slot)].material;
    if (!world.materials[material].scattering_sides) return MCV_NONE;
    if (world.frame->emitter_count == 1u) return 0u; /* whose number may not have been drawn */
    const mcv_pair choice = mcv_draw(slot, depth, MCV_PAIR_CHOICE);
    if (!(MCV_WITH_REACH | MCV_WITH_LIGHT_TREE))
        return mcv_search_cdf(world.emitter_cdf, world.frame->emitter_count,
                              mcv_cdf_bits(choice.x, choice.y));
    const uint sides = world.materials[material].scattering_sides;
    const mcv_interaction interaction = mcv_make_interaction(world, slot);
    const mcv_vec3 point = interaction.surface.point, ng = interaction.ng, ns = interaction.ns;
#if MCV_WITH_LIGHT_TREE
    float ratio;
    const mcv_vec3 side = mcv_walking_normal(ns, sides);
    const uint emitter = mcv_select_by_tree(world, point, side, choice.x, choice.y, &ratio);
    mcv_put_walk(slot, side, ratio);
    (void)ng;
#else
    mcv_light_selection selection;
    mcv_receiver_lobe lobe = mcv_even_lobe();
    float chance;
#if MCV_WITH_REACH && MCV_WITH_GLOSSY
    lobe = mcv_receiver_lobe_at(world, slot, &interaction);
#endif
    const uint emitter = mcv_select_emitter(world, point, ng, ns, sides, interaction.direction,
                                            lobe, choice.x, &selection, &chance);
    mcv_put_selection(slot, selection);
    if (MCV_WITH_REACH && MCV_WITH_GLOSSY) MCV_STORE(slot, selection_here, 2, chance);
#endif
    return emitter;
}

/* The emitter that the path samples, or MCV_NONE. */
MCV_FUNCTION uint mcv_choose_emitter(mcv_world world, mcv_slot slot, uint depth) {
    const uint emitter = mcv_pick_emitter(world, slot, depth);
    if (emitter == MCV_NONE) return MCV_NONE;
    const uint material = world.instances[mcv_hit_instance(world, slot)].material;
    return mcv_leaves_to_light_paths(world, slot, emitter,
                                     (int)world.materials[material].near_specular)
               ? MCV_NONE
               : emitter;
}
#endif

#endif
