/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/gather.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "mcvisi/tables.h"

enum {
    UNIT_BITS = 72,
    MOST_BITS = 120,
    MEMORY_SHARE = 8, /* of the memory, for records that wait, and for reading from the file */
    FEWEST_WAITING = 1 << 12, /* records that wait together: a tile of 8 x 8 pixels, 64 of each */
    MOST_WAITING = 1 << 19,
    DIGIT_BITS = 11,
};

/* A record that waits, by its entry. */
typedef struct mcv_waiting {
    uint64_t key; /* MCV_ENTRY_KEY; while it is sorted, without the bits that none has */
    uint32_t record, replicate;
} mcv_waiting;

/* Bytes of the sums that a record makes, at most. */
static size_t item_bytes(const mcv_gather *g) {
    return (1 + (size_t)g->channels) * sizeof(mcv_wide);
}

static size_t waiting_bytes(const mcv_gather *g) {
    return 2 * sizeof(mcv_waiting) + g->channels * sizeof(float);
}

mcv_result mcv_gather_new(mcv_gather *gather, uint32_t channels, uint32_t replicates,
                          double brightest, size_t most_bytes, mcv_error *error) {
    int exponent = 0;
    if (brightest > 0) frexp(brightest, &exponent);
    mcv_gather *g = gather;
    *g = (mcv_gather){.channels = channels,
                      .replicates = replicates,
                      .exponent = exponent - UNIT_BITS,
                      .scale = ldexp(1, UNIT_BITS - exponent),
                      .most_bytes = most_bytes};
    mcv_runs_new(&g->runs, channels);
    const size_t least = FEWEST_WAITING * (waiting_bytes(g) + item_bytes(g));
    if (least > most_bytes)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "--memory: too little for the light of one tile of the image: give %zu kB "
                        "or more",
                        (least * 4 / 3 + 999) / 1000);
    g->room = most_bytes / MEMORY_SHARE / (waiting_bytes(g) + item_bytes(g));
    g->room = g->room < FEWEST_WAITING ? FEWEST_WAITING
              : g->room > MOST_WAITING ? MOST_WAITING
                                       : g->room;
    for (int i = 0; i < 2; ++i) g->order[i] = malloc(g->room * sizeof **g->order);
    g->values = malloc(g->room * channels * sizeof *g->values);
    g->sums = malloc((size_t)replicates * channels * sizeof *g->sums);
    if (g->order[0] && g->order[1] && g->values && g->sums) return MCV_OK;
    mcv_gather_free(g);
    return mcv_fail(error, MCV_FAILED, "no memory for the records of a matrix");
}

/* --- sums of the records that wait --- */

/* Moves records from one array to another by a digit of their keys; those of equal digits keep
 * their order. */
static void sort_digit(const mcv_waiting *from, mcv_waiting *to, size_t count, uint32_t shift) {
    enum { DIGITS = 1 << DIGIT_BITS };
    uint32_t begins[DIGITS + 1] = {0};
    for (size_t i = 0; i < count; ++i) ++begins[(from[i].key >> shift & (DIGITS - 1)) + 1];
    for (int d = 0; d < DIGITS; ++d) begins[d + 1] += begins[d];
    for (size_t i = 0; i < count; ++i) to[begins[from[i].key >> shift & (DIGITS - 1)]++] = from[i];
}

static uint32_t bits_of(uint64_t value) {
    uint32_t bits = 0;
    while (value >> bits) ++bits;
    return bits;
}

/* By pixel and element. Returns how many bits of a key are the element's. */
static uint32_t sort_waiting(mcv_gather *g) {
    uint32_t elements = 0, pixels = 0;
    for (size_t i = 0; i < g->waiting; ++i) {
        elements |= (uint32_t)g->order[0][i].key;
        pixels |= (uint32_t)(g->order[0][i].key >> 32);
    }
    const uint32_t element_bits = bits_of(elements), bits = element_bits + bits_of(pixels);
    for (size_t i = 0; i < g->waiting; ++i) {
        const uint64_t key = g->order[0][i].key;
        g->order[0][i].key = key >> 32 << element_bits | (uint32_t)key;
    }
    for (uint32_t shift = 0; shift < bits; shift += DIGIT_BITS) {
        sort_digit(g->order[0], g->order[1], g->waiting, shift);
        mcv_waiting *sorted = g->order[1];
        g->order[1] = g->order[0];
        g->order[0] = sorted;
    }
    return element_bits;
}

/* Adds the nearest integer. A float from 2^24 units on is a whole number of them. */
static mcv_result add_value(const mcv_gather *g, mcv_wide *sum, float value, mcv_error *error) {
    const double units = (double)value * g->scale;
    if (units < 0x1p24)
        *sum += (mcv_wide)llrint(units);
    else if (units < 0x1p62)
        *sum += (mcv_wide)(int64_t)units;
    else if (units < 0x1p100) /* of 2^38 units, which takes less time than a wide conversion */
        *sum += (mcv_wide)(int64_t)(units * 0x1p-38) << 38;
    else if (units < ldexp(1, MOST_BITS))
        *sum += (mcv_wide)units;
    else
        return mcv_fail(error, MCV_FAILED,
                        "a path brings %g to a pixel, beyond the range of a matrix entry", value);
    return MCV_OK;
}

/* The sums of the records of an entry, one item for each replicate that has some. */
static mcv_result add_entry(mcv_gather *g, const mcv_waiting *records, size_t count,
                            uint32_t element_bits, mcv_wide *items, size_t *item_count,
                            mcv_error *error) {
    const size_t words = 1 + (size_t)g->channels;
    const uint64_t key = records->key, element = key & (((uint64_t)1 << element_bits) - 1);
    const mcv_wide entry = (mcv_wide)(key >> element_bits) << 64 | (mcv_wide)element << 32;
    mcv_wide *item = NULL;
    uint64_t replicates = 0; /* that have an item */
    const size_t first = *item_count;
    for (size_t i = 0; i < count; ++i) {
        const uint64_t bit = (uint64_t)1 << records[i].replicate;
        if (!(replicates & bit)) {
            /* Behind those of the replicates before it. */
            size_t at = *item_count;
            for (; at > first && (uint32_t)items[(at - 1) * words] > records[i].replicate; --at)
                memcpy(items + at * words, items + (at - 1) * words, words * sizeof *items);
            item = items + at * words;
            memset(item, 0, words * sizeof *item);
            *item = entry | records[i].replicate;
            replicates |= bit;
            ++*item_count;
        } else if ((uint32_t)*item != records[i].replicate) {
            for (item = items + first * words; (uint32_t)*item != records[i].replicate;)
                item += words;
        }
        for (uint32_t c = 0; c < g->channels; ++c)
            MCV_TRY(
                add_value(g, item + 1 + c, g->values[records[i].record * g->channels + c], error));
    }
    ++g->count;
    return MCV_OK;
}

/* Adds up the records that wait: a run. */
static mcv_result add_waiting(mcv_gather *g, mcv_error *error) {
    size_t count = 0;
    if (g->waiting == 0) return MCV_OK;
    if (mcv_gather_bytes(g) + g->waiting * item_bytes(g) > g->most_bytes)
        MCV_TRY(mcv_runs_spill(&g->runs, error));
    mcv_wide *items = malloc(g->waiting * item_bytes(g));
    if (!items) return mcv_fail(error, MCV_FAILED, "no memory for the sums of a matrix");
    const uint32_t element_bits = sort_waiting(g);
    const mcv_waiting *records = g->order[0];
    mcv_result result = MCV_OK;
    for (size_t i = 0, end; i < g->waiting && result == MCV_OK; i = end) {
        end = i + 1;
        while (end < g->waiting && records[end].key == records[i].key) ++end;
        result = add_entry(g, records + i, end - i, element_bits, items, &count, error);
    }
    g->waiting = 0;
    if (result != MCV_OK) {
        free(items);
        return result;
    }
    mcv_wide *fitting = realloc(items, (count + 1) * item_bytes(g));
    MCV_TRY(mcv_runs_add(&g->runs, fitting ? fitting : items, count, error));
    if (!mcv_runs_are_many(&g->runs)) return MCV_OK;
    const bool room = mcv_gather_bytes(g) + mcv_runs_bytes(&g->runs) <= g->most_bytes;
    return (room ? mcv_runs_merge : mcv_runs_spill)(&g->runs, error);
}

/* --- records --- */

/* A shadow ray has reserved a record before its light was known. */
static bool brings_nothing(const mcv_gather *g, const uint32_t *record) {
    uint32_t bits = 0;
    for (uint32_t c = 0; c < g->channels; ++c) bits |= record[2 + c];
    return bits << 1 == 0;
}

mcv_result mcv_gather_add(void *user, const uint32_t *records, size_t count, mcv_error *error) {
    mcv_gather *g = user;
    const size_t words = MCV_RECORD_WORDS(g->channels);
    for (const uint32_t *r = records, *end = records + count * words; r < end; r += words) {
        if (brings_nothing(g, r)) continue;
        if (g->waiting == g->room) MCV_TRY(add_waiting(g, error));
        const uint32_t pixel = r[0] / g->replicates, element = g->columns ? g->columns[r[1]] : r[1];
        g->order[0][g->waiting] = (mcv_waiting){MCV_ENTRY_KEY(pixel, element), (uint32_t)g->waiting,
                                                r[0] - pixel * g->replicates};
        memcpy(g->values + g->waiting++ * g->channels, r + 2, g->channels * sizeof *g->values);
    }
    return MCV_OK;
}

size_t mcv_gather_bytes(const mcv_gather *gather) {
    return (gather->order[0] ? gather->room * waiting_bytes(gather) : 0) +
           mcv_runs_bytes(&gather->runs);
}

static void free_waiting(mcv_gather *g) {
    for (int i = 0; i < 2; ++i) {
        free(g->order[i]);
        g->order[i] = NULL;
    }
    free(g->values);
    g->values = NULL;
}

mcv_result mcv_gather_sort(mcv_gather *gather, size_t beside, size_t of_entry, mcv_error *error) {
    MCV_TRY(add_waiting(gather, error));
    const size_t left = beside + gather->count * of_entry;
    free_waiting(gather);
    if (gather->runs.in_file == 0 && mcv_gather_bytes(gather) + left <= gather->most_bytes)
        return MCV_OK;
    return mcv_runs_spill(&gather->runs, error);
}

/* --- reading --- */

bool mcv_gather_largest_row(const mcv_gather *gather, size_t rows, mcv_wide *largest) {
    const mcv_gather *g = gather;
    const size_t words = 1 + (size_t)g->channels;
    if (g->runs.in_file || mcv_gather_bytes(g) + rows * sizeof *largest > g->most_bytes)
        return false;
    mcv_wide *sums = calloc(rows + 1, sizeof *sums);
    if (!sums) return false;
    for (size_t i = 0; i < g->runs.count; ++i) {
        const mcv_run *run = g->runs.runs + i;
        for (const mcv_wide *item = run->items; item < run->items + run->end * words; item += words)
            for (uint32_t c = 0; c < g->channels; ++c)
                sums[(size_t)(item[0] >> 64) * g->channels + c] += item[1 + c];
    }
    *largest = 0;
    for (size_t row = 0; row < rows; ++row)
        if (sums[row] > *largest) *largest = sums[row];
    free(sums);
    return true;
}

/* What is read next. */
static mcv_result look_ahead(mcv_gather *g, mcv_error *error) {
    const mcv_wide *sums;
    MCV_TRY(mcv_runs_next(&g->runs, &g->next, &sums, error));
    if (!sums) g->next = -1;
    for (uint32_t c = 0; c < g->channels && sums; ++c) g->next_sums[c] = sums[c];
    return MCV_OK;
}

mcv_result mcv_gather_rewind(mcv_gather *gather, mcv_error *error) {
    MCV_TRY(mcv_runs_rewind(&gather->runs, gather->most_bytes / MEMORY_SHARE, error));
    return look_ahead(gather, error);
}

mcv_result mcv_gather_next(mcv_gather *gather, mcv_gather_entry *entry, bool *more,
                           mcv_error *error) {
    mcv_gather *g = gather;
    const mcv_wide of_entry = g->next >> 32;
    *more = g->next >= 0;
    if (!*more) return MCV_OK;
    *entry = (mcv_gather_entry){(uint32_t)(g->next >> 64), (uint32_t)(g->next >> 32), g->sums};
    memset(g->sums, 0, (size_t)g->replicates * g->channels * sizeof *g->sums);
    do {
        mcv_wide *of_replicate = g->sums + (uint32_t)g->next * g->channels;
        for (uint32_t c = 0; c < g->channels; ++c) of_replicate[c] = g->next_sums[c];
        MCV_TRY(look_ahead(g, error));
    } while (g->next >= 0 && g->next >> 32 == of_entry);
    return MCV_OK;
}

void mcv_gather_free(mcv_gather *gather) {
    free_waiting(gather);
    free(gather->sums);
    gather->sums = NULL;
    mcv_runs_free(&gather->runs);
}
