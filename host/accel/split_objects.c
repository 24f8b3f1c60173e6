/* SPDX-License-Identifier: Apache-2.0 */
/* Splits by the surface area heuristic over binned centroids. */
#include "accel/split_bins.h"

#include <pthread.h>

enum {
    MOST_BINNERS = 16,     /* most threads that bin one record */
    LEAST_SHARE = 1 << 16, /* references that are worth a thread, some milliseconds */
};

/* A range of references sorted into the bins of all axes. */
typedef struct object_bins {
    const mcv_splitter *splitter;
    const mcv_binning *axes;
    uint32_t begin, end;
    mcv_box3f bounds[3][MCV_SPLIT_BINS];
    uint32_t counts[3][MCV_SPLIT_BINS];
} object_bins;

static void *fill_bins(void *user) {
    object_bins *b = user;
    for (int axis = 0; axis < 3; ++axis) {
        for (uint32_t i = 0; i < b->axes[axis].bins; ++i) {
            b->bounds[axis][i] = mcv_box3f_empty();
            b->counts[axis][i] = 0;
        }
    }
    for (uint32_t i = b->begin; i < b->end; ++i) {
        const mcv_reference *here = b->splitter->references + i;
        const mcv_box3f added = mcv_reference_box(here);
        for (int axis = 0; axis < 3; ++axis) {
            const uint32_t bin = mcv_bin_of(&b->axes[axis], here);
            mcv_box_add(&b->bounds[axis][bin], &added);
            ++b->counts[axis][bin];
        }
    }
    return NULL;
}

static void merge_bins(object_bins *into, const object_bins *other) {
    for (int axis = 0; axis < 3; ++axis) {
        for (uint32_t i = 0; i < into->axes[axis].bins; ++i) {
            mcv_box_add(&into->bounds[axis][i], &other->bounds[axis][i]);
            into->counts[axis][i] += other->counts[axis][i];
        }
    }
}

/* Divides the range among the threads; if one cannot be started, the caller does its part. */
static void fill_bins_together(object_bins *all, uint32_t threads) {
    const uint32_t begin = all->begin, count = all->end - all->begin;
    object_bins parts[MOST_BINNERS];
    pthread_t handles[MOST_BINNERS];
    bool started[MOST_BINNERS];
    for (uint32_t i = 1; i < threads; ++i) {
        parts[i].splitter = all->splitter;
        parts[i].axes = all->axes;
        parts[i].begin = begin + (uint32_t)((uint64_t)count * i / threads);
        parts[i].end = begin + (uint32_t)((uint64_t)count * (i + 1) / threads);
        started[i] = pthread_create(handles + i, NULL, fill_bins, parts + i) == 0;
    }
    all->end = begin + count / threads;
    fill_bins(all);
    for (uint32_t i = 1; i < threads; ++i) {
        if (started[i])
            pthread_join(handles[i], NULL);
        else
            fill_bins(parts + i);
        merge_bins(all, parts + i);
    }
}

mcv_split_candidate mcv_find_object_split(const mcv_splitter *s, const mcv_record *r) {
    const uint32_t count = mcv_record_count(r), wanted = 4 + count / 16;
    mcv_binning axes[3];
    mcv_split_candidate best = {.cost = INFINITY};
    for (int axis = 0; axis < 3; ++axis)
        axes[axis] =
            mcv_bin_axis(&r->centroids, axis, wanted < MCV_SPLIT_BINS ? wanted : MCV_SPLIT_BINS);
    object_bins all;
    all.splitter = s;
    all.axes = axes;
    all.begin = r->begin;
    all.end = r->end;
    /* While there are few records of this size, few threads are busy. */
    const uint32_t threads = count / LEAST_SHARE < s->threads ? count / LEAST_SHARE : s->threads;
    if (threads > 1)
        fill_bins_together(&all, threads < MOST_BINNERS ? threads : MOST_BINNERS);
    else
        fill_bins(&all);
    for (int axis = 0; axis < 3; ++axis)
        mcv_split_sweep(&axes[axis], all.bounds[axis], all.counts[axis], all.counts[axis], &best);
    return best;
}
