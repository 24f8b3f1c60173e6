/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sums by key in sorted runs, in memory or in a file without a name, in the folder of the
 * environment's TMPDIR, and their merged sums. Runs are added first, then read.
 */
#ifndef MCVISI_HOST_TRANSPORT_RUNS_H
#define MCVISI_HOST_TRANSPORT_RUNS_H

#include "core/error.h"

typedef __int128 mcv_wide;

/* Items in ascending order of their keys: a key and its sums each. */
typedef struct mcv_run {
    mcv_wide *items;     /* in memory; NULL: in the file */
    uint64_t begin, end; /* items, of the file or of the array */
} mcv_run;

/* What of a run is read. */
typedef struct mcv_run_reader {
    const mcv_run *run;
    uint64_t next;         /* item of the run that is not in `items` yet */
    mcv_wide *items;       /* of the run, the current one at `at` */
    size_t at, item_count; /* in items */
    mcv_wide key;          /* of the current one */
} mcv_run_reader;

typedef struct mcv_runs {
    uint32_t cells; /* sums of an item */
    int file;       /* -1: none yet */
    mcv_run *runs;  /* those of the file first */
    size_t count, in_file;
    size_t merge_at;         /* runs in memory from which on they are merged */
    mcv_run_reader *readers; /* a heap by their current keys */
    size_t reader_count;     /* that have items left */
    size_t opened;           /* readers, those without items behind the others */
    size_t bytes;            /* of memory for reading */
    mcv_wide *merged;        /* the item that was read last */
} mcv_runs;

void mcv_runs_new(mcv_runs *runs, uint32_t cells);

/* Adds a run of so many items, [key, sums[cells]], whose keys are different. The array is from
 * malloc and changes owners, even after a failure. */
mcv_result mcv_runs_add(mcv_runs *runs, mcv_wide *items, size_t count, mcv_error *error);

/* Whether so many runs are in memory that it is worth while to merge them. */
bool mcv_runs_are_many(const mcv_runs *runs);

/* The runs in memory become one, for which memory is needed beside them. Where this makes them
 * hardly fewer items, it is worth while less often from then on. */
mcv_result mcv_runs_merge(mcv_runs *runs, mcv_error *error);

/* Writes all runs in memory to the file. */
mcv_result mcv_runs_spill(mcv_runs *runs, mcv_error *error);

/* The bytes of the runs in memory, and of what is read. */
size_t mcv_runs_bytes(const mcv_runs *runs);

/* Begins to read, with so many bytes of memory for what is in the file. */
mcv_result mcv_runs_rewind(mcv_runs *runs, size_t bytes, mcv_error *error);

/* The next key, with the sums of all runs; NULL after the last one. They last until the next
 * call. */
mcv_result mcv_runs_next(mcv_runs *runs, mcv_wide *key, const mcv_wide **sums, mcv_error *error);

void mcv_runs_free(mcv_runs *runs);

#endif
