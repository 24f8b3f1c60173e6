/* SPDX-License-Identifier: Apache-2.0 */
#include "embree_builder.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A node with `count` triangles, or an inner one. */
struct embree_node {
    uint32_t triangles[MCV_LEAF_TRIANGLES], triangle_count;
    uint32_t child_count;
    struct embree_node *children[MCV_BVH_WIDTH];
    struct RTCBounds bounds[MCV_BVH_WIDTH];
};

static void *create_node(RTCThreadLocalAllocator allocator, unsigned count, void *user) {
    embree_node *node = rtcThreadLocalAlloc(allocator, sizeof *node, 16);
    (void)user;
    node->triangle_count = 0;
    node->child_count = count;
    return node;
}

static void set_children(void *user, void **children, unsigned count, void *builder) {
    embree_node *node = user;
    (void)builder;
    for (unsigned i = 0; i < count; ++i) node->children[i] = children[i];
}

static void set_bounds(void *user, const struct RTCBounds **bounds, unsigned count, void *builder) {
    embree_node *node = user;
    (void)builder;
    for (unsigned i = 0; i < count; ++i) node->bounds[i] = *bounds[i];
}

static void *create_leaf(RTCThreadLocalAllocator allocator,
                         const struct RTCBuildPrimitive *primitives, size_t count, void *user) {
    embree_node *leaf = create_node(allocator, 0, user);
    /* Two parts of one triangle may meet again. */
    for (size_t i = 0; i < count; ++i) {
        bool there = false;
        for (uint32_t k = 0; k < leaf->triangle_count; ++k)
            there = there || leaf->triangles[k] == primitives[i].primID;
        if (!there) leaf->triangles[leaf->triangle_count++] = primitives[i].primID;
    }
    return leaf;
}

static const float *corner_of(const mesh *m, uint32_t triangle, int corner) {
    return m->positions + 3 * (size_t)m->indices[3 * (size_t)triangle + (size_t)corner];
}

static void grow(float lower[3], float upper[3], const float p[3]) {
    for (int k = 0; k < 3; ++k) {
        lower[k] = fminf(lower[k], p[k]);
        upper[k] = fmaxf(upper[k], p[k]);
    }
}

/* The boxes of the parts of a triangle on both sides of a plane, within the box of what is split.
 */
static void split_primitive(const struct RTCBuildPrimitive *primitive, unsigned axis, float plane,
                            struct RTCBounds *left, struct RTCBounds *right, void *user) {
    const embree_builder *b = user;
    const float lower[3] = {primitive->lower_x, primitive->lower_y, primitive->lower_z};
    const float upper[3] = {primitive->upper_x, primitive->upper_y, primitive->upper_z};
    float low[2][3], high[2][3];
    for (int k = 0; k < 6; ++k) {
        low[k / 3][k % 3] = INFINITY;
        high[k / 3][k % 3] = -INFINITY;
    }
    for (int corner = 0; corner < 3; ++corner) {
        const float *p = corner_of(b->mesh, primitive->primID, corner),
                    *q = corner_of(b->mesh, primitive->primID, (corner + 1) % 3);
        if (p[axis] <= plane) grow(low[0], high[0], p);
        if (p[axis] >= plane) grow(low[1], high[1], p);
        if ((p[axis] < plane) == (q[axis] < plane)) continue;
        const double t = ((double)plane - p[axis]) / ((double)q[axis] - p[axis]);
        float crossing[3];
        for (int k = 0; k < 3; ++k) crossing[k] = (float)(p[k] + t * ((double)q[k] - p[k]));
        crossing[axis] = plane;
        for (int side = 0; side < 2; ++side) grow(low[side], high[side], crossing);
    }
    for (int k = 0; k < 6; ++k) {
        low[k / 3][k % 3] = fmaxf(low[k / 3][k % 3], lower[k % 3]);
        high[k / 3][k % 3] = fminf(high[k / 3][k % 3], upper[k % 3]);
    }
    *left = (struct RTCBounds){low[0][0],  low[0][1],  low[0][2],  0,
                               high[0][0], high[0][1], high[0][2], 0};
    *right = (struct RTCBounds){low[1][0],  low[1][1],  low[1][2],  0,
                                high[1][0], high[1][1], high[1][2], 0};
}

mcv_result embree_builder_open(RTCDevice device, const mesh *m, enum RTCBuildQuality quality,
                               embree_builder *b, mcv_error *error) {
    const uint32_t n = m->triangle_count;
    b->mesh = m;
    b->quality = quality;
    b->capacity = n + n / 10 * 3;
    b->all = malloc(n * sizeof *b->all);
    b->primitives = aligned_alloc(64, (b->capacity * sizeof *b->primitives + 63) / 64 * 64);
    b->bvh = rtcNewBVH(device);
    if (!b->all || !b->primitives)
        return mcv_fail(error, MCV_FAILED, "no memory for Embree's builder");
    for (uint32_t i = 0; i < n; ++i) {
        float lower[3] = {INFINITY, INFINITY, INFINITY},
              upper[3] = {-INFINITY, -INFINITY, -INFINITY};
        for (int corner = 0; corner < 3; ++corner) grow(lower, upper, corner_of(m, i, corner));
        b->all[i] = (struct RTCBuildPrimitive){lower[0], lower[1], lower[2], 0,
                                               upper[0], upper[1], upper[2], i};
    }
    return MCV_OK;
}

void embree_builder_close(embree_builder *b) {
    free(b->all);
    free(b->primitives);
    if (b->bvh) rtcReleaseBVH(b->bvh);
    mcv_bvh_free(&b->made);
}

mcv_result embree_builder_run(void *user, mcv_error *error) {
    embree_builder *b = user;
    memcpy(b->primitives, b->all, b->mesh->triangle_count * sizeof *b->all);
    struct RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = b->quality;
    arguments.maxBranchingFactor = MCV_BVH_WIDTH;
    arguments.maxDepth = MCV_BVH_LEVELS - 1;
    arguments.sahBlockSize = arguments.maxLeafSize = MCV_LEAF_TRIANGLES;
    arguments.bvh = b->bvh;
    arguments.primitives = b->primitives;
    arguments.primitiveCount = b->mesh->triangle_count;
    arguments.primitiveArrayCapacity = b->capacity;
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    arguments.splitPrimitive = split_primitive;
    arguments.userPtr = b;
    b->root = rtcBuildBVH(&arguments);
    return b->root ? MCV_OK : mcv_fail(error, MCV_FAILED, "Embree built nothing");
}

static void count_nodes(const embree_node *node, uint32_t level, mcv_bvh *made, uint32_t *levels) {
    if (level > *levels) *levels = level;
    ++made->node_count;
    for (uint32_t i = 0; i < node->child_count; ++i) {
        if (node->children[i]->child_count == 0)
            ++made->leaf_count;
        else
            count_nodes(node->children[i], level + 1, made, levels);
    }
}

static void place_leaf(const mesh *m, const embree_node *from, mcv_leaf *leaf) {
    *leaf = (mcv_leaf){.triangle = {MCV_NONE, MCV_NONE, MCV_NONE, MCV_NONE}};
    for (uint32_t lane = 0; lane < from->triangle_count; ++lane) {
        leaf->triangle[lane] = from->triangles[lane];
        for (int i = 0; i < 9; ++i)
            leaf->vertex[i / 3][i % 3][lane] = corner_of(m, from->triangles[lane], i / 3)[i % 3];
    }
}

/* Depth first, as ours. */
static uint32_t place_node(const mesh *m, const embree_node *from, float extent, mcv_bvh *made) {
    const uint32_t here = made->node_count++;
    mcv_node *node = made->nodes + here;
    node->extent = extent;
    for (uint32_t i = 0; i < MCV_BVH_WIDTH; ++i) {
        node->child[i] = MCV_NONE;
        for (int axis = 0; axis < 3; ++axis) {
            node->bounds[axis][0][i] =
                i < from->child_count ? (&from->bounds[i].lower_x)[axis] : INFINITY;
            node->bounds[axis][1][i] =
                i < from->child_count ? (&from->bounds[i].upper_x)[axis] : -INFINITY;
        }
        if (i >= from->child_count || from->children[i]->child_count > 0) continue;
        place_leaf(m, from->children[i], made->leaves + made->leaf_count);
        node->child[i] = MCV_CHILD_LEAF | made->leaf_count++;
    }
    for (uint32_t i = 0; i < from->child_count; ++i) {
        if (from->children[i]->child_count > 0)
            node->child[i] = place_node(m, from->children[i], extent, made);
    }
    return here;
}

mcv_result embree_builder_convert(embree_builder *b, float extent, mcv_error *error) {
    uint32_t levels = 0;
    mcv_bvh *made = &b->made;
    if (b->root->child_count == 0) return mcv_fail(error, MCV_FAILED, "Embree built a single leaf");
    count_nodes(b->root, 1, made, &levels);
    if (levels > MCV_BVH_LEVELS)
        return mcv_fail(error, MCV_FAILED, "Embree's hierarchy has %u levels, ours at most %d",
                        levels, MCV_BVH_LEVELS);
    made->nodes = aligned_alloc(128, made->node_count * sizeof *made->nodes);
    made->leaves = aligned_alloc(128, (made->leaf_count * sizeof *made->leaves + 127) / 128 * 128);
    if (!made->nodes || !made->leaves)
        return mcv_fail(error, MCV_FAILED, "no memory for Embree's hierarchy");
    made->node_count = made->leaf_count = 0;
    place_node(b->mesh, b->root, extent, made);
    return MCV_OK;
}
