/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which binary nodes become nodes of eight, at the least cost of all (the idea of Ylitie, Karras
 * and Laine, Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, HPG 2017):
 * a node and a block of four triangles cost one step for each ray that enters their box.
 */
#include "accel/bvh_builder.h"

#include <math.h>
#include <stdlib.h>

static float area(const mcv_binary *n) {
    const float x = n->upper[0] - n->lower[0], y = n->upper[1] - n->lower[1],
                z = n->upper[2] - n->lower[2];
    return x < 0.0f ? 0.0f : x * y + y * z + z * x;
}

/* The cheapest way to share out `roots` roots among two children. */
static float share_roots(const mcv_binary *left, const mcv_binary *right, uint32_t roots,
                         uint8_t *left_roots) {
    float least = INFINITY;
    *left_roots = 1;
    for (uint32_t k = 1; k < roots; ++k) {
        const float cost = left->costs[k - 1] + right->costs[roots - k - 1];
        if (!(cost < least)) continue;
        least = cost;
        *left_roots = (uint8_t)k;
    }
    return least;
}

void mcv_binary_cost(const mcv_bvh_builder *b, mcv_binary *n) {
    n->pending = 0;
    if (mcv_binary_is_leaf(n)) {
        for (int i = 0; i < MCV_BVH_WIDTH; ++i) n->costs[i] = area(n);
        return;
    }
    const mcv_binary *left = mcv_bvh_binary(b, n->children[0]),
                     *right = mcv_bvh_binary(b, n->children[1]);
    n->height = (uint8_t)(1 + (left->height > right->height ? left->height : right->height));
    n->costs[0] = area(n) + share_roots(left, right, MCV_BVH_WIDTH, &n->left_roots[0]);
    for (uint32_t roots = 2; roots <= MCV_BVH_WIDTH; ++roots) {
        float *cost = n->costs + roots - 1;
        *cost = share_roots(left, right, roots, &n->left_roots[roots - 1]);
        if (*cost < cost[-1]) continue;
        *cost = cost[-1];
        n->left_roots[roots - 1] = 0;
    }
}

/* The costs that had to wait for tasks. */
static void cost_pending(const mcv_bvh_builder *b, uint32_t number) {
    mcv_binary *n = mcv_bvh_binary(b, number);
    if (!n->pending) return;
    cost_pending(b, n->children[0]);
    cost_pending(b, n->children[1]);
    mcv_binary_cost(b, n);
}

/* Those of the roots under a node, which are at most so many, as the costs say. */
static uint32_t gather_roots(const mcv_bvh_builder *b, uint32_t number, uint32_t roots,
                             uint32_t *list) {
    const mcv_binary *n = mcv_bvh_binary(b, number);
    if (!mcv_binary_is_leaf(n))
        while (roots > 1 && n->left_roots[roots - 1] == 0) --roots;
    if (roots == 1 || mcv_binary_is_leaf(n)) {
        *list = number;
        return 1;
    }
    const uint32_t left = n->left_roots[roots - 1],
                   count = gather_roots(b, n->children[0], left, list);
    return count + gather_roots(b, n->children[1], roots - left, list + count);
}

/* The children of a node of eight; it is the root of `number`. */
static uint32_t gather(const mcv_bvh_builder *b, uint32_t number, uint32_t levels_left,
                       uint32_t children[MCV_BVH_WIDTH]) {
    const mcv_binary *n = mcv_bvh_binary(b, number);
    if (mcv_binary_is_leaf(n)) { /* of the whole structure */
        children[0] = number;
        return n->children[1] != MCV_CHILD_LEAF;
    }
    const uint32_t left = n->left_roots[0];
    uint32_t count = gather_roots(b, n->children[0], left, children);
    count += gather_roots(b, n->children[1], MCV_BVH_WIDTH - left, children + count);
    bool fits = true;
    for (uint32_t i = 0; i < count; ++i)
        fits = fits && mcv_bvh_binary(b, children[i])->height <= 3 * (levels_left - 1);
    if (fits) return count;
    /* The highest first (MCV_BINARY_LEVELS). */
    children[0] = number;
    for (count = 1; count < MCV_BVH_WIDTH; ++count) {
        uint32_t highest = 0;
        for (uint32_t i = 1; i < count; ++i) {
            if (mcv_bvh_binary(b, children[i])->height >
                mcv_bvh_binary(b, children[highest])->height)
                highest = i;
        }
        const mcv_binary *opened = mcv_bvh_binary(b, children[highest]);
        if (mcv_binary_is_leaf(opened)) break;
        children[highest] = opened->children[0];
        children[count] = opened->children[1];
    }
    return count;
}

/* Where any hit will do, children are visited in their order: those that cost least first. */
static void sort_children(const mcv_bvh_builder *b, uint32_t count, uint32_t *children) {
    for (uint32_t i = 1; i < count; ++i) {
        const uint32_t moved = children[i], height = mcv_bvh_binary(b, moved)->height;
        uint32_t place = i;
        for (; place > 0 && mcv_bvh_binary(b, children[place - 1])->height > height; --place)
            children[place] = children[place - 1];
        children[place] = moved;
    }
}

/* Box and number of a child; MCV_NONE without one. */
static void set_child(mcv_node *node, uint32_t slot, const mcv_binary *of, uint32_t child) {
    for (int axis = 0; axis < 3; ++axis) {
        node->bounds[axis][0][slot] = child == MCV_NONE ? INFINITY : of->lower[axis];
        node->bounds[axis][1][slot] = child == MCV_NONE ? -INFINITY : of->upper[axis];
    }
    node->child[slot] = child;
}

/*
 * Numbers nodes depth first and leaves in the order of their parents, siblings side by side: the
 * same for any number of threads, and near in memory what is near in space. Only counts them where
 * there are no nodes yet.
 */
static void place_nodes(mcv_bvh_builder *b, float extent) {
    struct {
        uint32_t binary, parent, slot, levels_left;
    } waiting[MCV_BVH_STACK] = {{0, 0, 0, MCV_BVH_LEVELS}};
    uint32_t waits = 1, nodes = 0, leaves = 0;
    mcv_node *made = b->bvh->nodes;
    while (waits) {
        --waits;
        const uint32_t slot = waiting[waits].slot, parent = waiting[waits].parent, here = nodes++,
                       levels_left = waiting[waits].levels_left;
        uint32_t children[MCV_BVH_WIDTH];
        const uint32_t count = gather(b, waiting[waits].binary, levels_left, children);
        if (made) {
            sort_children(b, count, children);
            made[here] = (mcv_node){.extent = extent};
            if (here) made[parent].child[slot] = here;
            for (uint32_t i = count; i < MCV_BVH_WIDTH; ++i)
                set_child(made + here, i, NULL, MCV_NONE);
        }
        for (uint32_t i = count; i-- > 0;) {
            const mcv_binary *child = mcv_bvh_binary(b, children[i]);
            if (made)
                set_child(made + here, i, child,
                          mcv_binary_is_leaf(child) ? MCV_CHILD_LEAF | leaves : 0);
            if (mcv_binary_is_leaf(child)) {
                if (made) b->leaf_binaries[leaves++] = children[i];
                continue;
            }
            waiting[waits].binary = children[i];
            waiting[waits].parent = here;
            waiting[waits].levels_left = levels_left - 1;
            waiting[waits++].slot = i;
        }
    }
    b->bvh->node_count = nodes;
}

bool mcv_bvh_collapse(mcv_bvh_builder *b, float extent) {
    cost_pending(b, 0);
    place_nodes(b, extent);
    b->bvh->nodes = mcv_bvh_allocate(b->bvh->node_count, sizeof *b->bvh->nodes);
    b->leaf_binaries = mcv_bvh_allocate(b->leaf_count, sizeof *b->leaf_binaries);
    if (!b->bvh->nodes || !b->leaf_binaries) return false;
    place_nodes(b, extent);
    return true;
}
