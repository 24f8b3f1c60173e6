/* SPDX-License-Identifier: Apache-2.0 */
#include "steps.h"

#include <math.h>

typedef struct waiting {
    double entry;
    uint32_t child;
} waiting;

typedef struct counting {
    const mcv_bvh *bvh;
    const batch_ray *ray;
    bool any;
    double t;
    waiting stack[MCV_BVH_STACK];
    uint32_t depth;
    uint64_t nodes, leaves, triangles;
} counting;

/* Möller and Trumbore's test; the distance, or infinity. */
static double triangle_distance(const mcv_leaf *leaf, int lane, const batch_ray *ray) {
    double edges[2][3], offset[3], p[3], q[3], det = 0, u = 0, v = 0, t = 0;
    for (int k = 0; k < 3; ++k) {
        const double corner = leaf->vertex[0][k][lane];
        edges[0][k] = leaf->vertex[1][k][lane] - corner;
        edges[1][k] = leaf->vertex[2][k][lane] - corner;
        offset[k] = ray->origin[k] - corner;
    }
    for (int k = 0; k < 3; ++k) {
        const int i = (k + 1) % 3, j = (k + 2) % 3;
        p[k] = ray->direction[i] * edges[1][j] - ray->direction[j] * edges[1][i];
        q[k] = offset[i] * edges[0][j] - offset[j] * edges[0][i];
    }
    for (int k = 0; k < 3; ++k) {
        det += edges[0][k] * p[k];
        u += offset[k] * p[k];
        v += ray->direction[k] * q[k];
        t += edges[1][k] * q[k];
    }
    u /= det, v /= det, t /= det;
    return u >= 0 && v >= 0 && u + v <= 1 && t > 0 ? t : INFINITY;
}

static bool visit_leaf(counting *c, const mcv_leaf *leaf) {
    bool found = false;
    ++c->leaves;
    for (int lane = 0; lane < MCV_LEAF_TRIANGLES && leaf->triangle[lane] != MCV_NONE; ++lane) {
        const double t = triangle_distance(leaf, lane, c->ray);
        ++c->triangles;
        if (!(t < c->t)) continue;
        c->t = t;
        found = true;
    }
    return found;
}

static double box_entry(const mcv_node *node, int child, const batch_ray *ray, double t_max) {
    double near = 0, far = t_max;
    for (int axis = 0; axis < 3; ++axis) {
        const double inverse = 1.0 / ray->direction[axis];
        const double a = (node->bounds[axis][0][child] - (double)ray->origin[axis]) * inverse,
                     b = (node->bounds[axis][1][child] - (double)ray->origin[axis]) * inverse;
        near = fmax(near, fmin(a, b));
        far = fmin(far, fmax(a, b));
    }
    return near <= far ? near : INFINITY;
}

/* The children that the ray enters wait, the nearest on top, or in their order. */
static void visit_node(counting *c, const mcv_node *node) {
    const uint32_t bottom = c->depth;
    ++c->nodes;
    for (int child = 0; child < MCV_BVH_WIDTH && node->child[child] != MCV_NONE; ++child) {
        const double entry = box_entry(node, child, c->ray, c->t);
        if (!(entry < INFINITY)) continue;
        uint32_t place = c->depth++;
        const bool sorted = !c->any;
        for (; place > bottom && (!sorted || c->stack[place - 1].entry < entry); --place)
            c->stack[place] = c->stack[place - 1];
        c->stack[place] = (waiting){entry, node->child[child]};
    }
}

static void follow(counting *c) {
    c->depth = 1;
    c->stack[0] = (waiting){0, 0};
    while (c->depth) {
        const waiting next = c->stack[--c->depth];
        if (next.entry > c->t) continue;
        if (!(next.child & MCV_CHILD_LEAF))
            visit_node(c, c->bvh->nodes + next.child);
        else if (visit_leaf(c, c->bvh->leaves + (next.child & ~MCV_CHILD_LEAF)) && c->any)
            return;
    }
}

steps steps_count(const mcv_bvh *bvh, const batch_ray *rays, uint32_t count, bool any) {
    counting c = {.bvh = bvh, .any = any};
    for (uint32_t i = 0; i < count; ++i) {
        c.ray = rays + i;
        c.t = rays[i].t_max;
        follow(&c);
    }
    return (steps){(double)c.nodes / count, (double)c.leaves / count, (double)c.triangles / count};
}
