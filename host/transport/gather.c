/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/gather.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "mcvisi/tables.h"

enum {
    FIRST_CAPACITY = 1 << 12, /* entries of a tile: 8 x 8 pixels of 64 elements */
    UNIT_BITS = 72,
    MOST_BITS = 120,
    READING_SHARE = 8, /* of the memory, for reading what is in the file */
    DIGIT_BITS = 11,
    AT_ONCE = 32 /* records whose entries are fetched together */
};

static size_t cells_of(const mcv_gather *g) { return (size_t)g->replicates * g->channels; }

/* Bytes of tables for so many entries, and of their order while they are sorted. */
static size_t bytes_for(const mcv_gather *g, size_t capacity) {
    return capacity * (2 * sizeof *g->slots + sizeof *g->keys + 2 * sizeof *g->order +
                       cells_of(g) * sizeof *g->sums);
}

static size_t first_slot(size_t capacity, uint64_t key) {
    const uint64_t hash = key * 0x9e3779b97f4a7c15u;
    return (size_t)((hash ^ hash >> 32) & (2 * capacity - 1));
}

static size_t slot_for(const mcv_gather *g, const uint32_t *slots, size_t capacity, uint64_t key) {
    size_t slot = first_slot(capacity, key);
    while (slots[slot] > 0 && g->keys[slots[slot] - 1] != key)
        slot = (slot + 1) & (2 * capacity - 1);
    return slot;
}

/* Room for twice the entries. */
static mcv_result grow(mcv_gather *g, mcv_error *error) {
    const size_t capacity = g->capacity > 0 ? 2 * g->capacity : FIRST_CAPACITY;
    uint32_t *slots = calloc(2 * capacity, sizeof *slots);
    uint64_t *keys = realloc(g->keys, capacity * sizeof *keys);
    if (keys) g->keys = keys;
    mcv_wide *sums = realloc(g->sums, capacity * cells_of(g) * sizeof *sums);
    if (sums) g->sums = sums;
    if (!slots || !keys || !sums) {
        free(slots);
        return mcv_fail(error, MCV_FAILED, "no memory for %zu entries of a matrix", capacity);
    }
    for (size_t i = 0; i < g->count; ++i) {
        if (i + AT_ONCE < g->count)
            __builtin_prefetch(slots + first_slot(capacity, g->keys[i + AT_ONCE]));
        slots[slot_for(g, slots, capacity, g->keys[i])] = (uint32_t)i + 1;
    }
    free(g->slots);
    g->slots = slots;
    g->capacity = capacity;
    return MCV_OK;
}

mcv_result mcv_gather_new(mcv_gather *gather, uint32_t channels, uint32_t replicates,
                          double brightest, size_t most_bytes, mcv_error *error) {
    int exponent = 0;
    if (brightest > 0) frexp(brightest, &exponent);
    *gather = (mcv_gather){.channels = channels,
                           .replicates = replicates,
                           .exponent = exponent - UNIT_BITS,
                           .scale = ldexp(1, UNIT_BITS - exponent),
                           .most_bytes = most_bytes};
    mcv_runs_new(&gather->runs, channels * replicates);
    if (bytes_for(gather, FIRST_CAPACITY) > most_bytes)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "--memory: too little for the light of one tile of the image: give %zu kB "
                        "or more",
                        (bytes_for(gather, FIRST_CAPACITY) * 4 / 3 + 999) / 1000);
    const mcv_result result = grow(gather, error);
    if (result != MCV_OK) mcv_gather_free(gather);
    return result;
}

/* --- what leaves memory --- */

/* Moves entries from one array to another by a digit of their keys; those of equal digits keep
 * their order. */
static void sort_digit(const mcv_sorted_key *from, mcv_sorted_key *to, size_t count, int shift) {
    enum { DIGITS = 1 << DIGIT_BITS };
    size_t begins[DIGITS + 1] = {0};
    for (size_t i = 0; i < count; ++i) ++begins[(from[i].key >> shift & (DIGITS - 1)) + 1];
    for (int d = 0; d < DIGITS; ++d) begins[d + 1] += begins[d];
    for (size_t i = 0; i < count; ++i) to[begins[from[i].key >> shift & (DIGITS - 1)]++] = from[i];
}

/* By the bits in which keys differ, from the lowest on. */
static mcv_result sort_entries(mcv_gather *g, mcv_error *error) {
    uint64_t differ = 0;
    g->order = malloc((g->count + 1) * sizeof *g->order);
    mcv_sorted_key *other = malloc((g->count + 1) * sizeof *other);
    if (!g->order || !other) {
        free(other);
        return mcv_fail(error, MCV_FAILED, "no memory for the order of entries");
    }
    for (size_t i = 0; i < g->count; ++i) {
        g->order[i] = (mcv_sorted_key){g->keys[i], i};
        differ |= g->keys[i] ^ g->keys[0];
    }
    for (int shift = 0; shift < 64 && differ >> shift; shift += DIGIT_BITS) {
        if ((differ >> shift & ((1 << DIGIT_BITS) - 1)) == 0) continue;
        sort_digit(g->order, other, g->count, shift);
        mcv_sorted_key *sorted = other;
        other = g->order;
        g->order = sorted;
    }
    free(other);
    return MCV_OK;
}

/* All entries go to the file. */
static mcv_result spill(mcv_gather *g, mcv_error *error) {
    MCV_TRY(sort_entries(g, error));
    const mcv_result result = mcv_runs_add(&g->runs, g->order, g->count, g->sums, error);
    free(g->order);
    g->order = NULL;
    g->count = 0;
    memset(g->slots, 0, 2 * g->capacity * sizeof *g->slots);
    return result;
}

/* Room for an entry. While a table grows, the old one is there, too. */
static mcv_result make_room(mcv_gather *g, mcv_error *error) {
    const bool larger = g->capacity < UINT32_MAX / 4 &&
                        bytes_for(g, 2 * g->capacity) + bytes_for(g, g->capacity) <= g->most_bytes;
    return larger ? grow(g, error) : spill(g, error);
}

static void free_tables(mcv_gather *g) {
    free(g->slots);
    free(g->keys);
    free(g->sums);
    free(g->order);
    g->slots = NULL;
    g->keys = NULL;
    g->sums = NULL;
    g->order = NULL;
    g->count = g->capacity = 0;
}

size_t mcv_gather_bytes(const mcv_gather *gather) {
    return bytes_for(gather, gather->capacity) + gather->runs.bytes;
}

mcv_result mcv_gather_sort(mcv_gather *gather, size_t left, mcv_error *error) {
    if (gather->runs.count == 0 && mcv_gather_bytes(gather) + left <= gather->most_bytes)
        return sort_entries(gather, error);
    MCV_TRY(spill(gather, error));
    free_tables(gather);
    return MCV_OK;
}

mcv_result mcv_gather_rewind(mcv_gather *gather, mcv_error *error) {
    gather->next = 0;
    return mcv_runs_rewind(&gather->runs, gather->most_bytes / READING_SHARE, error);
}

mcv_result mcv_gather_next(mcv_gather *gather, mcv_gather_entry *entry, bool *more,
                           mcv_error *error) {
    uint64_t key = 0;
    entry->sums = NULL;
    if (!gather->order) {
        MCV_TRY(mcv_runs_next(&gather->runs, &key, &entry->sums, error));
    } else if (gather->next < gather->count) {
        key = gather->order[gather->next].key;
        entry->sums = gather->sums + gather->order[gather->next++].entry * cells_of(gather);
    }
    entry->pixel = (uint32_t)(key >> 32);
    entry->element = (uint32_t)key;
    *more = entry->sums != NULL;
    return MCV_OK;
}

/* --- records --- */

/* The entry of a key, a new one if need be. */
static mcv_result find_entry(mcv_gather *g, uint64_t key, size_t *entry, mcv_error *error) {
    size_t slot = slot_for(g, g->slots, g->capacity, key);
    if (g->slots[slot] == 0) {
        if (g->count == g->capacity) {
            MCV_TRY(make_room(g, error));
            slot = slot_for(g, g->slots, g->capacity, key);
        }
        g->keys[g->count] = key;
        memset(g->sums + g->count * cells_of(g), 0, cells_of(g) * sizeof *g->sums);
        g->slots[slot] = (uint32_t)++g->count;
    }
    *entry = g->slots[slot] - 1;
    return MCV_OK;
}

/* Adds the nearest integer. A float from 2^24 units on is a whole number of them. */
static mcv_result add_value(const mcv_gather *g, mcv_wide *sum, float value, mcv_error *error) {
    const double units = (double)value * g->scale;
    if (units < 0x1p24)
        *sum += (mcv_wide)llrint(units);
    else if (units < 0x1p62)
        *sum += (mcv_wide)(int64_t)units;
    else if (units < ldexp(1, MOST_BITS))
        *sum += (mcv_wide)units;
    else
        return mcv_fail(error, MCV_FAILED,
                        "a path brings %g to a pixel, beyond the range of a matrix entry", value);
    return MCV_OK;
}

/* A shadow ray has reserved a record before its light was known. */
static bool brings_nothing(const mcv_gather *g, const uint32_t *record) {
    uint32_t bits = 0;
    for (uint32_t c = 0; c < g->channels; ++c) bits |= record[2 + c];
    return bits << 1 == 0;
}

static uint64_t key_of(const mcv_gather *g, const uint32_t *record) {
    return MCV_ENTRY_KEY(record[0] / g->replicates, g->columns ? g->columns[record[1]] : record[1]);
}

/* Entries lie anywhere in memory: so many are on their way at the same time. */
static void fetch(const mcv_gather *g, const uint32_t *records, const uint32_t *end, size_t words) {
    uint32_t slots[AT_ONCE] = {0};
    size_t count = 0;
    for (const uint32_t *r = records; r < end; r += words)
        __builtin_prefetch(g->slots + first_slot(g->capacity, key_of(g, r)));
    for (const uint32_t *r = records; r < end; r += words)
        slots[count++] = g->slots[first_slot(g->capacity, key_of(g, r))];
    for (size_t i = 0; i < count; ++i, records += words) {
        if (slots[i] == 0) continue;
        __builtin_prefetch(g->keys + slots[i] - 1);
        __builtin_prefetch(g->sums + (slots[i] - 1) * cells_of(g) +
                           (records[0] % g->replicates) * g->channels);
    }
}

static mcv_result add_record(mcv_gather *g, const uint32_t *record, mcv_error *error) {
    size_t entry;
    if (brings_nothing(g, record)) return MCV_OK;
    MCV_TRY(find_entry(g, key_of(g, record), &entry, error));
    mcv_wide *sums = g->sums + entry * cells_of(g) + (record[0] % g->replicates) * g->channels;
    for (uint32_t c = 0; c < g->channels; ++c) {
        float value;
        memcpy(&value, record + 2 + c, sizeof value);
        MCV_TRY(add_value(g, sums + c, value, error));
    }
    return MCV_OK;
}

mcv_result mcv_gather_add(void *user, const uint32_t *records, size_t count, mcv_error *error) {
    mcv_gather *g = user;
    const size_t words = MCV_RECORD_WORDS(g->channels);
    for (size_t first = 0; first < count; first += AT_ONCE) {
        const size_t some = count - first < AT_ONCE ? count - first : AT_ONCE;
        const uint32_t *record = records + first * words, *end = record + some * words;
        fetch(g, record, end, words);
        for (; record < end; record += words) MCV_TRY(add_record(g, record, error));
    }
    return MCV_OK;
}

void mcv_gather_free(mcv_gather *gather) {
    free_tables(gather);
    mcv_runs_free(&gather->runs);
}
