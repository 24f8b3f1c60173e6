/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A structure while it is built, and what one thread of its builder works with: a binary hierarchy
 * first (accel/bvh_binary.c), whose nodes are then gathered into nodes of eight
 * (accel/bvh_collapse.c).
 */
#ifndef MCVISI_HOST_ACCEL_BVH_BUILDER_H
#define MCVISI_HOST_ACCEL_BVH_BUILDER_H

#include "accel/bvh.h"
#include "accel/split.h"

#include <pthread.h>

enum {
    MCV_BINARY_CHUNK = 512, /* binary nodes per allocation */
    /* Gathering the highest nodes first, a node of eight takes three levels of any binary hierarchy
     * at least: 1 + 2 + 4 nodes. */
    MCV_BINARY_LEVELS = 3 * MCV_BVH_LEVELS,
};

/*
 * A node of the binary hierarchy, or a leaf. Under it there are to be 1 … 8 nodes of eight or
 * leaves side by side, the roots: costs[n - 1] is the least cost of all that is under it with at
 * most n roots.
 */
typedef struct mcv_binary {
    float lower[3], upper[3];
    uint32_t children[2]; /* of a leaf: its first reference, and MCV_CHILD_LEAF | their number */
    float costs[MCV_BVH_WIDTH];
    uint8_t left_roots[MCV_BVH_WIDTH]; /* how many of the roots are the left child's; 0: one root
                                          less costs as little. Of a single root: of its children */
    uint8_t height;                    /* levels of binary nodes under it */
    uint8_t pending;                   /* a task makes some of it: its costs come last */
} mcv_binary;

/* What is under a binary node, to be made; its level (the root's is 0). */
typedef struct mcv_bvh_task {
    uint32_t binary, level;
    mcv_record content;
} mcv_bvh_task;

typedef struct mcv_bvh_builder {
    mcv_splitter splitter;
    uint32_t triangle_count, threads;
    uint32_t capacity; /* references, those of spatial splits included */
    /* Binary nodes are numbered in the order in which the threads happen to make them. */
    mcv_binary **chunks;
    uint32_t chunk_count;
    uint32_t leaf_count;
    mcv_bvh_task *tasks;
    uint32_t task_count, task_capacity, busy;
    bool failed;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    mcv_bvh *bvh;
    uint32_t *leaf_binaries; /* per leaf */
} mcv_bvh_builder;

/* The state of one thread. */
typedef struct mcv_bvh_worker {
    mcv_bvh_builder *builder;
    uint32_t number;
    uint32_t next_binary, binaries_left; /* of its current chunk */
    uint32_t leaf_count;
    mcv_box3f bounds, centroids; /* of its share of the triangles */
} mcv_bvh_worker;

static inline mcv_binary *mcv_bvh_binary(const mcv_bvh_builder *b, uint32_t number) {
    return b->chunks[number / MCV_BINARY_CHUNK] + number % MCV_BINARY_CHUNK;
}

static inline bool mcv_binary_is_leaf(const mcv_binary *n) {
    return n->children[1] & MCV_CHILD_LEAF;
}

/* This worker's part of n things. */
void mcv_bvh_share(const mcv_bvh_worker *w, uint32_t n, uint32_t *begin, uint32_t *end);

/* bvh_triangles.c */

/* The references to this worker's part of the triangles, and their boxes. */
void mcv_bvh_make_references(mcv_bvh_worker *w);

/* This worker's part of the leaves from the references that they hold. */
void mcv_bvh_fill_leaves(mcv_bvh_worker *w);

/* bvh_binary.c */

/* Makes the root's binary node and the task to fill it. False without memory. */
bool mcv_bvh_begin_binaries(mcv_bvh_builder *b, const mcv_record *all);

/* Works on tasks until there are none. */
void mcv_bvh_make_binaries(mcv_bvh_worker *w);

/* bvh_collapse.c */

/* The costs of a binary node from those of its children. */
void mcv_binary_cost(const mcv_bvh_builder *b, mcv_binary *n);

/* The nodes of eight from the binary ones, and which leaf each leaf is. False without memory. */
bool mcv_bvh_collapse(mcv_bvh_builder *b, float extent);

/* Aligned to 128 bytes. */
void *mcv_bvh_allocate(uint32_t count, size_t size);

#endif
