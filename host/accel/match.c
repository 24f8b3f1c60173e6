/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which triangles of two scenes are the same, to the bit. Triangles of which only a part was
 * replaced mostly follow each other in both; a table finds the others.
 */
#include "accel/update.h"

#include <stdlib.h>
#include <string.h>

enum {
    MOST_SKIPPED =
        256,          /* so far ahead do triangles follow each other again, or the table is used */
    MOST_PROBES = 64, /* so that thousands of equal triangles cost no more than others */
};

typedef struct matching {
    const mcv_bvh_base *base;
    const float *positions;
    const uint32_t *indices;
    uint32_t triangle_count;
    mcv_matches *matches;
    uint32_t *table; /* new triangles by their corners: number + 1; 0: free */
    uint32_t mask;
} matching;

static const float *base_corners(const matching *m, uint32_t triangle) {
    return m->base->corners + 9 * (size_t)triangle;
}

static void corners_of(const matching *m, uint32_t triangle, float corners[9]) {
    for (size_t k = 0; k < 3; ++k)
        memcpy(corners + 3 * k, m->positions + 3 * (size_t)m->indices[3 * (size_t)triangle + k],
               3 * sizeof *corners);
}

static bool is_same(const matching *m, uint32_t of_base, uint32_t triangle) {
    float corners[9];
    corners_of(m, triangle, corners);
    return memcmp(base_corners(m, of_base), corners, sizeof corners) == 0;
}

static void pair(matching *m, uint32_t of_base, uint32_t triangle) {
    m->matches->numbers[of_base] = triangle;
    m->matches->found[triangle] = true;
    ++m->matches->found_count;
}

/* --- triangles that follow each other --- */

/* After two triangles that differ: skips those that only one scene has. */
static bool skip(const matching *m, uint32_t *of_base, uint32_t *triangle) {
    for (uint32_t k = 1; k <= MOST_SKIPPED; ++k) {
        const bool base_goes_on = m->base->triangle_count - *of_base > k,
                   goes_on = m->triangle_count - *triangle > k;
        if (base_goes_on && is_same(m, *of_base + k, *triangle)) {
            *of_base += k;
            return true;
        }
        if (goes_on && is_same(m, *of_base, *triangle + k)) {
            *triangle += k;
            return true;
        }
    }
    return false;
}

static void match_in_order(matching *m) {
    for (uint32_t b = 0, t = 0; b < m->base->triangle_count && t < m->triangle_count; ++b, ++t) {
        if (!is_same(m, b, t) && !skip(m, &b, &t)) return;
        pair(m, b, t);
    }
}

/* --- the others --- */

static uint32_t slot_of(const matching *m, const float corners[9]) {
    uint32_t words[9];
    uint64_t hash = 0;
    memcpy(words, corners, sizeof words);
    for (int i = 0; i < 9; ++i) {
        hash = (hash ^ words[i]) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
    }
    return (uint32_t)hash & m->mask;
}

static void fill_table(matching *m) {
    for (uint32_t t = 0; t < m->triangle_count; ++t) {
        float corners[9];
        if (m->matches->found[t]) continue;
        corners_of(m, t, corners);
        uint32_t slot = slot_of(m, corners), probes = 0;
        while (m->table[slot] && ++probes < MOST_PROBES) slot = (slot + 1) & m->mask;
        if (!m->table[slot]) m->table[slot] = t + 1;
    }
}

static void look_up(matching *m, uint32_t of_base) {
    uint32_t slot = slot_of(m, base_corners(m, of_base));
    for (uint32_t probes = 0; probes < MOST_PROBES && m->table[slot]; ++probes) {
        const uint32_t t = m->table[slot] - 1;
        if (!m->matches->found[t] && is_same(m, of_base, t)) {
            pair(m, of_base, t);
            return;
        }
        slot = (slot + 1) & m->mask;
    }
}

static bool match_others(matching *m) {
    uint32_t size = 16;
    while (size < 2 * (uint64_t)(m->triangle_count - m->matches->found_count)) size *= 2;
    m->mask = size - 1;
    m->table = calloc(size, sizeof *m->table);
    if (!m->table) return false;
    fill_table(m);
    for (uint32_t b = 0; b < m->base->triangle_count; ++b)
        if (m->matches->numbers[b] == MCV_NONE) look_up(m, b);
    free(m->table);
    return true;
}

bool mcv_match_triangles(const mcv_bvh_base *base, const float *positions, const uint32_t *indices,
                         uint32_t triangle_count, mcv_matches *matches) {
    *matches = (mcv_matches){malloc((size_t)base->triangle_count * sizeof *matches->numbers + 1),
                             calloc((size_t)triangle_count + 1, sizeof *matches->found), 0};
    matching m = {base, positions, indices, triangle_count, matches, NULL, 0};
    if (!matches->numbers || !matches->found) return false;
    memset(matches->numbers, 0xff, base->triangle_count * sizeof *matches->numbers);
    match_in_order(&m);
    return match_others(&m);
}

void mcv_matches_free(mcv_matches *matches) {
    free(matches->numbers);
    free(matches->found);
    *matches = (mcv_matches){NULL, NULL, 0};
}
