/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DOUBLE_BITS = 53 };

/* --- from sums --- */

/* The value of an entry in units of 2^exponent, a whole number. */
typedef struct quantum {
    int exponent; /* of matrix values */
    double share; /* of a sum over all replicates in the mean: 1 / (samples replicates) */
} quantum;

static double whole_of(const mcv_gather *g, mcv_wide sum, quantum q) {
    return rint(ldexp((double)sum * q.share, g->exponent - q.exponent));
}

static mcv_wide sum_of(const mcv_gather *g, size_t entry, uint32_t channel) {
    mcv_wide sum = 0;
    for (uint32_t r = 0; r < g->replicates; ++r)
        sum += g->sums[(entry * g->replicates + r) * g->channels + channel];
    return sum;
}

/* The unit with which the largest row sum still is a double, whatever the order; one bit is for the
 * rounding of the entries. *sums: room for the rows' sums. */
static quantum choose_quantum(const mcv_gather *g, const mcv_matrix *m, mcv_wide *sums) {
    const double share = 1 / ((double)m->samples * m->replicates);
    mcv_wide largest = 0;
    int exponent = 0;
    for (size_t i = 0; i < g->count; ++i)
        for (uint32_t c = 0; c < g->channels; ++c) {
            mcv_wide *sum = sums + (size_t)g->keys[i].pixel * g->channels + c;
            *sum += sum_of(g, i, c);
            if (*sum > largest) largest = *sum;
        }
    frexp((double)largest * share, &exponent);
    return (quantum){exponent + g->exponent + 1 - DOUBLE_BITS, share};
}

/* An entry on its way into a row. */
typedef struct placed {
    uint32_t column, entry;
} placed;

static int by_column(const void *a, const void *b) {
    const placed *x = a, *y = b;
    return (x->column > y->column) - (x->column < y->column);
}

/* Counts the entries of the rows: row_begins[row + 1] is how many row has. */
static void count_entries(const mcv_gather *g, mcv_matrix *m, quantum q) {
    for (size_t i = 0; i < g->count; ++i)
        for (uint32_t c = 0; c < g->channels; ++c)
            m->row_begins[(size_t)g->keys[i].pixel * g->channels + c + 1] +=
                whole_of(g, sum_of(g, i, c), q) != 0;
    for (size_t row = 0; row < m->row_count; ++row) m->row_begins[row + 1] += m->row_begins[row];
}

/* The values of the row's entries, which are placed and sorted. */
static void fill_row(const mcv_gather *g, mcv_matrix *m, quantum q, size_t row,
                     const placed *order) {
    const uint32_t channel = (uint32_t)(row % m->channels);
    for (uint64_t i = m->row_begins[row]; i < m->row_begins[row + 1]; ++i) {
        const size_t entry = order[i].entry;
        m->columns[i] = order[i].column;
        m->values[i] = ldexp(whole_of(g, sum_of(g, entry, channel), q), q.exponent);
        for (uint32_t r = 0; r < m->replicates; ++r)
            m->replicates_of[i * m->replicates + r] =
                (float)ldexp((double)g->sums[(entry * g->replicates + r) * g->channels + channel] /
                                 (double)m->samples,
                             g->exponent);
    }
}

static void fill_rows(const mcv_gather *g, mcv_matrix *m, quantum q, placed *order,
                      uint64_t *next) {
    memcpy(next, m->row_begins, m->row_count * sizeof *next);
    for (size_t i = 0; i < g->count; ++i)
        for (uint32_t c = 0; c < g->channels; ++c)
            if (whole_of(g, sum_of(g, i, c), q) != 0)
                order[next[(size_t)g->keys[i].pixel * g->channels + c]++] =
                    (placed){g->keys[i].element, (uint32_t)i};
    for (size_t row = 0; row < m->row_count; ++row) {
        qsort(order + m->row_begins[row], m->row_begins[row + 1] - m->row_begins[row],
              sizeof *order, by_column);
        fill_row(g, m, q, row, order);
    }
}

static mcv_result no_memory(const mcv_matrix *m, mcv_error *error) {
    return mcv_fail(error, MCV_FAILED, "no memory for a matrix of %zu rows and %u columns",
                    m->row_count, m->column_count);
}

static mcv_result allocate_entries(mcv_matrix *m, uint64_t count, mcv_error *error) {
    m->columns = malloc((count + 1) * sizeof *m->columns);
    m->values = malloc((count + 1) * sizeof *m->values);
    m->replicates_of = malloc((count * m->replicates + 1) * sizeof *m->replicates_of);
    return m->columns && m->values && m->replicates_of ? MCV_OK : no_memory(m, error);
}

static mcv_result fill_matrix(const mcv_gather *g, mcv_matrix *m, mcv_wide *sums,
                              mcv_error *error) {
    const quantum q = choose_quantum(g, m, sums);
    count_entries(g, m, q);
    const uint64_t count = m->row_begins[m->row_count];
    placed *order = malloc((count + 1) * sizeof *order);
    uint64_t *next = malloc((m->row_count + 1) * sizeof *next);
    mcv_result result = allocate_entries(m, count, error);
    if (result == MCV_OK && (!order || !next)) result = no_memory(m, error);
    if (result == MCV_OK) fill_rows(g, m, q, order, next);
    free(order);
    free(next);
    return result;
}

mcv_result mcv_matrix_make(const mcv_gather *gather, uint32_t width, uint32_t height,
                           uint64_t samples, uint32_t elements, mcv_matrix *matrix,
                           mcv_error *error) {
    *matrix = (mcv_matrix){.width = width,
                           .height = height,
                           .channels = gather->channels,
                           .replicates = gather->replicates,
                           .samples = samples,
                           .kept = 1,
                           .element_count = elements,
                           .row_count = (size_t)width * height * gather->channels,
                           .column_count = elements};
    matrix->row_begins = calloc(matrix->row_count + 1, sizeof *matrix->row_begins);
    mcv_wide *sums = calloc(matrix->row_count + 1, sizeof *sums);
    const mcv_result result = matrix->row_begins && sums ? fill_matrix(gather, matrix, sums, error)
                                                         : no_memory(matrix, error);
    free(sums);
    if (result != MCV_OK) mcv_matrix_free(matrix);
    return result;
}

/* --- thinning --- */

/* An entry of a row by its value. */
typedef struct ranked {
    double value;
    uint64_t entry;
} ranked;

static int by_value(const void *a, const void *b) {
    const ranked *x = a, *y = b;
    if (x->value != y->value) return x->value < y->value ? 1 : -1;
    return (x->entry > y->entry) - (x->entry < y->entry);
}

/* Marks the strongest entries of a row that make up its share `keep`. */
static void choose_kept(const mcv_matrix *m, size_t row, double keep, ranked *order, bool *kept) {
    const uint64_t first = m->row_begins[row], count = m->row_begins[row + 1] - first;
    double all = 0, so_far = 0;
    for (uint64_t i = 0; i < count; ++i) {
        order[i] = (ranked){m->values[first + i], first + i};
        all += m->values[first + i];
    }
    qsort(order, count, sizeof *order, by_value);
    for (uint64_t i = 0; i < count; ++i) {
        kept[order[i].entry] = so_far < keep * all;
        so_far += order[i].value;
    }
}

/* Moves an entry to a place before it, or to its own. */
static void move_entry(mcv_matrix *m, uint64_t from, uint64_t to) {
    m->columns[to] = m->columns[from];
    m->values[to] = m->values[from];
    memmove(m->replicates_of + to * m->replicates, m->replicates_of + from * m->replicates,
            m->replicates * sizeof *m->replicates_of);
}

/* Compacts a row to entries that begin at `next`; the dropped ones become its last one. Returns
 * where the row ends: it has no more entries than before. */
static uint64_t compact_row(mcv_matrix *m, size_t row, uint64_t next, const bool *kept) {
    double rest = 0, rest_of[MCV_MAX_REPLICATES] = {0};
    bool dropped = false;
    for (uint64_t i = m->row_begins[row]; i < m->row_begins[row + 1]; ++i) {
        if (kept[i]) {
            move_entry(m, i, next++);
            continue;
        }
        dropped = true;
        rest += m->values[i];
        for (uint32_t r = 0; r < m->replicates; ++r)
            rest_of[r] += (double)m->replicates_of[i * m->replicates + r];
    }
    if (!dropped) return next;
    m->columns[next] = m->element_count;
    m->values[next] = rest;
    for (uint32_t r = 0; r < m->replicates; ++r)
        m->replicates_of[next * m->replicates + r] = (float)rest_of[r];
    return next + 1;
}

mcv_result mcv_matrix_thin(mcv_matrix *matrix, double keep, mcv_error *error) {
    const uint64_t count = matrix->row_begins[matrix->row_count];
    uint64_t longest = 0, next = 0;
    if (!(keep < 1) || matrix->kept < 1) return MCV_OK;
    for (size_t row = 0; row < matrix->row_count; ++row) {
        const uint64_t length = matrix->row_begins[row + 1] - matrix->row_begins[row];
        if (length > longest) longest = length;
    }
    ranked *order = malloc((longest + 1) * sizeof *order);
    bool *kept = malloc(count + 1);
    if (!order || !kept) {
        free(order);
        free(kept);
        return no_memory(matrix, error);
    }
    for (size_t row = 0; row < matrix->row_count; ++row)
        choose_kept(matrix, row, keep, order, kept);
    for (size_t row = 0; row < matrix->row_count; ++row) {
        const uint64_t end = compact_row(matrix, row, next, kept);
        matrix->row_begins[row] = next;
        next = end;
    }
    matrix->row_begins[matrix->row_count] = next;
    matrix->kept = keep;
    matrix->column_count = matrix->element_count + 1;
    free(order);
    free(kept);
    return MCV_OK;
}

const mcv_element_group *mcv_matrix_group(const mcv_matrix *matrix, const char *emitter) {
    for (uint32_t i = 0; i < matrix->group_count; ++i)
        if (strcmp(matrix->groups[i].emitter, emitter) == 0) return matrix->groups + i;
    return NULL;
}

void mcv_matrix_free(mcv_matrix *matrix) {
    for (uint32_t i = 0; i < matrix->group_count; ++i) {
        free(matrix->groups[i].emitter);
        free(matrix->groups[i].type);
    }
    free(matrix->groups);
    free(matrix->row_begins);
    free(matrix->columns);
    free(matrix->values);
    free(matrix->replicates_of);
    free(matrix->pattern);
    json_decref(matrix->attributes);
    *matrix = (mcv_matrix){0};
}
