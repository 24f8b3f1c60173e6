/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The stream schedule, for GPUs: one launch per stage and depth over a frame's paths that live.
 * Queues hold the slots of the paths that a stage has work for. The host learns their lengths
 * MCV_DEPTHS_AHEAD depths late and launches at least as many work-items as there are paths; what it
 * launches beyond them ends at once. A work-group appends its paths together,
 * so that neighbours in a queue are near to each other in memory. The order in a queue does not
 * matter: a path writes its own slot and that of its new branch.
 *
 * Queue 0 and 1: active paths of even and odd depths; queue 2: shadow rays. lengths[d]: active
 * paths at depth d; after the frame's depth + 1 of them, shadow rays at each depth.
 */
#include "world.h"
#include "stage/guide_pupil.h"
#include "stage/generate_rays.h"
#include "stage/intersect_closest.h"
#include "stage/sample_emitters.h"
#include "stage/intersect_shadow.h"
#include "stage/shade_hit.h"
#include "stage/accumulate_film.h"
#include "stage/trace_light_path.h"

#define MCV_STREAM_GROUP 64
#define MCV_STAGE_KERNEL(stage) \
    __kernel __attribute__((reqd_work_group_size(MCV_STREAM_GROUP, 1, 1))) void stage( \
        MCV_WORLD_PARAMETERS __global uint *paths, __global float *sums, __global uint *counters, \
        __global uint *queues, __global uint *lengths, uint capacity, uint depth)
#define MCV_ACTIVE(d) (queues + (size_t)((d)&1u) * capacity)
#define MCV_SHADOWS (queues + (size_t)2 * capacity)
#define MCV_SHADOW_LENGTH(d) lengths[world.frame->depth + 1u + (d)]

MCV_FUNCTION mcv_slot mcv_stream_slot(__global uint *paths, uint capacity, uint index) {
    mcv_slot slot;
    slot.base = paths;
    slot.capacity = capacity;
    slot.index = index;
    return slot;
}

/*
 * Appends the paths of the work-group's items that go on to a queue: one addition to its length for
 * all of them. To be called by all items or by none; room: two words that they share.
 */
MCV_FUNCTION void mcv_append(__global uint *queue, __global uint *length, uint path, int goes_on,
                             __local uint *room) {
    uint place = 0;
    if (get_local_id(0) == 0) room[0] = 0;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (goes_on) place = atomic_inc(&room[0]);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0 && room[0] > 0) room[1] = atomic_add(length, room[0]);
    barrier(CLK_LOCAL_MEM_FENCE);
    if (goes_on) queue[room[1] + place] = path;
}

#if MCV_WITH_PUPIL_GUIDE
/* One work-item per pixel. */
__kernel __attribute__((reqd_work_group_size(MCV_STREAM_GROUP, 1, 1))) void
guide_pupils(MCV_WORLD_PARAMETERS __global mcv_device_pupil_guide *out) {
    MCV_MAKE_WORLD(world)
    const uint pixel = get_global_id(0);
    if (pixel < world.frame->width * world.frame->height)
        mcv_guide_pupil(world, pixel, out + pixel);
}
#endif

MCV_STAGE_KERNEL(generate_rays) {
    MCV_MAKE_WORLD(world)
    __local uint room[2];
    const uint path = get_global_id(0);
    int begun = 0;
    (void)sums, (void)counters, (void)depth;
    if (path < world.frame->path_count)
        begun = mcv_generate_ray(world, mcv_stream_slot(paths, capacity, path),
                                 mcv_identify(world, path));
#if MCV_WITH_SPLIT
    for (uint k = 1; k < MCV_BRANCHES && path < world.frame->path_count; ++k) {
        const mcv_slot branch =
            mcv_stream_slot(paths, capacity, path + k * world.frame->path_count);
        MCV_STORE(branch, weight, 0, 0.0f);
        MCV_EACH_CHANNEL(i) MCV_STORE(branch, radiance, i, 0.0f);
    }
#endif
    mcv_append(MCV_ACTIVE(0), &lengths[0], path, begun, room);
}

MCV_STAGE_KERNEL(intersect_closest) {
    MCV_MAKE_WORLD(world)
    const uint i = get_global_id(0);
    (void)sums, (void)counters;
    if (i < lengths[depth])
        mcv_intersect_closest(world, mcv_stream_slot(paths, capacity, MCV_ACTIVE(depth)[i]));
}

#if MCV_WITH_NEXT_EVENT
MCV_STAGE_KERNEL(sample_emitters) {
    MCV_MAKE_WORLD(world)
    __local uint room[2];
    const uint i = get_global_id(0);
    uint path = 0;
    int looks = 0;
    (void)sums, (void)counters;
    if (i < lengths[depth]) {
        path = MCV_ACTIVE(depth)[i];
        looks = mcv_sample_emitter(world, mcv_stream_slot(paths, capacity, path), depth);
    }
    mcv_append(MCV_SHADOWS, &MCV_SHADOW_LENGTH(depth), path, looks, room);
}

MCV_STAGE_KERNEL(intersect_shadow) {
    MCV_MAKE_WORLD(world)
    const uint i = get_global_id(0);
    (void)sums, (void)counters;
    if (i < MCV_SHADOW_LENGTH(depth))
        mcv_intersect_shadow(world, mcv_stream_slot(paths, capacity, MCV_SHADOWS[i]));
}
#endif

MCV_STAGE_KERNEL(shade_surfaces) {
    MCV_MAKE_WORLD(world)
    __local uint room[2];
    const uint i = get_global_id(0);
    uint path = 0;
    uint unmatched = 0, fate = 0;
    mcv_slot beside = mcv_stream_slot(paths, capacity, 0);
    (void)sums;
    if (i < lengths[depth]) {
        path = MCV_ACTIVE(depth)[i];
        const mcv_slot slot = mcv_stream_slot(paths, capacity, path);
#if MCV_WITH_SPLIT
        beside.index = path + (MCV_WORD(slot, branch_number, 0) + 1u) * world.frame->path_count;
#endif
        if (MCV_WORD(slot, hit, 3) == MCV_NONE)
            mcv_shade_miss(world, slot);
        else
            fate = mcv_shade_surface(world, slot, beside, depth, &unmatched);
        /* What the depth limit cuts. */
        if (fate && depth + 1u == world.frame->depth)
            atomic_add(&counters[MCV_COUNTER_lost],
                       (fate & MCV_CONTINUES ? mcv_cut_path(slot) : 0u) +
                           (fate & MCV_SPLITS ? mcv_cut_path(beside) : 0u));
        if (unmatched > 0) atomic_add(&counters[MCV_COUNTER_unmatched], unmatched);
    }
    mcv_append(MCV_ACTIVE(depth + 1u), &lengths[depth + 1u], path, (fate & MCV_CONTINUES) != 0,
               room);
#if MCV_WITH_SPLIT
    mcv_append(MCV_ACTIVE(depth + 1u), &lengths[depth + 1u], beside.index, (fate & MCV_SPLITS) != 0,
               room);
#endif
}

/* One work-item per block. */
MCV_STAGE_KERNEL(accumulate_film) {
    MCV_MAKE_WORLD(world)
    const uint block = mcv_block_size(world.frame->log2_samples);
    const uint i = get_global_id(0);
    uint nonfinite = 0;
    (void)queues, (void)lengths, (void)depth;
    if (i >= world.frame->path_count / block) return;
    for (uint channel = 0; channel < MCV_CHANNELS; ++channel) {
        float values[MCV_BLOCK], lows[MCV_BLOCK];
        for (uint k = 0; k < block; ++k) {
            values[k] = lows[k] = 0.0f;
            for (uint b = 0; b < MCV_BRANCHES; ++b) {
                const mcv_slot slot =
                    mcv_stream_slot(paths, capacity, i * block + k + b * world.frame->path_count);
                values[k] += mcv_path_value(world, slot, channel, &nonfinite);
            }
        }
        mcv_tree_sums(values, lows, block, block);
        sums[(size_t)(i * MCV_CHANNELS + channel) * 2] = values[0];
        sums[(size_t)(i * MCV_CHANNELS + channel) * 2 + 1] = lows[0];
    }
    if (nonfinite > 0) atomic_add(&counters[MCV_COUNTER_nonfinite], nonfinite);
}

#if MCV_WITH_LIGHT_TRACING
/* One work-item per path. */
__kernel __attribute__((reqd_work_group_size(MCV_STREAM_GROUP, 1, 1))) void
trace_emitter_paths(MCV_WORLD_PARAMETERS __global uint *splats, __global uint *counters) {
    MCV_MAKE_WORLD(world)
    const uint path = get_global_id(0);
    uint counts[MCV_COUNTER_COUNT] = {0};
    if (path >= world.frame->path_count) return;
    mcv_trace_light_path(world, path, splats, counts);
    for (uint i = 0; i < MCV_COUNTER_COUNT; ++i) {
        if (counts[i] > 0) atomic_add(&counters[i], counts[i]);
    }
}
#endif

/* The lengths of the queues are what was counted on the way: one work-item adds them up. */
MCV_STAGE_KERNEL(count_rays) {
    MCV_MAKE_WORLD(world)
    (void)paths, (void)sums, (void)queues, (void)capacity, (void)depth;
    if (get_global_id(0) > 0) return;
    counters[MCV_COUNTER_paths] += lengths[0];
    for (uint d = 0; d < world.frame->depth; ++d) {
        counters[MCV_COUNTER_rays] += lengths[d];
        counters[MCV_COUNTER_shadow_rays] += MCV_SHADOW_LENGTH(d);
    }
    counters[MCV_COUNTER_depth_cut] += lengths[world.frame->depth];
}
