/* SPDX-License-Identifier: Apache-2.0 */
#include "accel/bvh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Writes the vertices into a leaf; returns whether they have moved. */
static bool move_leaf(mcv_leaf *leaf, const float *positions, const uint32_t *indices) {
    bool moved = false;
    for (int lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane) {
        if (leaf->triangle[lane] == MCV_NONE) continue;
        for (int corner = 0; corner < 3; ++corner) {
            const float *p =
                positions + 3 * (size_t)indices[3 * (size_t)leaf->triangle[lane] + (size_t)corner];
            for (int axis = 0; axis < 3; ++axis) {
                moved = moved || leaf->vertex[corner][axis][lane] != p[axis];
                leaf->vertex[corner][axis][lane] = p[axis];
            }
        }
    }
    return moved;
}

static void extend(float bounds[2], float lower, float upper) {
    bounds[0] = fminf(bounds[0], lower);
    bounds[1] = fmaxf(bounds[1], upper);
}

static void bound_leaf(const mcv_leaf *leaf, float bounds[3][2]) {
    for (int lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane)
        for (int corner = 0; corner < 3 && leaf->triangle[lane] != MCV_NONE; ++corner)
            for (int axis = 0; axis < 3; ++axis)
                extend(bounds[axis], leaf->vertex[corner][axis][lane],
                       leaf->vertex[corner][axis][lane]);
}

static void bound_node(const mcv_node *node, float bounds[3][2]) {
    for (int child = 0; child < MCV_BVH_WIDTH; ++child)
        for (int axis = 0; axis < 3 && node->child[child] != MCV_NONE; ++axis)
            extend(bounds[axis], node->bounds[axis][0][child], node->bounds[axis][1][child]);
}

static float largest_coordinate(const mcv_bvh *bvh) {
    float extent = 0;
    for (uint32_t i = 0; i < bvh->leaf_count; ++i) {
        float bounds[3][2] = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}, {INFINITY, -INFINITY}};
        bound_leaf(bvh->leaves + i, bounds);
        for (int axis = 0; axis < 3; ++axis)
            if (bounds[axis][0] <= bounds[axis][1])
                extent = fmaxf(extent, fmaxf(fabsf(bounds[axis][0]), fabsf(bounds[axis][1])));
    }
    return extent;
}

mcv_result mcv_bvh_refit(mcv_bvh *bvh, const float *positions, const uint32_t *indices,
                         mcv_error *error) {
    bool *moved = calloc((size_t)bvh->leaf_count + bvh->node_count + 1, sizeof *moved);
    if (!moved) return mcv_fail(error, MCV_FAILED, "no memory to move the acceleration structure");
    bool *moved_nodes = moved + bvh->leaf_count;
    for (uint32_t i = 0; i < bvh->leaf_count; ++i)
        moved[i] = move_leaf(bvh->leaves + i, positions, indices);
    const float extent = largest_coordinate(bvh);
    /* The number of a node is smaller than those of its children. */
    for (uint32_t i = bvh->node_count; i-- > 0;) {
        mcv_node *node = bvh->nodes + i;
        node->extent = extent;
        for (int k = 0; k < MCV_BVH_WIDTH; ++k) {
            const uint32_t child = node->child[k];
            const bool leaf = child & MCV_CHILD_LEAF;
            float bounds[3][2] = {
                {INFINITY, -INFINITY}, {INFINITY, -INFINITY}, {INFINITY, -INFINITY}};
            if (child == MCV_NONE || !(leaf ? moved[child & ~MCV_CHILD_LEAF] : moved_nodes[child]))
                continue;
            moved_nodes[i] = true;
            if (leaf)
                bound_leaf(bvh->leaves + (child & ~MCV_CHILD_LEAF), bounds);
            else
                bound_node(bvh->nodes + child, bounds);
            for (int axis = 0; axis < 3; ++axis)
                for (int side = 0; side < 2; ++side)
                    node->bounds[axis][side][k] = bounds[axis][side];
        }
    }
    free(moved);
    return MCV_OK;
}

static double area(const double size[3]) {
    return size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
}

double mcv_bvh_cost(const mcv_bvh *bvh) {
    double sum = 0, size[3];
    float all[3][2] = {{INFINITY, -INFINITY}, {INFINITY, -INFINITY}, {INFINITY, -INFINITY}};
    for (uint32_t i = 0; i < bvh->node_count; ++i)
        for (int k = 0; k < MCV_BVH_WIDTH; ++k) {
            const mcv_node *node = bvh->nodes + i;
            if (node->child[k] == MCV_NONE) continue;
            for (int axis = 0; axis < 3; ++axis)
                size[axis] = (double)node->bounds[axis][1][k] - (double)node->bounds[axis][0][k];
            sum += area(size);
        }
    if (bvh->node_count) bound_node(bvh->nodes, all);
    for (int axis = 0; axis < 3; ++axis) size[axis] = (double)all[axis][1] - (double)all[axis][0];
    return area(size) > 0 ? sum / area(size) : 0;
}
