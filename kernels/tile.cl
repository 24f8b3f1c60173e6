/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The tile schedule, for CPUs: one work-item per work-group takes a slice of MCV_SLICE paths, which stays in its core's
 * cache, through all stages.
 */
#include "world.h"
#if MCV_WITH_AIM
#include "aim_pupils.cl"
#endif
#include "generate_rays.cl"
#include "intersect_closest.cl"
#if MCV_WITH_NEXT_EVENT
#include "sample_emitters.cl"
#include "intersect_shadow.cl"
#endif
#include "shade_surfaces.cl"
#include "accumulate_film.cl"
#include "clock.h"

/*
 * The stages that intersect, over the paths of a slice. Rays that have been scattered take turns where the scene is large; those
 * from the sensor go the same way and find in the cache what the one before fetched.
 */
static void mcv_intersect_paths(mcv_world world, mcv_slot slot, const uint *paths, uint count, uint depth) {
#if MCV_WITH_INTERLEAVE
    if (depth > 0) {
        const mcv_rows origins = MCV_ROWS(slot, origin), directions = MCV_ROWS(slot, direction);
        mcv_hit hits[MCV_SLICE];
        for (uint i = 0; i < count; ++i) hits[i].t = INFINITY;
        mcv_intersect_closest_list(world.nodes, world.leaves, origins, directions, paths, count, hits);
        for (uint i = 0; i < count; ++i) {
            slot.index = paths[i];
            mcv_arrive(world, slot, hits[i]);
        }
        return;
    }
#endif
    (void)depth;
    for (uint i = 0; i < count; ++i) {
        slot.index = paths[i];
        mcv_intersect_closest(world, slot);
    }
}

#if MCV_WITH_NEXT_EVENT
static void mcv_intersect_shadows(mcv_world world, mcv_slot slot, const uint *paths, uint count) {
#if MCV_WITH_INTERLEAVE
    const mcv_rows origins = MCV_ROWS(slot, shadow_origin), directions = MCV_ROWS(slot, shadow_direction);
    for (int any = 0; any < 2; ++any) {
        uint chosen[MCV_SLICE];
        mcv_hit hits[MCV_SLICE];
        uint chosen_count = 0;
        for (uint i = 0; i < count; ++i) {
            slot.index = paths[i];
            if (mcv_shadow_is_any(slot) != any) continue;
            hits[chosen_count].t = any ? 1.0f : INFINITY;
            chosen[chosen_count++] = paths[i];
        }
        if (any)
            mcv_intersect_any_list(world.nodes, world.leaves, origins, directions, chosen, chosen_count, hits);
        else
            mcv_intersect_closest_list(world.nodes, world.leaves, origins, directions, chosen, chosen_count, hits);
        for (uint i = 0; i < chosen_count; ++i) {
            slot.index = chosen[i];
            if (any ? hits[i].triangle == MCV_NONE : mcv_meets_target(world, slot, hits[i])) mcv_add_shadow_light(world, slot, hits[i]);
        }
    }
#else
    for (uint i = 0; i < count; ++i) {
        slot.index = paths[i];
        mcv_intersect_shadow(world, slot);
    }
#endif
}
#endif

#if MCV_WITH_AIM
/* One work-item per slice of pixels. */
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void aim_pupils(MCV_WORLD_PARAMETERS __global mcv_device_aim *out) {
    MCV_MAKE_WORLD(world)
    const uint first = (uint)get_group_id(0) * MCV_SLICE;
    const uint last = min(first + MCV_SLICE, world.frame->width * world.frame->height);
    for (uint pixel = first; pixel < last; ++pixel) mcv_aim_pupil(world, pixel, out + pixel);
}
#endif

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
    MCV_CLOCK_BEGIN

    for (uint i = 0; i < count; ++i) {
        slot.index = i;
        if (mcv_generate_ray(world, slot, mcv_identify(world.frame, first + i))) active[alive++] = i;
    }
    counts[MCV_COUNTER_paths] = alive;
    MCV_CLOCK_STAGE(generate_rays)
    for (uint depth = 0; depth < world.frame->depth && alive > 0; ++depth) {
        counts[MCV_COUNTER_rays] += alive;
        mcv_intersect_paths(world, slot, active, alive, depth);
        MCV_CLOCK_STAGE(intersect_closest)
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
            MCV_CLOCK_STAGE(sample_emitters)
            mcv_intersect_shadows(world, slot, shadows, shadow_count);
            MCV_CLOCK_STAGE(intersect_shadow)
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
        MCV_CLOCK_STAGE(shade_surfaces)
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
    MCV_CLOCK_STAGE(accumulate_film)
    MCV_CLOCK_END(counters + get_num_groups(0) * MCV_COUNTER_COUNT + slice * MCV_CLOCK_COUNT)
    for (uint i = 0; i < MCV_COUNTER_COUNT; ++i) counters[slice * MCV_COUNTER_COUNT + i] = counts[i];
}
