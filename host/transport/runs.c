/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/runs.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { WRITTEN_ITEMS = 1024, READ_ITEMS = 4096 };

/* Words of an item: its key, then its sums. */
static size_t words_of(const mcv_runs *r) { return 1 + (size_t)r->cells; }

static size_t bytes_of(const mcv_runs *r) { return words_of(r) * sizeof(mcv_wide); }

void mcv_runs_new(mcv_runs *runs, uint32_t cells) {
    *runs = (mcv_runs){.cells = cells, .file = -1};
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

mcv_result mcv_runs_add(mcv_runs *runs, const mcv_sorted_key *order, size_t count,
                        const mcv_wide *sums, mcv_error *error) {
    const size_t words = words_of(runs);
    if (count == 0) return MCV_OK;
    MCV_TRY(open_file(runs, error));
    uint64_t *ends = realloc(runs->ends, (runs->count + 1) * sizeof *ends);
    if (ends) runs->ends = ends;
    mcv_wide *items = malloc(WRITTEN_ITEMS * bytes_of(runs));
    mcv_result result = ends && items ? MCV_OK : no_memory(error);
    for (size_t first = 0; result == MCV_OK && first < count; first += WRITTEN_ITEMS) {
        const size_t some = count - first < WRITTEN_ITEMS ? count - first : WRITTEN_ITEMS;
        for (size_t i = 0; i < some; ++i) {
            const mcv_sorted_key *sorted = order + first + i;
            items[i * words] = (mcv_wide)sorted->key;
            memcpy(items + i * words + 1, sums + sorted->entry * runs->cells,
                   runs->cells * sizeof *sums);
        }
        result = write_items(runs, items, some, error);
    }
    free(items);
    MCV_TRY(result);
    runs->ends[runs->count] = (runs->count > 0 ? runs->ends[runs->count - 1] : 0) + count;
    ++runs->count;
    return MCV_OK;
}

/* --- reading --- */

/* Reads the run's next items; it has some. */
static mcv_result fill(const mcv_runs *r, mcv_run_reader *reader, size_t most, mcv_error *error) {
    const uint64_t left = reader->end - reader->next;
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

static uint64_t key_of(const mcv_runs *r, size_t reader) {
    const mcv_run_reader *of = r->readers + reader;
    return (uint64_t)of->items[of->at * words_of(r)];
}

/* Moves a reader down the heap to its place. */
static void sift(mcv_runs *r, size_t i) {
    for (;;) {
        size_t least = i;
        for (size_t child = 2 * i + 1; child <= 2 * i + 2 && child < r->reader_count; ++child)
            if (key_of(r, child) < key_of(r, least)) least = child;
        if (least == i) return;
        const mcv_run_reader moved = r->readers[i];
        r->readers[i] = r->readers[least];
        r->readers[least] = moved;
        i = least;
    }
}

static size_t items_at_once(const mcv_runs *r) {
    const size_t most = r->bytes / (r->count * bytes_of(r));
    return most < 1 ? 1 : most > READ_ITEMS ? READ_ITEMS : most;
}

static void free_readers(mcv_runs *r) {
    for (size_t i = 0; r->readers && i < r->count; ++i) free(r->readers[i].items);
    free(r->readers);
    free(r->merged);
    r->readers = NULL;
    r->merged = NULL;
}

mcv_result mcv_runs_rewind(mcv_runs *runs, size_t bytes, mcv_error *error) {
    free_readers(runs);
    runs->bytes = bytes;
    runs->reader_count = runs->count;
    if (runs->count == 0) return MCV_OK;
    runs->readers = calloc(runs->count, sizeof *runs->readers);
    runs->merged = malloc(bytes_of(runs));
    if (!runs->readers || !runs->merged) return no_memory(error);
    for (size_t i = 0; i < runs->count; ++i) {
        mcv_run_reader *reader = runs->readers + i;
        reader->next = i > 0 ? runs->ends[i - 1] : 0;
        reader->end = runs->ends[i];
        reader->items = malloc(items_at_once(runs) * bytes_of(runs));
        if (!reader->items) return no_memory(error);
        MCV_TRY(fill(runs, reader, items_at_once(runs), error));
    }
    for (size_t i = runs->count; i > 0; --i) sift(runs, i - 1);
    return MCV_OK;
}

/* The reader at the top goes on by an item; without one it leaves the heap, and stays behind it. */
static mcv_result advance(mcv_runs *r, mcv_error *error) {
    mcv_run_reader *top = r->readers;
    if (++top->at == top->item_count) {
        if (top->next < top->end) {
            MCV_TRY(fill(r, top, items_at_once(r), error));
        } else {
            const mcv_run_reader done = *top;
            *top = r->readers[--r->reader_count];
            r->readers[r->reader_count] = done;
        }
    }
    sift(r, 0);
    return MCV_OK;
}

mcv_result mcv_runs_next(mcv_runs *runs, uint64_t *key, const mcv_wide **sums, mcv_error *error) {
    *sums = NULL;
    if (runs->reader_count == 0) return MCV_OK;
    *key = key_of(runs, 0);
    memset(runs->merged, 0, runs->cells * sizeof *runs->merged);
    while (runs->reader_count > 0 && key_of(runs, 0) == *key) {
        const mcv_wide *item = runs->readers->items + runs->readers->at * words_of(runs) + 1;
        for (uint32_t c = 0; c < runs->cells; ++c) runs->merged[c] += item[c];
        MCV_TRY(advance(runs, error));
    }
    *sums = runs->merged;
    return MCV_OK;
}

void mcv_runs_free(mcv_runs *runs) {
    free_readers(runs);
    free(runs->ends);
    if (runs->file >= 0) close(runs->file);
    mcv_runs_new(runs, runs->cells);
}
