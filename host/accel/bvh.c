/* SPDX-License-Identifier: Apache-2.0 */
#include "accel/bvh_builder.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

enum {
    SPARE_TENTHS = 7, /* of the triangles: how many references spatial splits may add */
    MOST_THREADS = 256,
    MOST_TRIANGLES = 1 << 28,
};

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

void *mcv_bvh_allocate(uint32_t count, size_t size) {
    const size_t bytes = (count ? count : 1) * size;
    return aligned_alloc(128, (bytes + 127) / 128 * 128);
}

static float extent_of(const mcv_box3f *bounds) {
    float extent = 0.0f;
    for (int axis = 0; axis < 3; ++axis)
        extent = fmaxf(extent, fmaxf(fabsf(bounds->lower[axis]), fabsf(bounds->upper[axis])));
    return extent;
}

static bool build(mcv_bvh_builder *b, launch *launches) {
    b->capacity = b->triangle_count + b->triangle_count / 10 * SPARE_TENTHS;
    b->splitter.references = mcv_bvh_allocate(b->capacity, sizeof *b->splitter.references);
    /* Leaves hold a reference each at least. */
    b->chunks =
        mcv_bvh_allocate(2 * (b->capacity / MCV_BINARY_CHUNK) + b->threads + 3, sizeof *b->chunks);
    if (!b->splitter.references || !b->chunks) return false;
    run_workers(b, launches, mcv_bvh_make_references);
    mcv_record all = mcv_record_empty(0, b->triangle_count, b->capacity);
    for (uint32_t i = 0; i < b->threads; ++i) {
        mcv_box_add(&all.bounds, &launches[i].worker.bounds);
        mcv_box_add(&all.centroids, &launches[i].worker.centroids);
    }
    b->splitter.root_area = mcv_box_area(&all.bounds);
    if (!mcv_bvh_begin_binaries(b, &all)) return false;
    run_workers(b, launches, mcv_bvh_make_binaries);
    if (b->failed || !mcv_bvh_collapse(b, b->triangle_count ? extent_of(&all.bounds) : 0.0f))
        return false;
    b->bvh->leaf_count = b->leaf_count;
    b->bvh->leaves = mcv_bvh_allocate(b->leaf_count, sizeof *b->bvh->leaves);
    if (!b->bvh->leaves) return false;
    run_workers(b, launches, mcv_bvh_fill_leaves);
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
    free(b.leaf_binaries);
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
