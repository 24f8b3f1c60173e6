/* SPDX-License-Identifier: Apache-2.0 */
/* One ray through the hierarchy of mcvisi/accel.h. It finds what a loop over all triangles finds,
 * to the last bit (traverse/ray_frame.h). */
#ifndef MCVISI_KERNELS_BVH8_H
#define MCVISI_KERNELS_BVH8_H

#include "traverse/rows.h"
#include "traverse/triangle.h"

/* Begins to fetch a child that waits: by its turn it has come. Of a leaf a line too many, which
 * costs less than a conditional jump that no processor foresees. Only where all memory is the
 * host's; clang has no global form. */
static inline void mcv_prefetch_child(__global const mcv_node *nodes,
                                      __global const mcv_leaf *leaves, uint child) {
#ifdef MCV_AVX_BUILTINS
    const int is_leaf = (child & MCV_CHILD_LEAF) != 0;
    const char *line = (const char *)(is_leaf ? (size_t)(leaves + (child & ~MCV_CHILD_LEAF))
                                              : (size_t)(nodes + child));
    __builtin_prefetch(line);
    __builtin_prefetch(line + 64);
    __builtin_prefetch(line + 128);
    __builtin_prefetch(line + 192);
#else
    (void)nodes, (void)leaves, (void)child;
#endif
}

/* A child that waits its turn: where the ray enters its box (not below 0, so that its bits order as
 * it does), and its number. */
static inline ulong mcv_wait(float entry, uint child) {
    return (ulong)as_uint(entry) << 32 | child;
}
static inline float mcv_waiting_entry(ulong waiting) { return as_float((uint)(waiting >> 32)); }

/*
 * One step of a traversal: tests the node or leaf *current, which is then the next one: the nearest
 * first or, where any hit will do, in the order of the lanes. 0 at the end: there is none that
 * could hold a closer hit, or something is hit and any hit will do.
 */
MCV_LOOP_FUNCTION int mcv_traverse_step(__global const mcv_node *nodes,
                                        __global const mcv_leaf *leaves, const mcv_ray_frame *ray,
                                        int any, mcv_hit *hit, uint *current, uint *count,
                                        ulong *waiting) {
    if (*current & MCV_CHILD_LEAF) {
        if (mcv_intersect_leaf(leaves + (*current & ~MCV_CHILD_LEAF), ray, hit) && any) return 0;
    } else {
        __global const mcv_node *node = nodes + *current;
        float8 entry;
        uint mask = mcv_intersect_boxes(node, &ray->slabs, hit->t, &entry);
        if (any) {
            while (mask) {
                const uint child = node->child[mcv_pop_bit(&mask)];
                mcv_prefetch_child(nodes, leaves, child);
                waiting[(*count)++] = child;
            }
        } else if (mask) {
            uint lane = mcv_pop_bit(&mask);
            if (!mask) {
                *current = node->child[lane];
                return 1;
            }
            float t[8];
            vstore8(entry, 0, t);
            ulong nearest = mcv_wait(t[lane], node->child[lane]);
            mcv_prefetch_child(nodes, leaves, (uint)nearest);
            /* The nearest goes on; the others wait with the nearer on top. */
            const uint bottom = *count;
            do {
                lane = mcv_pop_bit(&mask);
                ulong other = mcv_wait(t[lane], node->child[lane]);
                mcv_prefetch_child(nodes, leaves, (uint)other);
                const ulong least = min(nearest, other);
                other = max(nearest, other);
                nearest = least;
                uint place = (*count)++;
                for (; place > bottom && waiting[place - 1] < other; --place)
                    waiting[place] = waiting[place - 1];
                waiting[place] = other;
            } while (mask);
            *current = (uint)nearest;
            return 1;
        }
    }
    ulong next;
    do {
        if (*count == 0) return 0;
        next = waiting[--*count];
    } while (mcv_waiting_entry(next) > hit->t);
    *current = (uint)next;
    return 1;
}

/*
 * The closest hit with 0 < t < t_max; on equal t the triangle with the lowest number. The direction
 * need not be unit; t counts in its length. A zero or non-finite direction hits nothing.
 */
static inline __attribute__((noinline)) mcv_hit
mcv_intersect_closest_ray(__global const mcv_node *nodes, __global const mcv_leaf *leaves,
                          mcv_vec3 origin, mcv_vec3 direction, float t_max) {
    mcv_hit hit = mcv_miss(t_max);
    const mcv_ray_frame ray = mcv_ray_setup(origin, direction, nodes->extent);
    ulong waiting[MCV_BVH_STACK];
    uint current = 0, count = 0;
    while (mcv_traverse_step(nodes, leaves, &ray, 0, &hit, &current, &count, waiting)) {}
    return hit;
}

/* Whether anything is hit with 0 < t < t_max. */
static inline __attribute__((noinline)) int mcv_intersect_any_ray(__global const mcv_node *nodes,
                                                                  __global const mcv_leaf *leaves,
                                                                  mcv_vec3 origin,
                                                                  mcv_vec3 direction, float t_max) {
    mcv_hit hit = mcv_miss(t_max);
    const mcv_ray_frame ray = mcv_ray_setup(origin, direction, nodes->extent);
    ulong waiting[MCV_BVH_STACK];
    uint current = 0, count = 0;
    while (mcv_traverse_step(nodes, leaves, &ray, 1, &hit, &current, &count, waiting)) {}
    return hit.primitive != MCV_NONE;
}

#if MCV_WITH_CONTACT
/* The next hit after another one, up to t_max. */
static __attribute__((noinline, unused)) mcv_hit
mcv_next_hit_ray(__global const mcv_node *nodes, __global const mcv_leaf *leaves, mcv_vec3 origin,
                 mcv_vec3 direction, mcv_hit after, float t_max) {
    mcv_hit hit = mcv_miss(t_max);
    const mcv_ray_frame ray = mcv_ray_setup(origin, direction, nodes->extent);
    uint waiting[MCV_BVH_STACK];
    uint count = 1;
    waiting[0] = 0;
    while (count > 0) {
        const uint current = waiting[--count];
        if (current & MCV_CHILD_LEAF) {
            mcv_intersect_leaf_after(leaves + (current & ~MCV_CHILD_LEAF), &ray, &after, &hit);
            continue;
        }
        float8 entry;
        int8 entered;
        uint mask = mcv_intersect_boxes_between(nodes + current, &ray.slabs, after.t, hit.t, &entry,
                                                &entered);
        while (mask) waiting[count++] = nodes[current].child[mcv_pop_bit(&mask)];
    }
    return hit;
}
#endif

#endif
