/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The acceleration structure that host/accel/bvh.c writes and kernels/traverse/bvh8.h reads. It is
 * a bounding volume hierarchy with eight children per node; its leaves are blocks of four
 * triangles. Nodes and leaves are structures of arrays: one float8 holds one bound of all children,
 * one float4 one coordinate of all triangles.
 */
#ifndef MCVISI_ACCEL_H
#define MCVISI_ACCEL_H

#include "mcvisi/dialect.h"

#define MCV_BVH_WIDTH 8
#define MCV_LEAF_TRIANGLES 4

/*
 * The builder makes at most this many levels of nodes. A traversal pushes all children of a node
 * and pops one, so each level leaves at most WIDTH - 1 entries, and the last one WIDTH. This bounds
 * the stack.
 */
#ifndef MCV_BVH_LEVELS
#define MCV_BVH_LEVELS 32
#endif
#define MCV_BVH_STACK (MCV_BVH_LEVELS * (MCV_BVH_WIDTH - 1) + 1)

/* A child is the index of a node, or with this bit set the index of a leaf. */
#define MCV_CHILD_LEAF 0x80000000u

/* Node 0 is the root. An unused child has the index MCV_NONE and an empty box (+inf, -inf), which
 * no ray hits. */
typedef struct mcv_node {
    float bounds[3][2][MCV_BVH_WIDTH]; /* [axis][lower, upper][child] [m] */
    uint child[MCV_BVH_WIDTH];
    float extent; /* largest |coordinate| of any vertex of the structure [m], equal in all nodes */
    uint unused[7];
} mcv_node;
MCV_ASSERT_SIZE(mcv_node, 256);

/* An unused slot has the triangle index MCV_NONE and three equal vertices, which no ray hits. */
typedef struct mcv_leaf {
    float vertex[3][3][MCV_LEAF_TRIANGLES]; /* [corner][axis][triangle] [m] */
    uint triangle[MCV_LEAF_TRIANGLES];
} mcv_leaf;
MCV_ASSERT_SIZE(mcv_leaf, 160);

/* Where a ray hits a triangle: origin + t direction = (1 - u - v) vertex 0 + u vertex 1 + v vertex
 * 2. */
typedef struct mcv_hit {
    float t, u, v;
    uint primitive; /* a triangle, or a piece of a solid (mcv_is_exact); MCV_NONE on a miss; then t
                       is the ray's t_max and u = v = 0 */
} mcv_hit;
MCV_ASSERT_SIZE(mcv_hit, 16);

#endif
