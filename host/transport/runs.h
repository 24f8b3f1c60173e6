/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sums by key that have no room in memory: sorted runs in a file without a name, in the folder of
 * the environment's TMPDIR, and their merged sums. Runs are added first, then read.
 */
#ifndef MCVISI_HOST_TRANSPORT_RUNS_H
#define MCVISI_HOST_TRANSPORT_RUNS_H

#include "core/error.h"

typedef __int128 mcv_wide;

/* An entry in memory by its key. */
typedef struct mcv_sorted_key {
    uint64_t key;
    size_t entry;
} mcv_sorted_key;

/* What of a run is in memory. */
typedef struct mcv_run_reader {
    uint64_t next, end;    /* items of the file that are not read */
    mcv_wide *items;       /* of the run, the current one at `at` */
    size_t at, item_count; /* in items */
} mcv_run_reader;

typedef struct mcv_runs {
    uint32_t cells; /* sums of an item */
    int file;       /* -1: none yet */
    uint64_t *ends; /* [run]: items of the file up to the run's end */
    size_t count;
    mcv_run_reader *readers; /* [run], a heap by their current keys */
    size_t reader_count;     /* that have items left */
    size_t bytes;            /* of memory for reading */
    mcv_wide *merged;        /* the item that was read last */
} mcv_runs;

void mcv_runs_new(mcv_runs *runs, uint32_t cells);

/* Adds a run of entries in ascending order of their keys: sums[order[i].entry][cells]. */
mcv_result mcv_runs_add(mcv_runs *runs, const mcv_sorted_key *order, size_t count,
                        const mcv_wide *sums, mcv_error *error);

/* Begins to read, with so many bytes of memory. */
mcv_result mcv_runs_rewind(mcv_runs *runs, size_t bytes, mcv_error *error);

/* The next key, with the sums of all runs; NULL after the last one. They last until the next
 * call. */
mcv_result mcv_runs_next(mcv_runs *runs, uint64_t *key, const mcv_wide **sums, mcv_error *error);

void mcv_runs_free(mcv_runs *runs);

#endif
