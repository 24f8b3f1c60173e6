/* SPDX-License-Identifier: Apache-2.0 */
/* What both kinds of splits share: planes between bins, and their costs (accel/split.c). */
#ifndef MCVISI_HOST_ACCEL_SPLIT_BINS_H
#define MCVISI_HOST_ACCEL_SPLIT_BINS_H

#include "accel/split.h"

#include <math.h>

/* Largest number of bins of an axis. */
enum { MCV_SPLIT_BINS = 32 };

/* A plane: the bins below `split` are on the left. */
typedef struct mcv_binning {
    int axis;
    uint32_t bins, split;
    float origin, scale;
} mcv_binning;

/* One instruction each, unlike fminf and fmaxf: there are no NaNs here. */
static inline float mcv_smaller(float a, float b) { return a < b ? a : b; }
static inline float mcv_larger(float a, float b) { return a > b ? a : b; }

typedef struct mcv_split_candidate {
    float cost; /* infinite: no split */
    mcv_binning plane;
    mcv_box3f left, right;
    uint32_t left_count, right_count;
} mcv_split_candidate;

static inline uint32_t mcv_bin_of(const mcv_binning *b, const mcv_reference *r) {
    return (uint32_t)((r->lower[b->axis] + r->upper[b->axis] - b->origin) * b->scale);
}

/* The cost of a side is its number of blocks, because leaves hold whole blocks. */
static inline float mcv_side_cost(const mcv_box3f *bounds, uint32_t count) {
    const uint32_t blocks = (count + MCV_LEAF_TRIANGLES - 1) / MCV_LEAF_TRIANGLES;
    return mcv_box_area(bounds) * (float)blocks;
}

mcv_binning mcv_bin_axis(const mcv_box3f *range, int axis, uint32_t bins);

/* The cheapest plane between bins; `entries` references begin and `exits` end in each bin. Replaces
 * *best if it is cheaper. */
void mcv_split_sweep(const mcv_binning *plane, const mcv_box3f *bounds, const uint32_t *entries,
                     const uint32_t *exits, mcv_split_candidate *best);

/* split_objects.c */

/* Finds no split if all centroids are in one bin on every axis. */
mcv_split_candidate mcv_find_object_split(const mcv_splitter *s, const mcv_record *r);

/* split_space.c */

mcv_split_candidate mcv_find_spatial_split(const mcv_splitter *s, const mcv_record *r);

/*
 * Distributes the references to both sides. One that lies on both is split while there is room,
 * unless it is cheaper as a whole on one side. False if a side stays empty.
 */
bool mcv_split_space(const mcv_splitter *s, const mcv_record *r, const mcv_split_candidate *by,
                     mcv_record *left, mcv_record *right);

#endif
