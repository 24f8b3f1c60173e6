/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The acceleration structure as host/accel/bvh.c writes it and kernels/traverse/bvh8.h reads it: a
 * bounding volume hierarchy of eight children per node whose leaves are blocks of four triangles,
 * both as structures of arrays, so that one float8 holds a bound of all children and one float4 a
 * coordinate of all triangles.
 */
#ifndef MCVISI_ACCEL_H
#define MCVISI_ACCEL_H

#include "mcvisi/dialect.h"

#define MCV_BVH_WIDTH 8
#define MCV_LEAF_TRIANGLES 4

/*
 * The builder makes at most this many levels of nodes, whatever the triangles. A traversal that
 * stacks the children of a node and takes one off again leaves at most WIDTH - 1 per level, and has
 * WIDTH of the last: this bounds its stack.
 */
#ifndef MCV_BVH_LEVELS
#define MCV_BVH_LEVELS 32
#endif
#define MCV_BVH_STACK (MCV_BVH_LEVELS * (MCV_BVH_WIDTH - 1) + 1)

/*
 * From here on the structure, some 80 bytes per triangle, is so much larger than the caches that
 * rays which diffuse surfaces send everywhere, where they leave their bundle, are faster in turns
 * than one after the other (docs/benchmark-results.md). Rays that are only refracted keep
 * together.
 */
#define MCV_MANY_TRIANGLES 200000u

/* A child is the number of a node, or with this bit the number of a leaf. */
#define MCV_CHILD_LEAF 0x80000000u

/* Node 0 is the root. An unused child has an empty box (+inf, -inf), which no ray meets, and the
 * number MCV_NONE. */
typedef struct mcv_node {
    float bounds[3][2][MCV_BVH_WIDTH]; /* [axis][lower, upper][child] [m] */
    uint child[MCV_BVH_WIDTH];
    float extent; /* the largest |coordinate| of any vertex of the whole structure [m], the same in
                     all nodes */
    uint unused[7];
} mcv_node;
MCV_ASSERT_SIZE(mcv_node, 256);

/* An unused place has the triangle number MCV_NONE and three equal vertices, which no ray meets. */
typedef struct mcv_leaf {
    float vertex[3][3][MCV_LEAF_TRIANGLES]; /* [corner][axis][triangle] [m] */
    uint triangle[MCV_LEAF_TRIANGLES];
} mcv_leaf;
MCV_ASSERT_SIZE(mcv_leaf, 160);

/* Where a ray meets a triangle: origin + t direction = (1 - u - v) vertex 0 + u vertex 1 + v
 * vertex 2. */
typedef struct mcv_hit {
    float t, u, v;
    uint triangle; /* MCV_NONE on a miss; then t is the ray's t_max and u = v = 0 */
} mcv_hit;
MCV_ASSERT_SIZE(mcv_hit, 16);

#endif
