/* SPDX-License-Identifier: Apache-2.0 */
#include "accel/bvh_builder.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

enum {
    CHUNK = 256,      /* draft nodes per allocation */
    GRAIN = 4096,     /* triangles that one thread finishes by itself */
    SPARE_TENTHS = 3, /* tenths of the triangles: room for references that spatial splits add */
    MOST_THREADS = 256,
    MOST_TRIANGLES = 1 << 28,
};

/* Levels that n triangles need if every node halves them evenly. */
static uint32_t levels_needed(uint32_t n) {
    uint32_t levels = 1;
    for (; n > MCV_BVH_WIDTH * MCV_LEAF_TRIANGLES; n = (n + MCV_BVH_WIDTH - 1) / MCV_BVH_WIDTH)
        ++levels;
    return levels;
}

/* Which of two children to open first: the one of larger area, or of more triangles if the areas
 * cannot be compared. */
static bool opens_before(const mcv_record *a, const mcv_record *b, bool halve) {
    const float area_a = mcv_box_area(&a->bounds), area_b = mcv_box_area(&b->bounds);
    return halve || area_a == area_b ? mcv_record_count(a) > mcv_record_count(b) : area_a > area_b;
}

/*
 * Opens the content of a node into at most 8 children. If the remaining levels are only just
 * enough, it is halved evenly, so that the depth stays within MCV_BVH_LEVELS: an uneven split costs
 * a level and needs one to spare.
 */
static uint32_t open_record(mcv_bvh_builder *b, const mcv_bvh_task *t,
                            mcv_record children[MCV_BVH_WIDTH]) {
    const bool halve =
        t->level + levels_needed(t->content.limit - t->content.begin) - 1 >= MCV_BVH_LEVELS;
    uint32_t count = 1;
    children[0] = t->content;
    while (count < MCV_BVH_WIDTH) {
        uint32_t chosen = MCV_BVH_WIDTH;
        for (uint32_t i = 0; i < count; ++i) {
            if (mcv_record_count(children + i) <= MCV_LEAF_TRIANGLES) continue;
            if (chosen == MCV_BVH_WIDTH || opens_before(children + i, children + chosen, halve))
                chosen = i;
        }
        if (chosen == MCV_BVH_WIDTH) break;
        const mcv_record opened = children[chosen];
        mcv_record_split(&b->splitter, &opened, halve, children + chosen, children + count++);
    }
    /* Any-hit queries visit children in their order: the cheapest first. */
    for (uint32_t i = 1; i < count; ++i) {
        const mcv_record moved = children[i];
        uint32_t place = i;
        for (; place > 0 && mcv_record_count(children + place - 1) > mcv_record_count(&moved);
             --place)
            children[place] = children[place - 1];
        children[place] = moved;
    }
    return count;
}

/* --- drafts --- */

static mcv_node *draft_node(const mcv_bvh_builder *b, uint32_t draft) {
    return b->chunks[draft / CHUNK] + draft % CHUNK;
}

/* A new draft node; MCV_NONE without memory. */
static uint32_t add_draft(mcv_bvh_worker *w) {
    mcv_bvh_builder *b = w->builder;
    if (w->drafts_left == 0) {
        mcv_node *chunk = malloc(CHUNK * sizeof *chunk);
        pthread_mutex_lock(&b->lock);
        if (chunk) {
            w->next_draft = b->chunk_count * CHUNK;
            w->drafts_left = CHUNK;
            b->chunks[b->chunk_count++] = chunk;
        } else {
            b->failed = true;
        }
        pthread_mutex_unlock(&b->lock);
        if (!chunk) return MCV_NONE;
    }
    --w->drafts_left;
    ++w->node_count;
    return w->next_draft++;
}

/* A draft's leaf child: the bit, the first reference, the number of references - 1. */
static uint32_t pack_leaf(const mcv_record *r) {
    return MCV_CHILD_LEAF | r->begin * MCV_LEAF_TRIANGLES | (mcv_record_count(r) - 1);
}

static void set_child(mcv_node *node, uint32_t slot, const mcv_box3f *bounds, uint32_t child) {
    for (int axis = 0; axis < 3; ++axis) {
        node->bounds[axis][0][slot] = bounds->lower[axis];
        node->bounds[axis][1][slot] = bounds->upper[axis];
    }
    node->child[slot] = child;
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

/* Makes one draft node and its subtree; large children become tasks for other threads. */
static bool make_node(mcv_bvh_worker *w, const mcv_bvh_task *t) {
    mcv_bvh_builder *b = w->builder;
    mcv_record children[MCV_BVH_WIDTH];
    const uint32_t count = mcv_record_count(&t->content) ? open_record(b, t, children) : 0;
    mcv_node *node = draft_node(b, t->draft);
    const mcv_box3f nothing = mcv_box3f_empty();
    *node = (mcv_node){.extent = b->extent};
    for (uint32_t i = count; i < MCV_BVH_WIDTH; ++i) set_child(node, i, &nothing, MCV_NONE);
    for (uint32_t i = 0; i < count; ++i) {
        if (mcv_record_count(children + i) <= MCV_LEAF_TRIANGLES) {
            set_child(node, i, &children[i].bounds, pack_leaf(children + i));
            ++w->leaf_count;
            continue;
        }
        const mcv_bvh_task under = {add_draft(w), t->level + 1, children[i]};
        if (under.draft == MCV_NONE) return false;
        set_child(node, i, &children[i].bounds, under.draft);
        if (!(mcv_record_count(children + i) > GRAIN ? push_task(b, &under) : make_node(w, &under)))
            return false;
    }
    return true;
}

static void make_nodes(mcv_bvh_worker *w) {
    mcv_bvh_builder *b = w->builder;
    pthread_mutex_lock(&b->lock);
    for (;;) {
        while (b->task_count == 0 && b->busy && !b->failed)
            pthread_cond_wait(&b->changed, &b->lock);
        if (b->task_count == 0 || b->failed) break;
        const mcv_bvh_task next = b->tasks[--b->task_count];
        ++b->busy;
        pthread_mutex_unlock(&b->lock);
        make_node(w, &next);
        pthread_mutex_lock(&b->lock);
        if (--b->busy == 0) pthread_cond_broadcast(&b->changed);
    }
    pthread_cond_broadcast(&b->changed);
    b->node_count += w->node_count;
    b->leaf_count += w->leaf_count;
    pthread_mutex_unlock(&b->lock);
}

/* --- before and after --- */

/*
 * Numbers nodes depth first, and leaves in the order of their parents, siblings together. The
 * result does not depend on the number of threads, and neighbours in space are neighbours in
 * memory.
 */
static void order(mcv_bvh_builder *b) {
    struct {
        uint32_t draft, parent, slot;
    } waiting[MCV_BVH_STACK] = {{0, 0, 0}};
    uint32_t count = 1, nodes = 0, leaves = 0;
    while (count) {
        --count;
        const uint32_t slot = waiting[count].slot, parent = waiting[count].parent, here = nodes++;
        mcv_node *node = b->bvh->nodes + here;
        *node = *draft_node(b, waiting[count].draft);
        if (here) b->bvh->nodes[parent].child[slot] = here;
        for (uint32_t i = MCV_BVH_WIDTH; i-- > 0;) {
            const uint32_t child = node->child[i];
            if (child == MCV_NONE) continue;
            if (child & MCV_CHILD_LEAF) {
                b->leaf_contents[leaves] = child;
                node->child[i] = MCV_CHILD_LEAF | leaves++;
            } else {
                waiting[count].draft = child;
                waiting[count].parent = here;
                waiting[count++].slot = i;
            }
        }
    }
}

typedef struct launch {
    mcv_bvh_worker worker;
    void (*work)(mcv_bvh_worker *);
} launch;

static void *run_launch(void *user) {
    launch *l = user;
    l->work(&l->worker);
    return NULL;
}

/* Runs work on all threads; if one cannot be started, the caller does its share. */
static void run_workers(mcv_bvh_builder *b, launch *launches, void (*work)(mcv_bvh_worker *)) {
    pthread_t threads[MOST_THREADS];
    bool started[MOST_THREADS] = {false};
    for (uint32_t i = 0; i < b->threads; ++i) {
        launches[i] = (launch){{.builder = b, .number = i}, work};
        if (i) started[i] = pthread_create(threads + i, NULL, run_launch, launches + i) == 0;
    }
    for (uint32_t i = 0; i < b->threads; ++i) {
        if (!started[i]) run_launch(launches + i);
    }
    for (uint32_t i = 0; i < b->threads; ++i) {
        if (started[i]) pthread_join(threads[i], NULL);
    }
}

static void *allocate(uint32_t count, size_t size) {
    const size_t bytes = (count ? count : 1) * size;
    return aligned_alloc(128, (bytes + 127) / 128 * 128);
}

static bool build(mcv_bvh_builder *b, launch *launches) {
    b->capacity = b->triangle_count + b->triangle_count / 10 * SPARE_TENTHS;
    b->splitter.references = allocate(b->capacity, sizeof *b->splitter.references);
    b->chunks = allocate(b->capacity / CHUNK + b->threads + 2, sizeof *b->chunks);
    if (!b->splitter.references || !b->chunks) return false;
    run_workers(b, launches, mcv_bvh_make_references);
    mcv_bvh_task root = {0, 1, mcv_record_empty(0, b->triangle_count, b->capacity)};
    for (uint32_t i = 0; i < b->threads; ++i) {
        mcv_box_add(&root.content.bounds, &launches[i].worker.bounds);
        mcv_box_add(&root.content.centroids, &launches[i].worker.centroids);
    }
    for (int axis = 0; axis < 3 && b->triangle_count; ++axis) {
        b->extent = fmaxf(b->extent, fmaxf(fabsf(root.content.bounds.lower[axis]),
                                           fabsf(root.content.bounds.upper[axis])));
    }

    b->splitter.root_area = mcv_box_area(&root.content.bounds);
    mcv_bvh_worker first = {.builder = b};
    if (add_draft(&first) == MCV_NONE || !push_task(b, &root)) return false;
    b->node_count = 1;
    run_workers(b, launches, make_nodes);
    if (b->failed) return false;

    b->bvh->nodes = allocate(b->node_count, sizeof *b->bvh->nodes);
    b->leaf_contents = allocate(b->leaf_count, sizeof *b->leaf_contents);
    if (!b->bvh->nodes || !b->leaf_contents) return false;
    order(b);
    while (b->chunk_count) free(b->chunks[--b->chunk_count]);
    b->bvh->leaves = allocate(b->leaf_count, sizeof *b->bvh->leaves);
    if (!b->bvh->leaves) return false;
    run_workers(b, launches, mcv_bvh_fill_leaves);
    b->bvh->node_count = b->node_count;
    b->bvh->leaf_count = b->leaf_count;
    return true;
}

mcv_result mcv_bvh_build(const float *positions, const uint32_t *indices, uint32_t triangle_count,
                         uint32_t threads, mcv_bvh *bvh, mcv_error *error) {
    *bvh = (mcv_bvh){0};
    if (triangle_count > MOST_TRIANGLES) {
        return mcv_fail(error, MCV_BAD_INPUT,
                        "the scene has %u triangles; the acceleration structure holds at most %d",
                        triangle_count, MOST_TRIANGLES);
    }
    if (threads == 0) {
        const long processors = sysconf(_SC_NPROCESSORS_ONLN);
        threads = processors > 0 ? (uint32_t)processors : 1;
    }
    if (threads > MOST_THREADS) threads = MOST_THREADS;
    mcv_bvh_builder b = {
        .splitter = {.positions = positions, .indices = indices, .threads = threads},
        .triangle_count = triangle_count,
        .threads = threads,
        .bvh = bvh,
        .lock = PTHREAD_MUTEX_INITIALIZER,
        .changed = PTHREAD_COND_INITIALIZER};
    launch *launches = calloc(threads, sizeof *launches);
    const bool built = launches && build(&b, launches);
    while (b.chunk_count) free(b.chunks[--b.chunk_count]);
    free(b.chunks);
    free(b.splitter.references);
    free(b.leaf_contents);
    free(b.tasks);
    free(launches);
    pthread_mutex_destroy(&b.lock);
    pthread_cond_destroy(&b.changed);
    if (built) return MCV_OK;
    mcv_bvh_free(bvh);
    return mcv_fail(
        error, MCV_FAILED,
        "no memory for the acceleration structure of %u triangles: it needs about %.0f MB",
        triangle_count, 110e-6 * triangle_count);
}

void mcv_bvh_free(mcv_bvh *bvh) {
    free(bvh->nodes);
    free(bvh->leaves);
    *bvh = (mcv_bvh){0};
}
