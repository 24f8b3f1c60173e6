/* SPDX-License-Identifier: Apache-2.0 */
#include "accel/bvh.h"

#include <pthread.h>
#include <stdlib.h>
#include <unistd.h>

enum {
    MOST_BINS = 32,
    CHUNK = 256,  /* draft nodes per allocation */
    GRAIN = 4096, /* triangles that one thread finishes by itself */
    MOST_THREADS = 256,
    MOST_TRIANGLES = 1 << 28,
};

/* Four lanes, of which the last is unused, so that the compiler can use one vector instruction. */
typedef struct box {
    float lower[4], upper[4];
} box;

/* A triangle while the hierarchy is built. */
typedef struct reference {
    float lower[3];
    uint32_t triangle;
    float upper[3];
    uint32_t unused;
} reference;

/* References begin … end - 1, their box and the box of their doubled centroids (lower + upper). */
typedef struct record {
    uint32_t begin, end;
    box bounds, centroids;
} record;

/* A node to be made: its place among the drafts, its level (the root's is 1) and what lies under it. */
typedef struct task {
    uint32_t draft, level;
    record content;
} task;

typedef struct builder {
    const float *positions;
    const uint32_t *indices;
    uint32_t triangle_count, threads;
    reference *references;
    /* Draft nodes are numbered in the order in which the threads happen to make them; `order` renumbers them. */
    mcv_node **chunks;
    uint32_t chunk_count;
    uint32_t node_count, leaf_count;
    float extent;
    task *tasks;
    uint32_t task_count, task_capacity, busy;
    bool failed;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    mcv_bvh *bvh;
    uint32_t *leaf_contents; /* per leaf, as in a draft's child */
} builder;

/* What one thread works with. */
typedef struct worker {
    builder *builder;
    uint32_t number;
    uint32_t next_draft, drafts_left; /* of its current chunk */
    uint32_t node_count, leaf_count;
    box bounds, centroids; /* of its share of the triangles */
} worker;

static box box_empty(void) { return (box){{INFINITY, INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY, -INFINITY}}; }

static inline void box_add(box *a, const box *b) {
    for (int i = 0; i < 4; ++i) a->lower[i] = b->lower[i] < a->lower[i] ? b->lower[i] : a->lower[i];
    for (int i = 0; i < 4; ++i) a->upper[i] = b->upper[i] > a->upper[i] ? b->upper[i] : a->upper[i];
}

/* Half the surface; 0 for an empty box. */
static inline float box_area(const box *b) {
    const float x = b->upper[0] - b->lower[0], y = b->upper[1] - b->lower[1], z = b->upper[2] - b->lower[2];
    return x < 0.0f ? 0.0f : x * y + y * z + z * x;
}

static inline box reference_box(const reference *r) {
    return (box){{r->lower[0], r->lower[1], r->lower[2], 0.0f}, {r->upper[0], r->upper[1], r->upper[2], 0.0f}};
}

static inline box reference_centroid(const reference *r) {
    box c;
    for (int i = 0; i < 3; ++i) c.lower[i] = c.upper[i] = r->lower[i] + r->upper[i];
    c.lower[3] = c.upper[3] = 0.0f;
    return c;
}

static record record_empty(uint32_t begin, uint32_t end) { return (record){begin, end, box_empty(), box_empty()}; }

static inline void record_add(record *r, const reference *added) {
    const box bounds = reference_box(added), centroid = reference_centroid(added);
    box_add(&r->bounds, &bounds);
    box_add(&r->centroids, &centroid);
}

static uint32_t record_count(const record *r) { return r->end - r->begin; }

/* ---- splitting -------------------------------------------------------------------------------------------------- */

/* Where the doubled centroid on `axis` falls among the bins of a record. */
typedef struct binning {
    int axis;
    uint32_t bins;
    float origin, scale;
} binning;

static binning bin_axis(const record *r, int axis, uint32_t bins) {
    const float width = r->centroids.upper[axis] - r->centroids.lower[axis];
    const float scale = (float)bins * 0.99999f / width;
    return (binning){axis, bins, r->centroids.lower[axis], isfinite(scale) ? scale : 0.0f};
}

static inline uint32_t bin_of(const binning *b, const reference *r) {
    return (uint32_t)((r->lower[b->axis] + r->upper[b->axis] - b->origin) * b->scale);
}

/* Leaves hold whole blocks, so blocks are what a side costs. */
static inline float side_cost(const box *bounds, uint32_t count) {
    const uint32_t blocks = (count + MCV_LEAF_TRIANGLES - 1) / MCV_LEAF_TRIANGLES;
    return box_area(bounds) * (float)blocks;
}

/* The cheapest plane between bins: bins below *split go left. False if all centroids fall into one bin on every axis. */
static bool find_split(const builder *b, const record *r, binning *best, uint32_t *split) {
    const uint32_t wanted = 4 + record_count(r) / 16;
    const uint32_t bins = wanted < MOST_BINS ? wanted : MOST_BINS;
    box bounds[3][MOST_BINS];
    uint32_t counts[3][MOST_BINS];
    binning axes[3];
    for (int axis = 0; axis < 3; ++axis) {
        axes[axis] = bin_axis(r, axis, bins);
        for (uint32_t i = 0; i < bins; ++i) {
            bounds[axis][i] = box_empty();
            counts[axis][i] = 0;
        }
    }
    for (uint32_t i = r->begin; i < r->end; ++i) {
        const reference *here = b->references + i;
        const box added = reference_box(here);
        for (int axis = 0; axis < 3; ++axis) {
            const uint32_t bin = bin_of(&axes[axis], here);
            box_add(&bounds[axis][bin], &added);
            ++counts[axis][bin];
        }
    }
    float best_cost = INFINITY;
    bool found = false;
    for (int axis = 0; axis < 3; ++axis) {
        float right_cost[MOST_BINS];
        box side = box_empty();
        uint32_t count = 0;
        for (uint32_t i = bins; i-- > 1;) {
            box_add(&side, &bounds[axis][i]);
            count += counts[axis][i];
            right_cost[i] = count ? side_cost(&side, count) : INFINITY;
        }
        side = box_empty();
        count = 0;
        for (uint32_t i = 1; i < bins; ++i) {
            box_add(&side, &bounds[axis][i - 1]);
            count += counts[axis][i - 1];
            const float cost = count ? side_cost(&side, count) + right_cost[i] : INFINITY;
            if (cost < best_cost) {
                best_cost = cost;
                *best = axes[axis];
                *split = i;
                found = true;
            }
        }
    }
    return found;
}

/* Splits by the heuristic or, if it finds nothing or must not be asked, into halves. Both sides get at least one. */
static void split_record(builder *b, const record *r, bool halve, record *left, record *right) {
    binning best;
    uint32_t split;
    if (halve || !find_split(b, r, &best, &split)) {
        const uint32_t middle = r->begin + record_count(r) / 2;
        *left = record_empty(r->begin, middle);
        *right = record_empty(middle, r->end);
        for (uint32_t i = r->begin; i < middle; ++i) record_add(left, b->references + i);
        for (uint32_t i = middle; i < r->end; ++i) record_add(right, b->references + i);
        return;
    }
    *left = *right = record_empty(0, 0);
    uint32_t i = r->begin, j = r->end;
    while (i < j) {
        reference *here = b->references + i;
        if (bin_of(&best, here) < split) {
            record_add(left, here);
            ++i;
        } else {
            record_add(right, here);
            const reference swap = *here;
            *here = b->references[--j];
            b->references[j] = swap;
        }
    }
    left->begin = r->begin;
    left->end = right->begin = i;
    right->end = r->end;
}

/* Levels that n triangles need if every node halves them evenly. */
static uint32_t levels_needed(uint32_t n) {
    uint32_t levels = 1;
    for (; n > MCV_BVH_WIDTH * MCV_LEAF_TRIANGLES; n = (n + MCV_BVH_WIDTH - 1) / MCV_BVH_WIDTH) ++levels;
    return levels;
}

/* Of two children that could be opened, the one of larger area, or of more triangles where areas say nothing. */
static bool opens_before(const record *a, const record *b, bool halve) {
    const float area_a = box_area(&a->bounds), area_b = box_area(&b->bounds);
    return halve || area_a == area_b ? record_count(a) > record_count(b) : area_a > area_b;
}

/*
 * Opens the content of a node into at most 8 children. Where the levels left suffice only just, it is halved evenly, so
 * that the depth stays within MCV_BVH_LEVELS: an uneven split costs a level and needs one to spare.
 */
static uint32_t open_record(builder *b, const task *t, record children[MCV_BVH_WIDTH]) {
    const bool halve = t->level + levels_needed(record_count(&t->content)) - 1 >= MCV_BVH_LEVELS;
    uint32_t count = 1;
    children[0] = t->content;
    while (count < MCV_BVH_WIDTH) {
        uint32_t chosen = MCV_BVH_WIDTH;
        for (uint32_t i = 0; i < count; ++i) {
            if (record_count(children + i) <= MCV_LEAF_TRIANGLES) continue;
            if (chosen == MCV_BVH_WIDTH || opens_before(children + i, children + chosen, halve)) chosen = i;
        }
        if (chosen == MCV_BVH_WIDTH) break;
        const record opened = children[chosen];
        split_record(b, &opened, halve, children + chosen, children + count++);
    }
    return count;
}

/* ---- drafts ----------------------------------------------------------------------------------------------------- */

static mcv_node *draft_node(const builder *b, uint32_t draft) { return b->chunks[draft / CHUNK] + draft % CHUNK; }

/* A place for one more draft node; MCV_NONE without memory. */
static uint32_t add_draft(worker *w) {
    builder *b = w->builder;
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

/* A draft's leaf child: the bit, the first reference, their number - 1. */
static uint32_t pack_leaf(const record *r) { return MCV_CHILD_LEAF | r->begin * MCV_LEAF_TRIANGLES | (record_count(r) - 1); }

static void set_child(mcv_node *node, uint32_t slot, const box *bounds, uint32_t child) {
    for (int axis = 0; axis < 3; ++axis) {
        node->bounds[axis][0][slot] = bounds->lower[axis];
        node->bounds[axis][1][slot] = bounds->upper[axis];
    }
    node->child[slot] = child;
}

static bool push_task(builder *b, const task *t) {
    pthread_mutex_lock(&b->lock);
    if (b->task_count == b->task_capacity) {
        const uint32_t capacity = b->task_capacity ? 2 * b->task_capacity : 256;
        task *grown = realloc(b->tasks, capacity * sizeof *grown);
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

/* Makes one draft node and what is under it; large children are left to whoever is free. */
static bool make_node(worker *w, const task *t) {
    builder *b = w->builder;
    record children[MCV_BVH_WIDTH];
    const uint32_t count = record_count(&t->content) ? open_record(b, t, children) : 0;
    mcv_node *node = draft_node(b, t->draft);
    const box nothing = box_empty();
    *node = (mcv_node){.extent = b->extent};
    for (uint32_t i = count; i < MCV_BVH_WIDTH; ++i) set_child(node, i, &nothing, MCV_NONE);
    for (uint32_t i = 0; i < count; ++i) {
        if (record_count(children + i) <= MCV_LEAF_TRIANGLES) {
            set_child(node, i, &children[i].bounds, pack_leaf(children + i));
            ++w->leaf_count;
            continue;
        }
        const task under = {add_draft(w), t->level + 1, children[i]};
        if (under.draft == MCV_NONE) return false;
        set_child(node, i, &children[i].bounds, under.draft);
        if (!(record_count(children + i) > GRAIN ? push_task(b, &under) : make_node(w, &under))) return false;
    }
    return true;
}

static void make_nodes(worker *w) {
    builder *b = w->builder;
    pthread_mutex_lock(&b->lock);
    for (;;) {
        while (b->task_count == 0 && b->busy && !b->failed) pthread_cond_wait(&b->changed, &b->lock);
        if (b->task_count == 0 || b->failed) break;
        const task next = b->tasks[--b->task_count];
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

/* ---- before and after ------------------------------------------------------------------------------------------- */

/* This worker's part of n things. */
static void share(const worker *w, uint32_t n, uint32_t *begin, uint32_t *end) {
    *begin = (uint32_t)((uint64_t)n * w->number / w->builder->threads);
    *end = (uint32_t)((uint64_t)n * (w->number + 1) / w->builder->threads);
}

static void make_references(worker *w) {
    builder *b = w->builder;
    uint32_t begin, end;
    share(w, b->triangle_count, &begin, &end);
    record all = record_empty(begin, end);
    for (uint32_t i = begin; i < end; ++i) {
        reference *r = b->references + i;
        *r = (reference){{INFINITY, INFINITY, INFINITY}, i, {-INFINITY, -INFINITY, -INFINITY}, 0};
        for (int corner = 0; corner < 3; ++corner) {
            const float *p = b->positions + 3 * (size_t)b->indices[3 * (size_t)i + corner];
            for (int axis = 0; axis < 3; ++axis) {
                r->lower[axis] = fminf(r->lower[axis], p[axis]);
                r->upper[axis] = fmaxf(r->upper[axis], p[axis]);
            }
        }
        record_add(&all, r);
    }
    w->bounds = all.bounds;
    w->centroids = all.centroids;
}

static void fill_leaves(worker *w) {
    builder *b = w->builder;
    uint32_t begin, end;
    share(w, b->leaf_count, &begin, &end);
    for (uint32_t i = begin; i < end; ++i) {
        mcv_leaf *leaf = b->bvh->leaves + i;
        const uint32_t content = b->leaf_contents[i] & ~MCV_CHILD_LEAF;
        const uint32_t first = content / MCV_LEAF_TRIANGLES, count = content % MCV_LEAF_TRIANGLES + 1;
        *leaf = (mcv_leaf){0};
        for (uint32_t lane = 0; lane < MCV_LEAF_TRIANGLES; ++lane) {
            leaf->triangle[lane] = lane < count ? b->references[first + lane].triangle : MCV_NONE;
            if (lane >= count) continue;
            for (int corner = 0; corner < 3; ++corner) {
                const float *p = b->positions + 3 * (size_t)b->indices[3 * (size_t)leaf->triangle[lane] + corner];
                for (int axis = 0; axis < 3; ++axis) leaf->vertex[corner][axis][lane] = p[axis];
            }
        }
    }
}

/*
 * Numbers nodes depth first and leaves in the order of their parents, siblings side by side: the same for any number of
 * threads, and near in memory what is near in space.
 */
static void order(builder *b) {
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
    worker worker;
    void (*work)(worker *);
} launch;

static void *run_launch(void *user) {
    launch *l = user;
    l->work(&l->worker);
    return NULL;
}

/* Runs work on all threads; where one cannot be started, its share is done here. */
static void run_workers(builder *b, launch *launches, void (*work)(worker *)) {
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

static bool build(builder *b, launch *launches) {
    b->references = allocate(b->triangle_count, sizeof *b->references);
    b->chunks = allocate(b->triangle_count / CHUNK + b->threads + 2, sizeof *b->chunks);
    if (!b->references || !b->chunks) return false;
    run_workers(b, launches, make_references);
    task root = {0, 1, record_empty(0, b->triangle_count)};
    for (uint32_t i = 0; i < b->threads; ++i) {
        box_add(&root.content.bounds, &launches[i].worker.bounds);
        box_add(&root.content.centroids, &launches[i].worker.centroids);
    }
    for (int axis = 0; axis < 3 && b->triangle_count; ++axis) {
        b->extent = fmaxf(b->extent, fmaxf(fabsf(root.content.bounds.lower[axis]), fabsf(root.content.bounds.upper[axis])));
    }

    worker first = {.builder = b};
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
    run_workers(b, launches, fill_leaves);
    b->bvh->node_count = b->node_count;
    b->bvh->leaf_count = b->leaf_count;
    return true;
}

mcv_result mcv_bvh_build(const float *positions, const uint32_t *indices, uint32_t triangle_count, uint32_t threads, mcv_bvh *bvh,
                         mcv_error *error) {
    *bvh = (mcv_bvh){0};
    if (triangle_count > MOST_TRIANGLES) {
        return mcv_fail(error, MCV_BAD_INPUT, "the scene has %u triangles; the acceleration structure holds at most %d", triangle_count,
                        MOST_TRIANGLES);
    }
    if (threads == 0) {
        const long processors = sysconf(_SC_NPROCESSORS_ONLN);
        threads = processors > 0 ? (uint32_t)processors : 1;
    }
    if (threads > MOST_THREADS) threads = MOST_THREADS;
    builder b = {.positions = positions,
                 .indices = indices,
                 .triangle_count = triangle_count,
                 .threads = threads,
                 .bvh = bvh,
                 .lock = PTHREAD_MUTEX_INITIALIZER,
                 .changed = PTHREAD_COND_INITIALIZER};
    launch *launches = calloc(threads, sizeof *launches);
    const bool built = launches && build(&b, launches);
    while (b.chunk_count) free(b.chunks[--b.chunk_count]);
    free(b.chunks);
    free(b.references);
    free(b.leaf_contents);
    free(b.tasks);
    free(launches);
    pthread_mutex_destroy(&b.lock);
    pthread_cond_destroy(&b.changed);
    if (built) return MCV_OK;
    mcv_bvh_free(bvh);
    return mcv_fail(error, MCV_FAILED, "no memory for the acceleration structure of %u triangles: it needs about %.0f MB", triangle_count,
                    110e-6 * triangle_count);
}

void mcv_bvh_free(mcv_bvh *bvh) {
    free(bvh->nodes);
    free(bvh->leaves);
    *bvh = (mcv_bvh){0};
}
