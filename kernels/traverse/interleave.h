/* SPDX-License-Identifier: Apache-2.0 */
/* Stragglers: rays of a packet that continue alone, because few others reach the same child. */
#ifndef MCVISI_KERNELS_INTERLEAVE_H
#define MCVISI_KERNELS_INTERLEAVE_H

#include "traverse/packet.h"

/* So many rays are interleaved, and so many wait for that before they are. */
#define MCV_INTERLEAVED 16
#define MCV_STRAGGLERS 64

/* A ray that continues alone from a node or leaf. */
typedef struct mcv_straggler {
    uint ray, child;
} mcv_straggler;

/* A straggler under way. */
typedef struct mcv_traversal {
    mcv_ray_frame ray;
    mcv_hit hit;
    uint number, current, count;
    ulong waiting[MCV_BVH_STACK];
} mcv_traversal;

/* One straggler to its end. */
static inline __attribute__((noinline)) void mcv_trace_straggler(__global const mcv_node *nodes,
                                                                 __global const mcv_leaf *leaves,
                                                                 mcv_packet *p,
                                                                 mcv_straggler straggler, int any) {
    /* No mcv_traversal: with the stack in it, the compiler keeps no part of it in registers. */
    const mcv_ray_frame ray = mcv_packet_ray(p, straggler.ray);
    mcv_hit hit = p->hits[straggler.ray];
    ulong waiting[MCV_BVH_STACK];
    uint current = straggler.child, count = 0;
    while (mcv_traverse_step(nodes, leaves, &ray, any, &hit, &current, &count, waiting)) {}
    mcv_packet_take(p, straggler.ray, any, hit);
}

/*
 * Several stragglers, a step each in turn: while one waits for memory the others compute. A ray
 * that continues from two children at once does not know at one of them what it has hit at the
 * other until it has arrived.
 */
MCV_LOOP_FUNCTION void mcv_trace_interleaved(__global const mcv_node *nodes,
                                             __global const mcv_leaf *leaves, mcv_packet *p,
                                             const mcv_straggler *stragglers, uint count, int any) {
    mcv_traversal traversals[MCV_INTERLEAVED];
    uint order[MCV_INTERLEAVED]; /* the traversals that are under way first */
    uint next = 0, busy = 0;
    for (uint i = 0; i < MCV_INTERLEAVED; ++i) order[i] = i;
    for (;;) {
        for (uint i = 0; i < busy;) {
            mcv_traversal *t = traversals + order[i];
            if (mcv_traverse_step(nodes, leaves, &t->ray, any, &t->hit, &t->current, &t->count,
                                  t->waiting)) {
                mcv_prefetch_child(nodes, leaves, t->current);
                ++i;
                continue;
            }
            mcv_packet_take(p, t->number, any, t->hit);
            --busy;
            const uint done = order[i];
            order[i] = order[busy];
            order[busy] = done;
        }
        for (; busy < MCV_INTERLEAVED && next < count; ++next) {
            const uint i = stragglers[next].ray;
            if (p->t[i] < 0.0f) continue;
            mcv_traversal *t = traversals + order[busy++];
            t->ray = mcv_packet_ray(p, i);
            t->hit = p->hits[i];
            t->number = i;
            t->current = stragglers[next].child;
            t->count = 0;
        }
        if (busy == 0) return;
    }
}

#endif
