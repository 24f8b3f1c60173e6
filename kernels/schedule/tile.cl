/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule, for CPUs: one work-item per work-group takes a slice of MCV_SLICE paths
 * through all stages. Their state is private, so that it stays in the core's cache and no other
 * memory sees it. The paths under way lie side by side in the slots 0 … alive - 1, so that a stage
 * is a loop over rows (schedule/vectorize.h). kernels/README.md tells the life of a path.
 */
#include "schedule/tile.h"

#include "world.h"
#include "schedule/begin_paths.h"
#include "schedule/classify_hits.h"
#include "schedule/clock.h"
#include "schedule/intersect_rows.h"
#include "schedule/shade_rows.h"
#include "schedule/shadow_rows.h"
#include "schedule/sort_paths.h"
#include "schedule/terminate_paths.h"
#include "schedule/sample_emitter_rows.h"
#include "stage/guide_pupil.h"
#include "schedule/light_paths.h"

#define MCV_SLICE_KERNEL __kernel __attribute__((reqd_work_group_size(1, 1, 1))) void

#if MCV_WITH_PUPIL_GUIDE
/* One work-item per slice of pixels. */
MCV_SLICE_KERNEL
guide_pupils(MCV_WORLD_PARAMETERS __global mcv_device_pupil_guide *out) {
    MCV_MAKE_WORLD(world)
    const uint first = (uint)get_group_id(0) * MCV_SLICE;
    const uint last = min(first + MCV_SLICE, world.frame->width * world.frame->height);
    for (uint pixel = first; pixel < last; ++pixel) mcv_guide_pupil(world, pixel, out + pixel);
}
#endif

#if MCV_WITH_LIGHT_TRACING
/* One work-item per 2^log2_thinning slices of paths: on average as many light paths as a slice has.
 */
MCV_SLICE_KERNEL
trace_emitter_paths(MCV_WORLD_PARAMETERS __global uint *splats, __global uint *counters) {
    MCV_MAKE_WORLD(world)
    const uint slice = get_group_id(0), count = world.frame->path_count,
               span = (uint)MCV_SLICE << world.frame->log2_thinning;
    uint counts[MCV_COUNTER_COUNT] = {0};
    mcv_trace_light_slices(world, slice * span, min(slice * span + min(span, count), count), splats,
                           counts);
    /* To the counts of render_tile or, where light paths are traced alone, to zeros. */
    for (uint i = 0; i < MCV_COUNTER_COUNT; ++i)
        counters[slice * MCV_COUNTER_COUNT + i] += counts[i];
}
#endif

/*
 * Ends the paths that do not continue. Those that do get the slots 0 … count - 1, with the
 * branches, which lie from `alive` to branch_end; returns their count.
 */
MCV_BATCH uint mcv_compact_paths(mcv_world world, uint *paths, const uint *fate, uint alive,
                                 uint branch_end, float *values, uint *nonfinite) {
    uint flags[MCV_ROW], chosen[MCV_SLOTS];
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(alive); ++i) flags[i] = !(fate[i] & MCV_CONTINUES);
    const uint ended = mcv_compact_indices(flags, alive, chosen);
    if (ended == 0) return branch_end;
    *nonfinite += mcv_terminate_paths(world, paths, chosen, ended, values);
    MCV_VECTORIZE
    for (uint i = 0; i < mcv_fill_lanes(alive); ++i) flags[i] = !flags[i];
    uint count = mcv_compact_indices(flags, alive, chosen);
    for (; alive < branch_end; ++alive) chosen[count++] = alive;
    mcv_move_paths(paths, chosen, count);
    return count;
}

/* What the depth limit cuts. */
MCV_BATCH void mcv_cut_paths(mcv_world world, uint *paths, uint alive, float *values,
                             uint *counts) {
    uint ended[MCV_SLOTS];
    MCV_EACH_PATH (slot, paths, 0, alive) {
        counts[MCV_COUNTER_lost] += mcv_cut_path(slot);
        ended[slot.index] = slot.index;
    }
    counts[MCV_COUNTER_nonfinite] += mcv_terminate_paths(world, paths, ended, alive, values);
    counts[MCV_COUNTER_depth_cut] = alive;
}

MCV_BATCH void mcv_render_slice(mcv_world world, uint slice, __global float *sums,
                                __global uint *counters, __global uint *clocks) {
    const uint first = slice * MCV_SLICE,
               count = min((uint)MCV_SLICE, world.frame->path_count - first);
    MCV_ALIGNED uint paths[MCV_PATH_WORDS * MCV_ROW];
    float values[MCV_CHANNELS * MCV_SLOTS];
    uint classes[MCV_ROW], class_end[MCV_CLASS_COUNT], fate[MCV_ROW], glossy_material;
    uint counts[MCV_COUNTER_COUNT] = {0};
    uint branches = 1; /* that a sample may have by now */
    mcv_slot slot = mcv_slot_at(paths, 0);
#if MCV_WITH_GLOSSY
    mcv_glossy_interaction glossy_interactions[MCV_SLOTS];
    slot.glossy_interactions = glossy_interactions;
#endif
    MCV_CLOCK_BEGIN
    mcv_clear_values(values, 0);
    uint alive = mcv_begin_paths(world, paths, first, count);
    counts[MCV_COUNTER_paths] = alive;
    MCV_CLOCK_STAGE(generate_rays)
    for (uint depth = 0; depth < world.frame->depth && alive > 0; ++depth) {
        counts[MCV_COUNTER_rays] += alive;
        mcv_intersect_paths(world, paths, alive);
        MCV_CLOCK_STAGE(intersect_closest)
        mcv_classify_hits(world, paths, alive, classes, &glossy_material);
        counts[MCV_COUNTER_nonfinite] +=
            mcv_terminate_early(world, paths, classes, alive, depth, values);
        mcv_sort_paths(paths, classes, alive, class_end);
        mcv_find_interactions(world, paths, class_end, glossy_material);
        alive = class_end[MCV_LAST_CLASS];
        if (mcv_needs_choice(world.frame, depth))
            mcv_draw_pairs(paths, 0, alive, depth, MCV_PAIR_CHOICE);
#if MCV_WITH_NEXT_EVENT
        /* An emitter is a surface too: the last surface a path may hit does not sample one. */
        if (depth + 1 < world.frame->depth) {
            uint shadows[MCV_SLOTS];
            const uint shadow_count =
                mcv_sample_emitters(world, slot, class_end, glossy_material, depth, shadows);
            MCV_CLOCK_STAGE(sample_emitters)
            mcv_intersect_shadows(world, paths, shadows, shadow_count);
            MCV_CLOCK_STAGE(intersect_shadow)
            counts[MCV_COUNTER_shadow_rays] += shadow_count;
        }
#endif
        const uint branch_end = mcv_shade_paths(world, slot, class_end, glossy_material, depth,
                                                fate, &counts[MCV_COUNTER_unmatched]);
        /* A path splits at most once at each surface. */
        while (branch_end > alive && branches < min(depth + 2u, (uint)MCV_BRANCHES))
            mcv_clear_values(values, branches++);
        alive = mcv_compact_paths(world, paths, fate, alive, branch_end, values,
                                  &counts[MCV_COUNTER_nonfinite]);
        MCV_CLOCK_STAGE(shade_surfaces)
    }
    mcv_cut_paths(world, paths, alive, values, counts);
    mcv_accumulate_values(world, values, branches, first, count, sums);
    MCV_CLOCK_STAGE(accumulate_film)
    MCV_CLOCK_END(clocks + slice * MCV_CLOCK_COUNT)
    (void)clocks;
    for (uint i = 0; i < MCV_COUNTER_COUNT; ++i)
        counters[slice * MCV_COUNTER_COUNT + i] = counts[i];
}

MCV_SLICE_KERNEL
render_tile(MCV_WORLD_PARAMETERS __global float *sums, __global uint *counters) {
    MCV_MAKE_WORLD(world)
    mcv_render_slice(world, get_group_id(0), sums, counters,
                     counters + get_num_groups(0) * MCV_COUNTER_COUNT);
}
