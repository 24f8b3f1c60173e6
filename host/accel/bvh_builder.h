/* SPDX-License-Identifier: Apache-2.0 */
/* The state of a builder and of one of its threads (accel/bvh.c). */
#ifndef MCVISI_HOST_ACCEL_BVH_BUILDER_H
#define MCVISI_HOST_ACCEL_BVH_BUILDER_H

#include "accel/bvh.h"
#include "accel/split.h"

#include <pthread.h>

/* A node to make: its place among the drafts, its level (the root has 1) and its content. */
typedef struct mcv_bvh_task {
    uint32_t draft, level;
    mcv_record content;
} mcv_bvh_task;

typedef struct mcv_bvh_builder {
    mcv_splitter splitter;
    uint32_t triangle_count, threads;
    uint32_t capacity; /* references, those of spatial splits included */
    /* Draft nodes are numbered in the order in which threads make them; `order` renumbers them. */
    mcv_node **chunks;
    uint32_t chunk_count;
    uint32_t node_count, leaf_count;
    float extent;
    mcv_bvh_task *tasks;
    uint32_t task_count, task_capacity, busy;
    bool failed;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    mcv_bvh *bvh;
    uint32_t *leaf_contents; /* per leaf, as in a draft's child */
} mcv_bvh_builder;

/* The state of one thread. */
typedef struct mcv_bvh_worker {
    mcv_bvh_builder *builder;
    uint32_t number;
    uint32_t next_draft, drafts_left; /* of its current chunk */
    uint32_t node_count, leaf_count;
    mcv_box3f bounds, centroids; /* of its share of the triangles */
} mcv_bvh_worker;

/* The part of n things that this thread processes. */
void mcv_bvh_share(const mcv_bvh_worker *w, uint32_t n, uint32_t *begin, uint32_t *end);

/* Makes the references to this thread's part of the triangles, and their boxes. */

void mcv_bvh_make_references(mcv_bvh_worker *w);

/* Fills this thread's part of the leaves from their references. */

void mcv_bvh_fill_leaves(mcv_bvh_worker *w);

#endif
