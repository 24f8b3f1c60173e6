/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rays in a row against a scene: intersect_closest and intersect_any through the hierarchy,
 * intersect_all by testing every leaf (what the tests compare with). A work-group is one work-item,
 * which handles a slice of the rays: on a CPU it runs on one core with its stack in the first
 * cache.
 */
#include "traverse/trace_packet.h"

/* A ray of the batch: 32 bytes. */
typedef struct mcv_batch_ray {
    float origin[3], t_max;
    float direction[3], unused;
} mcv_batch_ray;

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
intersect_closest(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
                  __global const mcv_batch_ray *rays, __global mcv_hit *hits, uint count,
                  uint slice) {
    const uint first = (uint)get_group_id(0) * slice;
    const uint last = min(first + slice, count);
    for (uint i = first; i < last; ++i) {
        const mcv_vec3 origin = mcv_vec(rays[i].origin[0], rays[i].origin[1], rays[i].origin[2]);
        const mcv_vec3 direction =
            mcv_vec(rays[i].direction[0], rays[i].direction[1], rays[i].direction[2]);
        hits[i] = mcv_intersect_closest_ray(nodes, leaves, origin, direction, rays[i].t_max);
    }
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
intersect_any(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
              __global const mcv_batch_ray *rays, __global int *found, uint count, uint slice) {
    const uint first = (uint)get_group_id(0) * slice;
    const uint last = min(first + slice, count);
    for (uint i = first; i < last; ++i) {
        const mcv_vec3 origin = mcv_vec(rays[i].origin[0], rays[i].origin[1], rays[i].origin[2]);
        const mcv_vec3 direction =
            mcv_vec(rays[i].direction[0], rays[i].direction[1], rays[i].direction[2]);
        found[i] = mcv_intersect_any_ray(nodes, leaves, origin, direction, rays[i].t_max);
    }
}

#define MCV_BATCH_LIST 256

/* Many rays by one of the functions for lists of them, MCV_BATCH_LIST at a time; `result` is what
 * is kept of a hit. */
#define MCV_BATCH_KERNEL(name, many, output, result) \
    __kernel __attribute__((reqd_work_group_size(1, 1, 1))) void name( \
        __global const mcv_node *nodes, __global const mcv_leaf *leaves, \
        __global const mcv_batch_ray *rays, __global output *out, uint count, uint slice) { \
        const uint first = (uint)get_group_id(0) * slice; \
        const uint last = min(first + slice, count); \
        const uint step = sizeof(mcv_batch_ray) / sizeof(float); \
        uint indices[MCV_BATCH_LIST]; \
        uint rows[4 * MCV_BATCH_LIST]; \
        const mcv_hits hits = mcv_hits_in(rows, MCV_BATCH_LIST); \
        for (uint i = 0; i < MCV_BATCH_LIST; ++i) indices[i] = i; \
        for (uint begin = first; begin < last; begin += MCV_BATCH_LIST) { \
            const uint listed = min(last - begin, (uint)MCV_BATCH_LIST); \
            const mcv_rows origins = {(__global const uint *)rays[begin].origin, step, 1}; \
            const mcv_rows directions = {(__global const uint *)rays[begin].direction, step, 1}; \
            for (uint i = 0; i < listed; ++i) \
                mcv_put_hit(hits, i, mcv_miss(rays[begin + i].t_max)); \
            many(nodes, leaves, origins, directions, indices, listed, hits); \
            for (uint i = 0; i < listed; ++i) out[begin + i] = mcv_hit_of(hits, i) result; \
        } \
    }

/* All rays together, as the stages of the tile schedule do, and each alone. */
MCV_TRACE_RAYS(mcv_closest_alone, 0, 0)
MCV_TRACE_RAYS(mcv_any_alone, 1, 0)
MCV_BATCH_KERNEL(intersect_closest_together, mcv_intersect_closest_rays, mcv_hit, )
MCV_BATCH_KERNEL(intersect_any_together, mcv_intersect_any_rays, int, .primitive != MCV_NONE)
MCV_BATCH_KERNEL(intersect_closest_alone, mcv_closest_alone, mcv_hit, )
MCV_BATCH_KERNEL(intersect_any_alone, mcv_any_alone, int, .primitive != MCV_NONE)
MCV_BATCH_KERNEL(closest_many, mcv_intersect_closest_rays, mcv_hit, )
MCV_BATCH_KERNEL(any_many, mcv_intersect_any_rays, int, .primitive != MCV_NONE)

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
intersect_all(__global const mcv_leaf *leaves, __global const mcv_batch_ray *rays,
              __global mcv_hit *hits, uint count, uint slice, uint leaf_count) {
    const uint first = (uint)get_group_id(0) * slice;
    const uint last = min(first + slice, count);
    for (uint i = first; i < last; ++i) {
        mcv_hit hit = mcv_miss(rays[i].t_max);
        const mcv_ray_frame ray = mcv_ray_setup(
            mcv_vec(rays[i].origin[0], rays[i].origin[1], rays[i].origin[2]),
            mcv_vec(rays[i].direction[0], rays[i].direction[1], rays[i].direction[2]), 0.0f);
        for (uint leaf = 0; leaf < leaf_count; ++leaf)
            mcv_intersect_leaf(leaves + leaf, &ray, &hit);
        hits[i] = hit;
    }
}

/* How many leaves a ray hits: crossings, if every triangle has a leaf of its own. */
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void
count_hits(__global const mcv_leaf *leaves, __global const mcv_batch_ray *rays,
           __global int *counts, uint count, uint slice, uint leaf_count) {
    const uint first = (uint)get_group_id(0) * slice;
    const uint last = min(first + slice, count);
    for (uint i = first; i < last; ++i) {
        const mcv_ray_frame ray = mcv_ray_setup(
            mcv_vec(rays[i].origin[0], rays[i].origin[1], rays[i].origin[2]),
            mcv_vec(rays[i].direction[0], rays[i].direction[1], rays[i].direction[2]), 0.0f);
        int crossings = 0;
        for (uint leaf = 0; leaf < leaf_count; ++leaf) {
            mcv_hit hit = mcv_miss(rays[i].t_max);
            crossings += mcv_intersect_leaf(leaves + leaf, &ray, &hit);
        }
        counts[i] = crossings;
    }
}
