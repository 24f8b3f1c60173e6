/* SPDX-License-Identifier: Apache-2.0 */
/* The binary hierarchy: splits down to the leaves, by all threads. */
#include "accel/bvh_builder.h"

#include <stdlib.h>

enum { GRAIN = 4096 /* triangles that one thread finishes by itself */ };

/* Levels that n references need if every node halves them. */
static uint32_t levels_needed(uint32_t n) {
    uint32_t levels = 0;
    for (; n > MCV_LEAF_TRIANGLES; n = n / 2 + n % 2) ++levels;
    return levels;
}

/* A place for one more node; MCV_NONE without memory. */
static uint32_t add_binary(mcv_bvh_worker *w) {
    mcv_bvh_builder *b = w->builder;
    if (w->binaries_left == 0) {
        mcv_binary *chunk = malloc(MCV_BINARY_CHUNK * sizeof *chunk);
        pthread_mutex_lock(&b->lock);
        if (chunk) {
            w->next_binary = b->chunk_count * MCV_BINARY_CHUNK;
            w->binaries_left = MCV_BINARY_CHUNK;
            b->chunks[b->chunk_count++] = chunk;
        } else {
            b->failed = true;
        }
        pthread_mutex_unlock(&b->lock);
        if (!chunk) return MCV_NONE;
    }
    --w->binaries_left;
    return w->next_binary++;
}

static bool push_task(mcv_bvh_builder *b, const mcv_bvh_task *t) {
    pthread_mutex_lock(&b->lock);
    if (b->task_count == b->task_capacity) {
        const uint32_t capacity = b->task_capacity ? 2 * b->task_capacity : 256;
        mcv_bvh_task *grown = realloc(b->tasks, capacity * sizeof *grown);
        if (grown) {
            b->tasks = grown;
            b->task_capacity = capacity;
        } else {
            b->failed = true;
        }
    }
    const bool pushed = b->task_count < b->task_capacity;
    if (pushed) b->tasks[b->task_count++] = *t;
    pthread_cond_signal(&b->changed);
    pthread_mutex_unlock(&b->lock);
    return pushed;
}

/*
 * Makes a node and what is under it; large children are left to whoever is free. Where the levels
 * left suffice only just, the references are halved: an uneven split costs a level and needs one to
 * spare.
 */
static bool make_binary(mcv_bvh_worker *w, const mcv_bvh_task *t) {
    mcv_bvh_builder *b = w->builder;
    const mcv_record *r = &t->content;
    mcv_binary *n = mcv_bvh_binary(b, t->binary);
    *n = (mcv_binary){.children = {r->begin, MCV_CHILD_LEAF | mcv_record_count(r)}};
    for (int axis = 0; axis < 3; ++axis) {
        n->lower[axis] = r->bounds.lower[axis];
        n->upper[axis] = r->bounds.upper[axis];
    }
    if (mcv_record_count(r) <= MCV_LEAF_TRIANGLES) {
        w->leaf_count += mcv_record_count(r) > 0;
        mcv_binary_cost(b, n);
        return true;
    }
    mcv_bvh_task under[2];
    mcv_record_split(&b->splitter, r,
                     t->level + levels_needed(r->limit - r->begin) >= MCV_BINARY_LEVELS,
                     &under[0].content, &under[1].content);
    for (int side = 0; side < 2; ++side) {
        under[side].level = t->level + 1;
        under[side].binary = n->children[side] = add_binary(w);
        if (n->children[side] == MCV_NONE) return false;
    }
    for (int side = 0; side < 2; ++side) {
        const bool later = mcv_record_count(&under[side].content) > GRAIN;
        if (!(later ? push_task(b, under + side) : make_binary(w, under + side))) return false;
        n->pending |= later;
    }
    if (!n->pending) mcv_binary_cost(b, n);
    return true;
}

bool mcv_bvh_begin_binaries(mcv_bvh_builder *b, const mcv_record *all) {
    mcv_bvh_worker first = {.builder = b};
    const mcv_bvh_task root = {add_binary(&first), 0, *all};
    return root.binary != MCV_NONE && push_task(b, &root);
}

void mcv_bvh_make_binaries(mcv_bvh_worker *w) {
    mcv_bvh_builder *b = w->builder;
    pthread_mutex_lock(&b->lock);
    for (;;) {
        while (b->task_count == 0 && b->busy && !b->failed)
            pthread_cond_wait(&b->changed, &b->lock);
        if (b->task_count == 0 || b->failed) break;
        const mcv_bvh_task next = b->tasks[--b->task_count];
        ++b->busy;
        pthread_mutex_unlock(&b->lock);
        make_binary(w, &next);
        pthread_mutex_lock(&b->lock);
        if (--b->busy == 0) pthread_cond_broadcast(&b->changed);
    }
    pthread_cond_broadcast(&b->changed);
    b->leaf_count += w->leaf_count;
    pthread_mutex_unlock(&b->lock);
}
