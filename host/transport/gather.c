/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/gather.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "mcvisi/tables.h"

enum { FIRST_CAPACITY = 1 << 12, UNIT_BITS = 72, MOST_BITS = 120 };

static size_t cells_of(const mcv_gather *g) { return (size_t)g->replicates * g->channels; }

/* Bytes of tables for so many entries. */
static double bytes_for(const mcv_gather *g, size_t capacity) {
    return (double)capacity *
           (double)(2 * sizeof *g->slots + sizeof *g->keys + cells_of(g) * sizeof *g->sums);
}

/* Bytes of the matrix that is made from so many entries while they are still there: place, column,
 * value and replicates of each channel (transport/matrix.c). */
static double bytes_of_matrix(const mcv_gather *g, size_t capacity) {
    return (double)capacity * g->channels *
           (double)(sizeof(double) + 3 * sizeof(uint32_t) + g->replicates * sizeof(float));
}

static size_t slot_for(const mcv_gather *g, const uint32_t *slots, size_t capacity,
                       mcv_gather_key key) {
    uint64_t hash = ((uint64_t)key.pixel << 32 | key.element) * 0x9e3779b97f4a7c15u;
    size_t slot = (size_t)((hash ^ hash >> 32) & (2 * capacity - 1));
    while (slots[slot] > 0) {
        const mcv_gather_key *taken = g->keys + slots[slot] - 1;
        if (taken->pixel == key.pixel && taken->element == key.element) break;
        slot = (slot + 1) & (2 * capacity - 1);
    }
    return slot;
}

/* Room for twice the entries. */
static mcv_result grow(mcv_gather *g, mcv_error *error) {
    const size_t capacity = g->capacity > 0 ? 2 * g->capacity : FIRST_CAPACITY;
    /* While the sums move, the old ones are there, too; in the end the matrix is. */
    if (bytes_for(g, capacity) + fmax(bytes_for(g, g->capacity), bytes_of_matrix(g, capacity)) >
        (double)g->most_bytes)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "the matrix has more than %zu entries, for which --memory %.3g GiB has no "
                        "room: give more, fewer pixels, or --elements lamps",
                        g->count, (double)g->most_bytes / 0x1p30);
    uint32_t *slots = calloc(2 * capacity, sizeof *slots);
    mcv_gather_key *keys = realloc(g->keys, capacity * sizeof *keys);
    if (keys) g->keys = keys;
    mcv_wide *sums = realloc(g->sums, capacity * cells_of(g) * sizeof *sums);
    if (sums) g->sums = sums;
    if (!slots || !keys || !sums || capacity > UINT32_MAX / 2) {
        free(slots);
        return mcv_fail(error, MCV_FAILED, "no memory for %zu entries of a matrix", capacity);
    }
    for (size_t i = 0; i < g->count; ++i)
        slots[slot_for(g, slots, capacity, g->keys[i])] = (uint32_t)i + 1;
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
    return grow(gather, error);
}

/* The entry of a key, a new one if need be. */
static mcv_result find_entry(mcv_gather *g, mcv_gather_key key, size_t *entry, mcv_error *error) {
    size_t slot = slot_for(g, g->slots, g->capacity, key);
    if (g->slots[slot] == 0) {
        if (g->count == g->capacity) {
            MCV_TRY(grow(g, error));
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

mcv_result mcv_gather_add(void *user, const uint32_t *records, size_t count, mcv_error *error) {
    mcv_gather *g = user;
    const size_t words = MCV_RECORD_WORDS(g->channels);
    for (const uint32_t *end = records + count * words; records < end; records += words) {
        const mcv_gather_key key = {records[0] / g->replicates, records[1]};
        size_t entry;
        MCV_TRY(find_entry(g, key, &entry, error));
        mcv_wide *sums = g->sums + entry * cells_of(g) + (records[0] % g->replicates) * g->channels;
        for (uint32_t c = 0; c < g->channels; ++c) {
            float value;
            memcpy(&value, records + 2 + c, sizeof value);
            MCV_TRY(add_value(g, sums + c, value, error));
        }
    }
    return MCV_OK;
}

void mcv_gather_free(mcv_gather *gather) {
    free(gather->slots);
    free(gather->keys);
    free(gather->sums);
    *gather = (mcv_gather){0};
}
