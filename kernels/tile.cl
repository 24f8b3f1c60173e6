/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule, for CPUs: one work-item per work-group takes a slice of MCV_SLICE paths, which stays in its core's
 * cache, through all stages.
 */
#include "world.h"
#include "generate_rays.cl"
#include "intersect_closest.cl"
#if MCV_WITH_NEXT_EVENT
#include "sample_emitters.cl"
#include "intersect_shadow.cl"
#endif
#include "shade_surfaces.cl"
#include "accumulate_film.cl"

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void render_tile(MCV_WORLD_PARAMETERS __global uint *paths, __global float *sums,
                                                                         __global uint *counters) {
    MCV_MAKE_WORLD(world)
    const uint slice = get_group_id(0);
    const uint first = slice * MCV_SLICE;
    const uint count = min((uint)MCV_SLICE, world.frame->path_count - first);
    uint active[MCV_SLICE];
    uint counts[MCV_COUNTER_COUNT] = {0};
    uint alive = 0;
    mcv_slot slot;
    slot.base = paths + (size_t)slice * (MCV_PATH_WORDS * MCV_SLICE);
    slot.capacity = MCV_SLICE;

    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        if (mcv_generate_ray(world, slot, mcv_identify(world.frame, first + i))) active[alive++] = i;
    }
    counts[MCV_COUNTER_paths] = alive;
    for (uint depth = 0; depth < world.frame->depth && alive > 0; ++depth) {
        counts[MCV_COUNTER_rays] += alive;
        for (uint a = 0; a < alive; ++a) {
            slot.index = active[a];
            mcv_intersect_closest(world, slot);
        }
#if MCV_WITH_NEXT_EVENT
        /* An emitter is a surface too: the last surface a path may meet does not look for one. */
        if (depth + 1 < world.frame->depth) {
            uint shadows[MCV_SLICE];
            uint shadow_count = 0;
            for (uint a = 0; a < alive; ++a) {
                slot.index = active[a];
                if (mcv_sample_emitter(world, slot, mcv_identify(world.frame, first + slot.index), depth))
                    shadows[shadow_count++] = slot.index;
            }
            for (uint s = 0; s < shadow_count; ++s) {
                slot.index = shadows[s];
                mcv_intersect_shadow(world, slot);
            }
            counts[MCV_COUNTER_shadow_rays] += shadow_count;
        }
#endif
        uint next = 0;
        for (uint a = 0; a < alive; ++a) {
            slot.index = active[a];
            if (mcv_shade_surface(world, slot, mcv_identify(world.frame, first + slot.index), depth, &counts[MCV_COUNTER_unmatched])) {
                active[next++] = slot.index;
            }
        }
        alive = next;
    }

    for (uint a = 0; a < alive; ++a) {
        slot.index = active[a];
        counts[MCV_COUNTER_lost] += mcv_lost_energy(slot);
    }
    counts[MCV_COUNTER_depth_cut] = alive;

    const uint block = min((uint)MCV_BLOCK, 1u << world.frame->log2_samples);
    for (slot.index = 0; slot.index < count; slot.index += block) {
        mcv_accumulate_block(world, slot, block, sums + (size_t)((first + slot.index) / block) * (2 * MCV_CHANNELS),
                             &counts[MCV_COUNTER_nonfinite]);
    }
    for (uint i = 0; i < MCV_COUNTER_COUNT; ++i) counters[slice * MCV_COUNTER_COUNT + i] = counts[i];
}
