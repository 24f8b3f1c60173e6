/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Many rays through the hierarchy together (J. A. Tsakok, Faster Incoherent Rays: Multi-BVH Ray
 * Stream Tracing, HPG 2009): a node or a leaf is visited once, with a list of all rays that enter
 * it, and a leaf is tested with many of them side by side. Rays that few others accompany go on
 * alone (traverse/stragglers.h).
 *
 * They find what they find alone, to the last bit: a triangle is tested by the same arithmetic, and
 * boxes only leave out what cannot be hit (traverse/ray_frame.h; any superset of the leaves in any
 * order gives the same hit).
 */
#ifndef MCVISI_KERNELS_TRACE_PACKET_H
#define MCVISI_KERNELS_TRACE_PACKET_H

#include "traverse/flat.h"
#include "traverse/stragglers.h"

/* Down from so many, each ray of a list continues alone: nearest first is then worth more than
 * company. */
#define MCV_PACKET_FEW 5

/* Rays keep each other company below a node where at least so many of them are expected at one of
 * its children's children, if all enter as many of them as here; where fewer, each continues alone
 * from the node. */
#define MCV_PACKET_COMPANY 4u

/* So many of a packet wait for company in turns; the sooner they have gone, the sooner their hits
 * spare the packet nodes. */
#define MCV_STRAGGLERS 32u

/* A child that waits: its node's level, and which of its children it is. */
typedef struct mcv_packet_child {
    uint child, level, lane;
} mcv_packet_child;

/*
 * The traversal of a packet. Each level of nodes has the list of the rays that have reached its
 * node, and for each ray a mask of the children that it enters. Lists and masks end with eight
 * entries that nothing chooses.
 */
typedef struct mcv_packet_traversal {
    mcv_packet rays;
    uchar lists[MCV_BVH_LEVELS + 2][MCV_PACKET + 8], masks[MCV_BVH_LEVELS + 1][MCV_PACKET + 8];
    uint counts[MCV_BVH_LEVELS + 1];
    mcv_packet_child waiting[MCV_BVH_STACK + MCV_BVH_WIDTH];
    uint depth; /* children that wait */
} mcv_packet_traversal;

/* Begins at the root. Closest hits are looked for by the rays of each octant of directions by
 * themselves, for which the nearest child is much the same one. */
MCV_LOOP_FUNCTION void mcv_begin_packet(uint count, int any, mcv_packet_traversal *p) {
    uint roots = 0;
    for (uint i = 0; i < count; ++i) {
        uint octant = 0;
#pragma unroll
        for (int axis = 0; axis < 3 && !any; ++axis)
            octant = octant << 1 | as_uint(p->rays.inverse[axis][i]) >> 31;
        p->lists[0][i] = (uchar)i;
        p->masks[0][i] = (uchar)(1u << octant);
        roots |= 1u << octant;
    }
    vstore8((uchar8)(0), 0, p->lists[0] + count);
    vstore8((uchar8)(0), 0, p->masks[0] + count);
    p->counts[0] = count;
    p->depth = 0;
    while (roots) p->waiting[p->depth++] = (mcv_packet_child){0, 0, mcv_pop_bit(&roots)};
}

/* Lists the rays that enter a child and that are not done, on the level below; returns how many. */
MCV_LOOP_FUNCTION uint mcv_list_entering(mcv_packet_child next, int any, mcv_packet_traversal *p) {
    const uchar *from = p->lists[next.level], *masks = p->masks[next.level];
    uchar *list = p->lists[next.level + 1u];
    const uint count = p->counts[next.level];
    uint listed = 0;
    for (uint first = 0; first < count; first += 8) {
#pragma unroll
        for (uint k = first; k < first + 8; ++k) {
            const uint i = from[k];
            list[listed] = (uchar)i;
            listed += masks[k] >> next.lane & (any ? p->rays.t[i] >= 0.0f : 1);
        }
    }
    vstore8((uchar8)(0), 0, list + listed);
    return listed;
}

/* Which children of a node the listed rays enter: a mask for each ray. */
typedef struct mcv_packet_entries {
    float8 least; /* where the first ray enters a child */
    uint entered; /* children, one bit each */
    uint rays;    /* that enter any */
    uint count;   /* of pairs of a ray and a child */
} mcv_packet_entries;

MCV_LOOP_FUNCTION mcv_packet_entries mcv_enter_node(__global const mcv_node *node, uint level,
                                                    uint listed, mcv_packet_traversal *p) {
    const uchar *list = p->lists[level];
    uchar *masks = p->masks[level];
    mcv_packet_entries found = {(float8)(INFINITY), 0, 0, 0};
    for (uint k = 0; k < listed; ++k) {
        const uint ray = list[k];
        const mcv_slabs slabs = mcv_packet_slabs(&p->rays, ray);
        float8 entry;
        const uint mask = mcv_intersect_boxes(node, &slabs, p->rays.t[ray], &entry);
        found.least = min(found.least, entry);
        found.entered |= mask;
        found.rays += mask != 0u;
        found.count += popcount(mask);
        masks[k] = (uchar)mask;
    }
    vstore8((uchar8)(0), 0, masks + listed);
    p->counts[level] = listed;
    return found;
}

/* Whether each ray had better continue alone: a ray enters a child with the chance count / (rays
 * children), and a child of it with the same. Where most children are leaves, the leaves decide. */
MCV_LOOP_FUNCTION int mcv_rays_part(__global const mcv_node *node, mcv_packet_entries found) {
    const uint children = popcount(found.entered);
    uint nodes = 0;
    for (uint lane = 0; lane < MCV_BVH_WIDTH; ++lane)
        nodes |= (node->child[lane] >> 31 ^ 1u) << lane;
    return (2u * popcount(found.entered & nodes) > children) &
           (found.count * found.count < MCV_PACKET_COMPANY * children * children * found.rays);
}

/* The children of a node wait, the nearest on top, as the ray sees it that enters it first, or in
 * their order where any hit will do. */
MCV_LOOP_FUNCTION void mcv_wait_for_children(__global const mcv_node *nodes,
                                             __global const mcv_leaf *leaves, mcv_packet_child next,
                                             mcv_packet_entries found, int any,
                                             mcv_packet_traversal *p) {
    __global const mcv_node *node = nodes + next.child;
    const uint level = next.level + 1u, bottom = p->depth;
    uint depth = bottom;
    float begin[MCV_BVH_WIDTH];
    vstore8(any ? (float8)(0, 1, 2, 3, 4, 5, 6, 7) : found.least, 0, begin);
    while (found.entered) {
        const uint lane = mcv_pop_bit(&found.entered);
        mcv_prefetch_child(nodes, leaves, node->child[lane]);
        uint place = depth++;
        for (; place > bottom && begin[p->waiting[place - 1].lane] < begin[lane]; --place)
            p->waiting[place] = p->waiting[place - 1];
        p->waiting[place] = (mcv_packet_child){node->child[lane], level, lane};
    }
    p->depth = depth;
}

/* The listed rays that enter any child of a node continue alone from it; returns the stragglers'
 * count. */
MCV_LOOP_FUNCTION uint mcv_part_rays(mcv_packet_child next, uint listed,
                                     const mcv_packet_traversal *p, mcv_straggler *stragglers,
                                     uint alone) {
    const uchar *list = p->lists[next.level + 1u], *masks = p->masks[next.level + 1u];
    for (uint k = 0; k < listed; ++k) {
        stragglers[alone] = (mcv_straggler){list[k], next.child};
        alone += masks[k] != 0;
    }
    return alone;
}

/* The hits of at most MCV_PACKET rays, all of finite origin. */
MCV_LOOP_FUNCTION void mcv_trace_packet(__global const mcv_node *nodes,
                                        __global const mcv_leaf *leaves, mcv_rows origins,
                                        mcv_rows directions, const uint *numbers, uint count,
                                        int any, int together, mcv_hits hits) {
    mcv_packet_traversal p;
    mcv_straggler stragglers[MCV_PACKET + MCV_STRAGGLERS];
    uint alone = 0;
    mcv_packet_setup(origins, directions, numbers, count, nodes->extent, hits, &p.rays);
    if (together) {
        mcv_begin_packet(count, any, &p);
    } else {
        p.depth = 0;
        for (; alone < count; ++alone) stragglers[alone] = (mcv_straggler){alone, 0};
    }
    while (p.depth > 0 || alone > 0) {
        if (p.depth == 0 || alone >= MCV_STRAGGLERS) {
            mcv_trace_stragglers(nodes, leaves, &p.rays, stragglers, alone, any);
            alone = 0;
            continue;
        }
        const mcv_packet_child next = p.waiting[--p.depth];
        const uint listed = mcv_list_entering(next, any, &p);
        const uchar *list = p.lists[next.level + 1u];
        if (listed <= MCV_PACKET_FEW) {
            for (uint k = 0; k < listed; ++k)
                stragglers[alone++] = (mcv_straggler){list[k], next.child};
        } else if (next.child & MCV_CHILD_LEAF) {
            mcv_packet_leaf(leaves + (next.child & ~MCV_CHILD_LEAF), &p.rays, list, listed, any);
        } else {
            __global const mcv_node *node = nodes + next.child;
            const mcv_packet_entries found = mcv_enter_node(node, next.level + 1u, listed, &p);
            if (mcv_rays_part(node, found))
                alone = mcv_part_rays(next, listed, &p, stragglers, alone);
            else
                mcv_wait_for_children(nodes, leaves, next, found, any, &p);
        }
    }
    for (uint i = 0; i < count; ++i) mcv_put_hit(hits, numbers[i], p.rays.hits[i]);
}

/*
 * The hits of the rays numbers[0 … count - 1]: the closest or, where any hit will do, one of them,
 * of which only the triangle is known. On entry they are misses (mcv_miss) or what else the rays
 * have hit, which stays where nothing closer is hit. `together` is a constant: 0 lets each ray go
 * alone from the root.
 */
#define MCV_TRACE_RAYS(name, any, together) \
    static inline __attribute__((noinline)) void name( \
        __global const mcv_node *nodes, __global const mcv_leaf *leaves, mcv_rows origins, \
        mcv_rows directions, const uint *numbers, uint count, mcv_hits hits) { \
        if (mcv_is_flat(nodes)) { \
            mcv_trace_flat(nodes, leaves, origins, directions, numbers, count, any, hits); \
            return; \
        } \
        for (uint first = 0; first < count; first += MCV_PACKET) \
            mcv_trace_packet(nodes, leaves, origins, directions, numbers + first, \
                             min(count - first, (uint)MCV_PACKET), any, together, hits); \
    }
MCV_TRACE_RAYS(mcv_intersect_closest_rays, 0, 1)
MCV_TRACE_RAYS(mcv_intersect_any_rays, 1, 1)

#endif
