/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/runs.h"

#include <errno.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { READ_ITEMS = 4096, FIRST_MERGE = 16 };

/* Words of an item: its key, then its sums. */
static size_t words_of(const mcv_runs *r) { return 1 + (size_t)r->cells; }

static size_t bytes_of(const mcv_runs *r) { return words_of(r) * sizeof(mcv_wide); }

void mcv_runs_new(mcv_runs *runs, uint32_t cells) {
    *runs = (mcv_runs){.cells = cells, .file = -1, .merge_at = FIRST_MERGE};
}

static mcv_result no_memory(mcv_error *error) {
    return mcv_fail(error, MCV_FAILED, "no memory for sums of a matrix");
}

/* --- writing --- */

static const char *folder(void) {
    const char *given = getenv("TMPDIR");
    return given && given[0] ? given : "/var/tmp";
}

static mcv_result open_file(mcv_runs *r, mcv_error *error) {
    char path[4096];
    if (r->file >= 0) return MCV_OK;
    const int length = snprintf(path, sizeof path, "%s/mcvisi-XXXXXX", folder());
    r->file = length > 0 && (size_t)length < sizeof path ? mkstemp(path) : -1;
    if (r->file < 0)
        return mcv_fail(error, MCV_FAILED,
                        "%s: no file can be made there for what --memory has no room for: %s; give "
                        "more, or another folder by TMPDIR",
                        folder(), strerror(errno));
    unlink(path);
    return MCV_OK;
}

static mcv_result write_items(const mcv_runs *r, const mcv_wide *items, size_t count,
                              mcv_error *error) {
    const char *bytes = (const char *)items;
    size_t left = count * bytes_of(r);
    while (left > 0) {
        const ssize_t written = write(r->file, bytes, left);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0)
            return mcv_fail(error, MCV_FAILED,
                            "%s: what --memory has no room for cannot be written there: %s; give "
                            "more, or another folder by TMPDIR",
                            folder(), strerror(errno));
        bytes += written;
        left -= (size_t)written;
    }
    return MCV_OK;
}

/* A run of items that are in memory, or in the file up to there. */
static mcv_result add_run(mcv_runs *r, mcv_run run, mcv_error *error) {
    mcv_run *runs = realloc(r->runs, (r->count + 1) * sizeof *runs);
    if (!runs) return no_memory(error);
    r->runs = runs;
    r->runs[r->count++] = run;
    return MCV_OK;
}

mcv_result mcv_runs_add(mcv_runs *runs, mcv_wide *items, size_t count, mcv_error *error) {
    if (count == 0) {
        free(items);
        return MCV_OK;
    }
    const mcv_result result = add_run(runs, (mcv_run){.items = items, .end = count}, error);
    if (result != MCV_OK) free(items);
    return result;
}

mcv_result mcv_runs_spill(mcv_runs *runs, mcv_error *error) {
    if (runs->count > runs->in_file) MCV_TRY(open_file(runs, error));
    for (; runs->in_file < runs->count; ++runs->in_file) {
        mcv_run *run = runs->runs + runs->in_file;
        MCV_TRY(write_items(runs, run->items, run->end, error));
        free(run->items);
        run->items = NULL;
        run->begin = runs->in_file > 0 ? run[-1].end : 0;
        run->end += run->begin;
    }
#ifdef __GLIBC__
    malloc_trim(0); /* else the memory stays the process's own */
#endif
    return MCV_OK;
}

/* --- reading --- */

/* Reads the run's next items from the file; it has some. */
static mcv_result fill(const mcv_runs *r, mcv_run_reader *reader, size_t most, mcv_error *error) {
    const uint64_t left = reader->run->end - reader->next;
    const size_t count = left < most ? (size_t)left : most;
    size_t done = 0;
    while (done < count * bytes_of(r)) {
        const ssize_t got = pread(r->file, (char *)reader->items + done, count * bytes_of(r) - done,
                                  (off_t)(reader->next * bytes_of(r) + done));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0)
            return mcv_fail(error, MCV_FAILED,
                            "%s: what --memory had no room for cannot be read back", folder());
        done += (size_t)got;
    }
    reader->next += count;
    reader->at = 0;
    reader->item_count = count;
    return MCV_OK;
}

/* Moves a reader down the heap to its place. */
static void sift(mcv_runs *r, size_t i) {
    for (;;) {
        size_t least = i;
        for (size_t child = 2 * i + 1; child <= 2 * i + 2 && child < r->reader_count; ++child)
            if (r->readers[child].key < r->readers[least].key) least = child;
        if (least == i) return;
        const mcv_run_reader moved = r->readers[i];
        r->readers[i] = r->readers[least];
        r->readers[least] = moved;
        i = least;
    }
}

static size_t items_at_once(const mcv_runs *r) {
    const size_t most = r->bytes / (r->in_file * bytes_of(r));
    return most < 1 ? 1 : most > READ_ITEMS ? READ_ITEMS : most;
}

static void close_readers(mcv_runs *r) {
    for (size_t i = 0; i < r->opened; ++i)
        if (!r->readers[i].run->items) free(r->readers[i].items);
    free(r->readers);
    free(r->merged);
    r->readers = NULL;
    r->merged = NULL;
    r->reader_count = r->opened = 0;
}

static mcv_result open_reader(mcv_runs *r, const mcv_run *run, mcv_error *error) {
    mcv_run_reader *reader = r->readers + r->opened++;
    *reader = (mcv_run_reader){.run = run, .next = run->begin};
    if (run->items) {
        reader->items = run->items;
        reader->next = reader->item_count = run->end;
    } else {
        reader->items = calloc(items_at_once(r), bytes_of(r));
        if (!reader->items) return no_memory(error);
        MCV_TRY(fill(r, reader, items_at_once(r), error));
    }
    reader->key = *reader->items;
    return MCV_OK;
}

/* Begins to read the runs from `first` on. */
static mcv_result open_readers(mcv_runs *r, size_t first, mcv_error *error) {
    close_readers(r);
    if (!r->runs || first == r->count) return MCV_OK;
    r->readers = calloc(r->count - first, sizeof *r->readers);
    r->merged = malloc(bytes_of(r));
    if (!r->readers || !r->merged) return no_memory(error);
    for (size_t i = first; i < r->count; ++i) MCV_TRY(open_reader(r, r->runs + i, error));
    r->reader_count = r->opened;
    for (size_t i = r->opened; i > 0; --i) sift(r, i - 1);
    return MCV_OK;
}

mcv_result mcv_runs_rewind(mcv_runs *runs, size_t bytes, mcv_error *error) {
    runs->bytes = bytes;
    return open_readers(runs, 0, error);
}

/* The reader at the top goes on by an item; without one it leaves the heap, and stays behind it. */
static mcv_result advance(mcv_runs *r, mcv_error *error) {
    mcv_run_reader *top = r->readers;
    if (++top->at == top->item_count) {
        if (top->next < top->run->end) {
            MCV_TRY(fill(r, top, items_at_once(r), error));
        } else {
            const mcv_run_reader done = *top;
            *top = r->readers[--r->reader_count];
            r->readers[r->reader_count] = done;
            sift(r, 0);
            return MCV_OK;
        }
    }
    top->key = top->items[top->at * words_of(r)];
    sift(r, 0);
    return MCV_OK;
}

mcv_result mcv_runs_next(mcv_runs *runs, mcv_wide *key, const mcv_wide **sums, mcv_error *error) {
    *sums = NULL;
    if (runs->reader_count == 0) return MCV_OK;
    *key = runs->readers->key;
    const uint32_t cells = runs->cells;
    for (uint32_t c = 0; c < cells; ++c) runs->merged[c] = 0;
    do {
        const mcv_wide *item = runs->readers->items + runs->readers->at * words_of(runs) + 1;
        for (uint32_t c = 0; c < cells; ++c) runs->merged[c] += item[c];
        MCV_TRY(advance(runs, error));
    } while (runs->reader_count > 0 && runs->readers->key == *key);
    *sums = runs->merged;
    return MCV_OK;
}

/* --- merging --- */

mcv_result mcv_runs_merge(mcv_runs *runs, mcv_error *error) {
    mcv_runs *r = runs;
    const size_t words = words_of(r);
    size_t most = 0, count = 0;
    for (size_t i = r->in_file; i < r->count; ++i) most += r->runs[i].end;
    mcv_wide *items = malloc((most + 1) * bytes_of(r));
    mcv_result result = items ? open_readers(r, r->in_file, error) : no_memory(error);
    while (result == MCV_OK) {
        const mcv_wide *sums;
        mcv_wide key = 0;
        result = mcv_runs_next(r, &key, &sums, error);
        if (result != MCV_OK || !sums) break;
        items[count * words] = key;
        memcpy(items + count++ * words + 1, sums, r->cells * sizeof *sums);
    }
    close_readers(r);
    if (result != MCV_OK) {
        free(items);
        return result;
    }
    if (count > most - most / 4) r->merge_at *= 2;
    while (r->count > r->in_file) free(r->runs[--r->count].items);
    mcv_wide *fitting = realloc(items, (count + 1) * bytes_of(r));
    return mcv_runs_add(r, fitting ? fitting : items, count, error);
}

bool mcv_runs_are_many(const mcv_runs *runs) {
    return runs->count - runs->in_file >= runs->merge_at;
}

size_t mcv_runs_bytes(const mcv_runs *runs) {
    size_t bytes = runs->in_file ? runs->bytes : 0;
    for (size_t i = runs->in_file; i < runs->count; ++i)
        bytes += runs->runs[i].end * bytes_of(runs);
    return bytes;
}

void mcv_runs_free(mcv_runs *runs) {
    close_readers(runs);
    for (size_t i = 0; i < runs->count; ++i) free(runs->runs[i].items);
    free(runs->runs);
    if (runs->file >= 0) close(runs->file);
    mcv_runs_new(runs, runs->cells);
}
