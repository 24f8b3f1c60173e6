/* SPDX-License-Identifier: Apache-2.0 */
/* Stragglers: rays that go alone, because few others reach the same child. */
#ifndef MCVISI_KERNELS_STRAGGLERS_H
#define MCVISI_KERNELS_STRAGGLERS_H

#include "traverse/packet.h"

/* So many rays take turns. */
#define MCV_INTERLEAVED 16

/* A ray that continues alone from a node or leaf. */
typedef struct mcv_straggler {
    uint ray, child;
} mcv_straggler;

/* The children of a node whose lanes are stored with less than eight to spare. */
#define MCV_TRAVERSAL_STACK (MCV_BVH_STACK + MCV_BVH_WIDTH)

/*
 * A straggler under way. The children that wait have keys, whose three lowest bits are lanes: the
 * greater, the sooner their turn. Below them lies MCV_NONE.
 */
typedef struct mcv_traversal {
    mcv_ray_frame ray;
    mcv_hit hit;
    uint number, current, count;
    uint key[MCV_TRAVERSAL_STACK], child[MCV_TRAVERSAL_STACK];
} mcv_traversal;

/* Where the ray enters a child of this key, or a little sooner. */
static inline float mcv_key_entry(uint key) { return as_float(~key & ~7u); }

/* One step of a sorting network: lanes i and PARTNER(i), the lesser of which gets the lesser. */
#define MCV_SORT_STEP(keys, PARTNER, UPPER) \
    do { \
        const uint8 mcv_other = (keys).PARTNER; \
        (keys) = UPPER ? max((keys), mcv_other) : min((keys), mcv_other); \
    } while (0)

MCV_LOOP_FUNCTION uint8 mcv_sort8(uint8 keys) {
    const int8 odd = (int8)(0, -1, 0, -1, 0, -1, 0, -1), bit_1 = (int8)(0, 0, -1, -1, 0, 0, -1, -1),
               upper = (int8)(0, 0, 0, 0, -1, -1, -1, -1);
    MCV_SORT_STEP(keys, s10325476, odd);
    MCV_SORT_STEP(keys, s32107654, bit_1);
    MCV_SORT_STEP(keys, s10325476, odd);
    MCV_SORT_STEP(keys, s76543210, upper);
    MCV_SORT_STEP(keys, s23016745, bit_1);
    MCV_SORT_STEP(keys, s10325476, odd);
    return keys;
}

/*
 * The children of a node that the ray enters wait, the nearest on top or, where any hit will do,
 * the first. Without conditional jumps: which of them a ray enters no processor foresees.
 */
MCV_LOOP_FUNCTION void mcv_visit_children(__global const mcv_node *node, int any,
                                          mcv_traversal *t) {
    const uint8 lane = (uint8)(0, 1, 2, 3, 4, 5, 6, 7);
    float8 entry;
    int8 entered;
    const uint mask = mcv_intersect_boxes_lanes(node, &t->ray.slabs, t->hit.t, &entry, &entered);
    uint8 keys = any ? ~lane : (~as_uint8(entry) & ~7u) | lane;
    keys = mcv_sort8(entered ? keys : (uint8)(0xffffffffu));
    const uint8 sorted = any ? ~keys & 7u : keys & 7u;
    vstore8(keys, 0, t->key + t->count);
    vstore8(mcv_permute8(*(__global const uint8 *)node->child, sorted), 0, t->child + t->count);
    t->count += popcount(mask);
}

/* The next child that waits and could hold a closer hit. */
MCV_LOOP_FUNCTION uint mcv_next_waiting(int any, mcv_traversal *t) {
    uint count = t->count;
    do --count;
    while (!any && mcv_key_entry(t->key[count]) > t->hit.t);
    t->count = count;
    return t->current = t->child[count];
}

/* Lists of stragglers: those at nodes, at leaves, at their end. */
typedef struct mcv_traversal_lists {
    uchar *at_node, *at_leaf, *at_end;
    uint nodes, leaves, ends;
} mcv_traversal_lists;

/* Puts a straggler on its list without conditional jumps: a place of all is written, one of them
 * counts. */
MCV_LOOP_FUNCTION void mcv_list_traversal(__global const mcv_node *nodes,
                                          __global const mcv_leaf *leaves, uint i, uint current,
                                          mcv_traversal_lists *lists) {
    const uint is_end = current == MCV_NONE, is_node = current >> 31 ^ 1u;
    mcv_prefetch_child(nodes, leaves, current);
    lists->at_node[lists->nodes] = (uchar)i;
    lists->at_leaf[lists->leaves] = (uchar)i;
    lists->at_end[lists->ends] = (uchar)i;
    lists->nodes += is_node;
    lists->leaves += 1u - is_node - is_end;
    lists->ends += is_end;
}

/* Begins stragglers in the places of those at their end; returns the next to begin. */
MCV_LOOP_FUNCTION uint mcv_begin_traversals(__global const mcv_node *nodes,
                                            __global const mcv_leaf *leaves, const mcv_packet *p,
                                            const mcv_straggler *stragglers, uint next, uint count,
                                            mcv_traversal *turns, mcv_traversal_lists *lists) {
    for (; lists->ends > 0 && next < count; ++next) {
        const uint number = stragglers[next].ray;
        if (p->t[number] < 0.0f) continue;
        const uint i = lists->at_end[--lists->ends];
        mcv_traversal *t = turns + i;
        t->ray = mcv_packet_ray(p, number);
        t->hit = p->hits[number];
        t->number = number;
        t->current = stragglers[next].child;
        t->key[0] = 0xffffffffu;
        t->child[0] = MCV_NONE;
        t->count = 1;
        mcv_list_traversal(nodes, leaves, i, t->current, lists);
    }
    return next;
}

/*
 * Several stragglers, a step each in turn: while one waits for memory or for a result, the others
 * compute. Those at nodes come first, then those at leaves, so that the processor foresees which it
 * is. A ray that continues from two children at once does not know at one of them what it has hit
 * at the other until it has arrived.
 */
MCV_LOOP_FUNCTION void mcv_trace_stragglers(__global const mcv_node *nodes,
                                            __global const mcv_leaf *leaves, mcv_packet *p,
                                            const mcv_straggler *stragglers, uint count, int any) {
    mcv_traversal turns[MCV_INTERLEAVED];
    /* Two sets, one being read while the other is written. */
    uchar at_node[2][MCV_INTERLEAVED + 1], at_leaf[2][MCV_INTERLEAVED + 1],
        at_end[MCV_INTERLEAVED + 1];
    uint next = 0, side = 0, first_end = 0;
    mcv_traversal_lists lists = {at_node[0], at_leaf[0], at_end, 0, 0, MCV_INTERLEAVED};
    for (uint i = 0; i < MCV_INTERLEAVED; ++i) at_end[i] = (uchar)i;
    for (;;) {
        next = mcv_begin_traversals(nodes, leaves, p, stragglers, next, count, turns, &lists);
        const uint at_nodes = lists.nodes, at_leaves = lists.leaves;
        if (at_nodes + at_leaves == 0) return;
        first_end = lists.ends;
        lists.at_node = at_node[side ^ 1u];
        lists.at_leaf = at_leaf[side ^ 1u];
        lists.nodes = lists.leaves = 0;
        for (uint k = 0; k < at_nodes; ++k) {
            const uint i = at_node[side][k];
            mcv_traversal *t = turns + i;
            mcv_visit_children(nodes + t->current, any, t);
            mcv_list_traversal(nodes, leaves, i, mcv_next_waiting(any, t), &lists);
        }
        for (uint k = 0; k < at_leaves; ++k) {
            const uint i = at_leaf[side][k];
            mcv_traversal *t = turns + i;
            const int ends =
                mcv_intersect_leaf(leaves + (t->current & ~MCV_CHILD_LEAF), &t->ray, &t->hit) &&
                any;
            mcv_list_traversal(nodes, leaves, i, ends ? MCV_NONE : mcv_next_waiting(any, t),
                               &lists);
        }
        for (uint k = first_end; k < lists.ends; ++k) {
            const mcv_traversal *t = turns + at_end[k];
            mcv_packet_take(p, t->number, any, t->hit);
        }
        side ^= 1u;
    }
}

#endif
