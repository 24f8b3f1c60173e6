/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule's light paths: its loops over the rows of a slice, of the stages of camera
 * paths and of mcv_connect_light_path and mcv_continue_light_path.
 */
#ifndef MCVISI_KERNELS_LIGHT_PATHS_H
#define MCVISI_KERNELS_LIGHT_PATHS_H

#include "schedule/tile.h"

#include "schedule/begin_light_paths.h"
#include "schedule/classify_hits.h"
#include "schedule/intersect_rows.h"
#include "schedule/ranges.h"
#include "schedule/shade_rows.h"
#include "schedule/sort_paths.h"
#include "schedule/surface_rows.h"
#include "schedule/vectorize.h"
#include "stage/trace_light_path.h"

#if MCV_WITH_LIGHT_TRACING
#if MCV_LIGHT_ROWS
/* The paths end that have met nothing or what absorbs all, or come straight from the emitter to a
 * diffuse surface; the others lie in the order of what they have met. */
MCV_BATCH void mcv_classify_light_hits(mcv_world world, mcv_slot slot, uint count, uint *class_end,
                                       uint *glossy_material) {
    uint classes[MCV_ROW];
    mcv_classify_hits(world, slot.base, count, classes, glossy_material);
    MCV_VECTORIZE
    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        const uint class = classes[i];
        const int diffuse =
            (class == MCV_CLASS_DIFFUSE_TRIANGLE) | (class == MCV_CLASS_DIFFUSE_EXACT);
        /* It would end there: mcv_continue_light_path. */
        const int ends = diffuse & mcv_is_left_to_next_event(MCV_WORD(slot, light_flags, 0));
        classes[i] = (ends | (class >= MCV_CLASS_BLACK)) ? (uint)MCV_CLASS_MISS : class;
        MCV_STORE(slot, light_length, 0, MCV_LOAD(slot, light_length, 0) + MCV_LOAD(slot, hit, 0));
    }
    mcv_sort_paths(slot.base, classes, count, class_end);
    mcv_find_interactions(world, slot.base, class_end, *glossy_material);
}

/* Connects the paths on scattering surfaces to the lens, and adds that to the film. */
MCV_BATCH void mcv_splat_light_paths(mcv_world world, mcv_slot slot, uint first, uint last,
                                     uint depth, __global uint *splats,
                                     uint counts[MCV_COUNTER_COUNT]) {
    for (slot.index = first; slot.index < last; ++slot.index)
        mcv_splat_light_path(world, mcv_make_interaction(world, slot), mcv_load_light_path(slot),
                             MCV_WORD(slot, light_replicate, 0), depth,
                             mcv_draw(slot, depth, MCV_PAIR_LIGHT_LENS),
                             mcv_draw(slot, depth, MCV_PAIR_CHOICE).x, splats, counts);
}

/* Sends the paths on from the surfaces that they have met; returns how many go on. */
MCV_BATCH uint mcv_shade_light_hits(mcv_world world, mcv_slot slot, const uint *class_end,
                                    uint glossy_material, uint depth, uint *unmatched) {
    const uint alive = class_end[MCV_LAST_CLASS], smooth = class_end[MCV_LAST_SMOOTH];
    uint fate[MCV_SLOTS], chosen[MCV_SLOTS];
    mcv_shade_ranges(world, slot.base, class_end, glossy_material, 1, depth, fate, unmatched);
    for (slot.index = smooth; slot.index < alive; ++slot.index) {
        if (fate[slot.index] != MCV_UNSHADED) continue;
        mcv_light_path path = mcv_load_light_path(slot);
        fate[slot.index] = (uint)mcv_shade_any_light_hit(
            world, mcv_make_interaction(world, slot), mcv_draw(slot, depth, MCV_PAIR_SCATTER),
            mcv_draw(slot, depth, MCV_PAIR_CHOICE), depth, unmatched, &path);
        mcv_store_light_path(slot, path);
    }
    mcv_offset_origins(world, slot.base, alive);
    const uint next = mcv_compact_indices(fate, alive, chosen);
    if (next < alive) mcv_move_paths(slot.base, chosen, next);
    return next;
}

/* The light paths of the launch's paths first … last - 1. */
MCV_BATCH void mcv_trace_light_slices(mcv_world world, uint first, uint last, __global uint *splats,
                                      uint counts[MCV_COUNTER_COUNT]) {
    MCV_ALIGNED uint paths[MCV_PATH_WORDS * MCV_ROW];
    uint class_end[MCV_CLASS_COUNT], glossy_material;
    mcv_slot slot;
    slot.base = paths;
#if MCV_WITH_GLOSSY
    mcv_glossy_interaction glossy_interactions[MCV_SLOTS];
    slot.glossy_interactions = glossy_interactions;
#endif
    while (first < last) {
        uint alive = mcv_fill_light_slice(world, slot, &first, last);
        for (uint depth = 1; depth < world.frame->depth && alive > 0; ++depth) {
            counts[MCV_COUNTER_rays] += alive;
            mcv_intersect_paths(world, paths, alive);
            mcv_classify_light_hits(world, slot, alive, class_end, &glossy_material);
            alive = class_end[MCV_LAST_CLASS];
            mcv_draw_pairs(paths, 0, alive, depth, MCV_PAIR_CHOICE);
            mcv_draw_pairs(paths, class_end[MCV_LAST_SMOOTH], alive, depth, MCV_PAIR_LIGHT_LENS);
            mcv_splat_light_paths(world, slot, class_end[MCV_LAST_SMOOTH], alive, depth, splats,
                                  counts);
            mcv_draw_pairs(paths, 0, alive, depth, MCV_PAIR_SCATTER);
#if MCV_WITH_DIFFUSE
            mcv_sample_diffuse_directions(paths, class_end[MCV_LAST_SMOOTH], alive);
#endif
            alive = mcv_shade_light_hits(world, slot, class_end, glossy_material, depth,
                                         &counts[MCV_COUNTER_unmatched]);
        }
        counts[MCV_COUNTER_depth_cut] += alive;
        for (slot.index = 0; slot.index < alive; ++slot.index)
            counts[MCV_COUNTER_lost] += mcv_cut_light(mcv_path_throughput(slot));
    }
}
#else
MCV_BATCH void mcv_trace_light_slices(mcv_world world, uint first, uint last, __global uint *splats,
                                      uint counts[MCV_COUNTER_COUNT]) {
    for (; first < last; ++first) mcv_trace_light_path(world, first, splats, counts);
}
#endif
#endif

#endif
