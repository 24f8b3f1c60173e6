/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Adds up the records of a render (kernels/stage/record_light.h) by pixel, element, replicate and
 * channel. Sums are integers of 128 bits, so that they do not depend on the records' order: the
 * same seed gives the same bits on each device and in both schedules.
 *
 * Records are sorted in portions that the processor's caches hold, and added up in this order:
 * where each sample finds an element of its own, sums lie anywhere in memory, and to look for them
 * takes longer than to sort. A render goes through the image tile by tile, so that a sum is in one
 * portion, mostly. Sums that have no room in memory go to a file, and come back in the order of
 * pixels and elements (transport/runs.h): any image has room.
 */
#ifndef MCVISI_HOST_TRANSPORT_GATHER_H
#define MCVISI_HOST_TRANSPORT_GATHER_H

#include "transport/runs.h"

typedef struct mcv_gather {
    uint32_t channels, replicates;
    int exponent;            /* sums are in units of 2^exponent */
    double scale;            /* 2^-exponent */
    size_t most_bytes;       /* memory that it may take */
    const uint32_t *columns; /* of each element the one that it counts as; NULL: itself */
    size_t count;            /* entries, or more: those of each run count */
    size_t room, waiting;    /* records that wait to be added up, and for how many there is room */
    struct mcv_waiting *order[2]; /* their keys, and room to sort them */
    float *values;                /* [record][channel] */
    mcv_runs
        runs; /* sums, [channel], by pixel, element and replicate: no replicate without light */
    mcv_wide *sums; /* of the entry that was read last: [replicate][channel] */
    mcv_wide next;  /* key of what is read next, whose sums are next_sums; or -1 */
    mcv_wide next_sums[3];
} mcv_gather;

/* One element's light in one pixel. */
#define MCV_ENTRY_KEY(pixel, element) ((uint64_t)(pixel) << 32 | (element))
typedef struct mcv_gather_entry {
    uint32_t pixel, element;
    const mcv_wide *sums; /* [replicate][channel] */
} mcv_gather_entry;

/*
 * An empty one. `brightest` is about the largest value of a pixel: the unit is 2^-72 of it, and a
 * sum has room for 2^54 of it. MCV_BAD_INPUT if the memory has no room for the light of one tile of
 * the image.
 */
mcv_result mcv_gather_new(mcv_gather *gather, uint32_t channels, uint32_t replicates,
                          double brightest, size_t most_bytes, mcv_error *error);

/* Adds records; `user` is the gather (mcv_records_told). */
mcv_result mcv_gather_add(void *user, const uint32_t *records, size_t count, mcv_error *error);

/* After the last records: keeps the sums in memory if there is room beside them for so many bytes,
 * and so many for each entry, for what is made of them; else all go to the file. */
mcv_result mcv_gather_sort(mcv_gather *gather, size_t beside, size_t of_entry, mcv_error *error);

/*
 * The largest sum of a row, a pixel and a channel, over all replicates. Rows are summed up side by
 * side, which is faster than to read the entries in order. False where sums are in the file, or
 * where memory has no room for so many rows.
 */
bool mcv_gather_largest_row(const mcv_gather *gather, size_t rows, mcv_wide *largest);

/* Begins to read all entries, sorted by pixel and element. */
mcv_result mcv_gather_rewind(mcv_gather *gather, mcv_error *error);

/* The next one; *more: there was one. Its sums last until the next call. */
mcv_result mcv_gather_next(mcv_gather *gather, mcv_gather_entry *entry, bool *more,
                           mcv_error *error);

/* The bytes that it takes now. */
size_t mcv_gather_bytes(const mcv_gather *gather);

void mcv_gather_free(mcv_gather *gather);

#endif
