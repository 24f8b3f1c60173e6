/* SPDX-License-Identifier: Apache-2.0 */
#include "accel/update.h"

#include "accel/bvh_builder.h"
#include "accel/split_bins.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAST_COMMON = 2 }; /* of so many triangles of each scene one is in both at least */

typedef struct update {
    const mcv_bvh *base;
    const float *positions;
    const uint32_t *indices;
    uint32_t triangle_count, threads;
    mcv_matches matches;
    mcv_bvh patch;    /* of the triangles that the base has not */
    uint32_t *leaves; /* what becomes of those of the base: a number, or MCV_NONE */
    mcv_node *nodes;  /* of both, in any order */
    uint32_t node_count;
    mcv_bvh *bvh;
} update;

/* The hierarchy of the triangles that only the new scene has. */
static mcv_result build_patch(update *u, mcv_error *error) {
    const uint32_t most = u->triangle_count - u->matches.found_count;
    uint32_t *indices = malloc(3 * (size_t)most * sizeof *indices + 1),
             *numbers = malloc((size_t)most * sizeof *numbers + 1), count = 0;
    mcv_result result = MCV_FAILED;
    for (uint32_t t = 0; indices && numbers && t < u->triangle_count; ++t) {
        if (u->matches.found[t]) continue;
        memcpy(indices + 3 * (size_t)count, u->indices + 3 * (size_t)t, 3 * sizeof *indices);
        numbers[count++] = t;
    }
    if (indices && numbers)
        result = mcv_bvh_build(u->positions, indices, count, u->threads, &u->patch, error);
    else
        mcv_fail(error, MCV_FAILED, "no memory for the acceleration structure");
    for (uint32_t i = 0; result == MCV_OK && i < u->patch.leaf_count; ++i)
        for (int lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane) {
            uint32_t *triangle = u->patch.leaves[i].triangle + lane;
            if (*triangle != MCV_NONE) *triangle = numbers[*triangle];
        }
    free(indices);
    free(numbers);
    return result;
}

/* --- the leaves --- */

/* Leaves out the triangles that are no more; the first lanes are those in use. Their number. */
static uint32_t keep_lanes(const update *u, mcv_leaf *leaf) {
    uint32_t left = 0;
    for (int lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane) {
        const uint32_t triangle = leaf->triangle[lane];
        if (triangle == MCV_NONE) continue;
        const uint32_t number = u->matches.numbers[triangle];
        if (number == MCV_NONE) continue;
        for (int i = 0; i < 9; ++i)
            leaf->vertex[i / 3][i % 3][left] = leaf->vertex[i / 3][i % 3][lane];
        leaf->triangle[left++] = number;
    }
    for (uint32_t lane = left; lane < MCV_LEAF_TRIANGLES; ++lane) {
        for (int i = 0; i < 9; ++i) leaf->vertex[i / 3][i % 3][lane] = 0;
        leaf->triangle[lane] = MCV_NONE;
    }
    return left;
}

/* The leaves of the base, those of the patch behind them. */
static void keep_leaves(update *u) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < u->base->leaf_count; ++i) {
        u->bvh->leaves[count] = u->base->leaves[i];
        u->leaves[i] = keep_lanes(u, u->bvh->leaves + count) ? count++ : MCV_NONE;
    }
    if (u->patch.leaf_count)
        memcpy(u->bvh->leaves + count, u->patch.leaves, u->patch.leaf_count * sizeof(mcv_leaf));
    u->bvh->leaf_count = count + u->patch.leaf_count;
}

/* --- the nodes --- */

static void set_child(mcv_node *node, uint32_t slot, float bounds[3][2], uint32_t child) {
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) node->bounds[axis][side][slot] = bounds[axis][side];
    node->child[slot] = child;
}

static void child_bounds(const mcv_node *node, uint32_t slot, float bounds[3][2]) {
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) bounds[axis][side] = node->bounds[axis][side][slot];
}

static mcv_node empty_node(void) {
    mcv_node node = {.extent = 0};
    float bounds[3][2] = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}, {INFINITY, -INFINITY}};
    for (uint32_t k = 0; k < MCV_BVH_WIDTH; ++k) set_child(&node, k, bounds, MCV_NONE);
    return node;
}

/* The base's nodes without children of which nothing is left. */
static void keep_nodes(update *u) {
    /* The number of a node is smaller than those of its children. */
    for (uint32_t i = u->base->node_count; i-- > 0;) {
        mcv_node *kept = u->nodes + i;
        uint32_t count = 0;
        *kept = empty_node();
        for (uint32_t k = 0; k < MCV_BVH_WIDTH; ++k) {
            uint32_t child = u->base->nodes[i].child[k];
            float bounds[3][2];
            if (child == MCV_NONE) continue;
            if (child & MCV_CHILD_LEAF) {
                child = u->leaves[child & ~MCV_CHILD_LEAF];
                if (child == MCV_NONE) continue;
                child |= MCV_CHILD_LEAF;
            } else if (u->nodes[child].child[0] == MCV_NONE) {
                continue;
            }
            child_bounds(u->base->nodes + i, k, bounds);
            set_child(kept, count++, bounds, child);
        }
    }
    u->node_count = u->base->node_count;
}

/* Half the surface of a box, and of the smallest box around two. */
static float area(float a[3][2], float b[3][2]) {
    float size[3];
    for (int axis = 0; axis < 3; ++axis)
        size[axis] = mcv_larger(a[axis][1], b[axis][1]) - mcv_smaller(a[axis][0], b[axis][0]);
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

static void extend(mcv_node *node, uint32_t slot, float bounds[3][2]) {
    for (int axis = 0; axis < 3; ++axis) {
        float *lower = &node->bounds[axis][0][slot], *upper = &node->bounds[axis][1][slot];
        *lower = mcv_smaller(*lower, bounds[axis][0]);
        *upper = mcv_larger(*upper, bounds[axis][1]);
    }
}

/* The child, a leaf or a node, whose box grows least around another one; MCV_BVH_WIDTH: none. */
static uint32_t nearest_child(const mcv_node *node, bool leaf, float bounds[3][2], float *growth) {
    uint32_t nearest = MCV_BVH_WIDTH;
    *growth = INFINITY;
    for (uint32_t k = 0; k < MCV_BVH_WIDTH && node->child[k] != MCV_NONE; ++k) {
        float own[3][2];
        if (((node->child[k] & MCV_CHILD_LEAF) != 0) != leaf) continue;
        child_bounds(node, k, own);
        const float grown = area(own, bounds) - area(own, own);
        if (nearest < MCV_BVH_WIDTH && !(grown < *growth)) continue; /* surfaces may overflow */
        *growth = grown;
        nearest = k;
    }
    return nearest;
}

/*
 * Puts a leaf or a node into the hierarchy: into the first free place on the way down from the root
 * to where boxes grow least. Where there is none, beside a leaf, in a new node.
 */
static void insert(update *u, float bounds[3][2], uint32_t child) {
    for (mcv_node *node = u->nodes;;) {
        uint32_t used = 0;
        float growth;
        while (used < MCV_BVH_WIDTH && node->child[used] != MCV_NONE) ++used;
        uint32_t slot = nearest_child(node, false, bounds, &growth);
        if (used < MCV_BVH_WIDTH && (slot == MCV_BVH_WIDTH || growth > 0)) {
            set_child(node, used, bounds, child);
            return;
        }
        if (slot < MCV_BVH_WIDTH) {
            extend(node, slot, bounds);
            node = u->nodes + node->child[slot];
            continue;
        }
        slot = nearest_child(node, true, bounds, &growth);
        mcv_node *both = u->nodes + u->node_count;
        float own[3][2];
        child_bounds(node, slot, own);
        *both = empty_node();
        set_child(both, 0, own, node->child[slot]);
        set_child(both, 1, bounds, child);
        extend(node, slot, bounds);
        node->child[slot] = u->node_count++;
        return;
    }
}

/* The patch's nodes behind those of the base; what is below its root goes where it is near. */
static void insert_patch(update *u) {
    const uint32_t first = u->node_count, leaves = u->bvh->leaf_count - u->patch.leaf_count;
    if (!u->patch.nodes) return;
    for (uint32_t i = 0; i < u->patch.node_count; ++i) {
        mcv_node *node = u->nodes + first + i;
        *node = u->patch.nodes[i];
        for (int k = 0; k < MCV_BVH_WIDTH; ++k)
            if (node->child[k] != MCV_NONE)
                node->child[k] += node->child[k] & MCV_CHILD_LEAF ? leaves : first;
    }
    u->node_count += u->patch.node_count;
    for (uint32_t k = 0; k < MCV_BVH_WIDTH; ++k) {
        const mcv_node root = u->nodes[first];
        float bounds[3][2];
        child_bounds(&root, k, bounds);
        if (root.child[k] != MCV_NONE) insert(u, bounds, root.child[k]);
    }
}

/* Copies what can be reached, parents first. False where it is too deep for a traversal's stack. */
static bool place_nodes(const update *u, float extent) {
    struct {
        uint32_t node, parent, slot, level;
    } waiting[MCV_BVH_STACK] = {{0, 0, 0, 1}};
    uint32_t waits = 1, count = 0;
    while (waits) {
        const uint32_t node = waiting[--waits].node, level = waiting[waits].level, here = count++;
        if (level > MCV_BVH_LEVELS) return false;
        u->bvh->nodes[here] = u->nodes[node];
        u->bvh->nodes[here].extent = extent;
        if (here) u->bvh->nodes[waiting[waits].parent].child[waiting[waits].slot] = here;
        for (uint32_t k = MCV_BVH_WIDTH; k-- > 0;) {
            const uint32_t child = u->nodes[node].child[k];
            if (child & MCV_CHILD_LEAF) continue;
            waiting[waits].node = child;
            waiting[waits].parent = here;
            waiting[waits].slot = k;
            waiting[waits++].level = level + 1;
        }
    }
    u->bvh->node_count = count;
    return true;
}

/* Both hierarchies as one. False without memory; *bvh stays empty where it would be too deep. */
static bool join(update *u) {
    mcv_bvh *bvh = u->bvh;
    const uint32_t most = u->base->node_count + u->patch.node_count + MCV_BVH_WIDTH;
    bvh->leaves = mcv_bvh_allocate(u->base->leaf_count + u->patch.leaf_count, sizeof *bvh->leaves);
    bvh->nodes = mcv_bvh_allocate(most, sizeof *bvh->nodes);
    u->nodes = mcv_bvh_allocate(most, sizeof *u->nodes);
    u->leaves = malloc((size_t)u->base->leaf_count * sizeof *u->leaves + 1);
    const bool memory = bvh->leaves && bvh->nodes && u->nodes && u->leaves;
    bool shallow = false;
    if (memory) {
        const float of_base = u->base->nodes->extent,
                    of_patch = u->patch.nodes ? u->patch.nodes->extent : 0;
        keep_leaves(u);
        keep_nodes(u);
        insert_patch(u);
        shallow = place_nodes(u, mcv_larger(of_base, of_patch));
    }
    if (!shallow) mcv_bvh_free(bvh);
    free(u->nodes);
    free(u->leaves);
    return memory;
}

/* Whether most of both scenes is the same. */
static bool is_worth_it(const mcv_bvh_base *base, const update *u) {
    const uint32_t common = u->matches.found_count;
    return common > 0 && common >= u->triangle_count / LEAST_COMMON &&
           common >= base->triangle_count / LEAST_COMMON;
}

mcv_result mcv_bvh_update(const mcv_bvh_base *base, const float *positions, const uint32_t *indices,
                          uint32_t triangle_count, uint32_t threads, mcv_bvh *bvh,
                          mcv_error *error) {
    update u = {.base = &base->bvh,
                .positions = positions,
                .indices = indices,
                .triangle_count = triangle_count,
                .threads = threads,
                .bvh = bvh};
    *bvh = (mcv_bvh){0};
    mcv_result result = MCV_OK;
    bool memory = mcv_match_triangles(base, positions, indices, triangle_count, &u.matches);
    if (memory && is_worth_it(base, &u)) {
        if (u.matches.found_count < triangle_count) result = build_patch(&u, error);
        if (result == MCV_OK) memory = join(&u);
    }
    mcv_bvh_free(&u.patch);
    mcv_matches_free(&u.matches);
    return memory ? result
                  : mcv_fail(error, MCV_FAILED, "no memory to change the acceleration structure");
}

/* --- what it is made from --- */

mcv_result mcv_bvh_base_make(mcv_bvh *bvh, uint32_t triangle_count, mcv_bvh_base *base,
                             mcv_error *error) {
    *base = (mcv_bvh_base){*bvh, calloc(9 * (size_t)triangle_count + 1, sizeof *base->corners),
                           triangle_count};
    *bvh = (mcv_bvh){0};
    if (!base->corners) {
        mcv_bvh_base_free(base);
        return mcv_fail(error, MCV_FAILED, "no memory to keep the acceleration structure");
    }
    for (uint32_t i = 0; i < base->bvh.leaf_count; ++i)
        for (int lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane) {
            const mcv_leaf *leaf = base->bvh.leaves + i;
            if (leaf->triangle[lane] == MCV_NONE) continue;
            float *corners = base->corners + 9 * (size_t)leaf->triangle[lane];
            for (int k = 0; k < 9; ++k) corners[k] = leaf->vertex[k / 3][k % 3][lane];
        }
    return MCV_OK;
}

void mcv_bvh_base_free(mcv_bvh_base *base) {
    mcv_bvh_free(&base->bvh);
    free(base->corners);
    *base = (mcv_bvh_base){0};
}
