/* SPDX-License-Identifier: Apache-2.0 */
/* Light transport matrices from what was gathered, row by row. */
#include "transport/matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"

enum { DOUBLE_BITS = 53 };

/* A matrix on its way. */
typedef struct maker {
    mcv_gather *gather;
    mcv_matrix *m;
    double keep;
    double share;         /* of a sum over all replicates in the mean: 1 / (samples replicates) */
    double to_whole;      /* of a mean of sums in units of the matrix values */
    double unit;          /* of matrix values, a power of two */
    uint64_t all;         /* entries of the matrix without thinning, or a few more */
    uint64_t capacity;    /* of the matrix, entries */
    uint32_t *elements;   /* of the pixel's entries */
    mcv_wide *sums;       /* [entry][replicate][channel] */
    size_t count, room;   /* entries of the pixel, and those that fit */
    struct ranked *order; /* of a row's entries; room for all */
    bool *kept;
} maker;

static mcv_result no_memory(const mcv_matrix *m, mcv_error *error) {
    return mcv_fail(error, MCV_FAILED, "no memory for a matrix of %zu rows and %u columns",
                    m->row_count, m->column_count);
}

/* Most sums are of one value, a float: a whole number of large units, which a double holds. The
 * compiler's own conversion takes several times as long. */
static double double_of(mcv_wide sum) {
    enum { UNITS = 38 };
    const mcv_wide whole = sum >> UNITS;
    return whole << UNITS == sum && whole == (int64_t)whole ? (double)(int64_t)whole * 0x1p38
                                                            : (double)sum;
}

static mcv_wide sum_of(const mcv_gather *g, const mcv_wide *sums, uint32_t channel) {
    mcv_wide sum = 0;
    for (uint32_t r = 0; r < g->replicates; ++r) sum += sums[r * g->channels + channel];
    return sum;
}

/* The largest sum of a row, and how many entries there are, or a few more. */
static mcv_result find_largest(maker *k, mcv_wide *largest, mcv_error *error) {
    const mcv_gather *g = k->gather;
    mcv_wide of_row[3] = {0};
    mcv_gather_entry entry;
    uint32_t pixel = 0;
    bool more = true;
    k->all = (uint64_t)g->count * g->channels;
    if (mcv_gather_largest_row(g, k->m->row_count, largest)) return MCV_OK;
    k->all = 0;
    MCV_TRY(mcv_gather_rewind(k->gather, error));
    for (;;) {
        MCV_TRY(mcv_gather_next(k->gather, &entry, &more, error));
        if (!more) return MCV_OK;
        k->all += g->channels;
        if (entry.pixel != pixel) memset(of_row, 0, sizeof of_row);
        pixel = entry.pixel;
        for (uint32_t c = 0; c < g->channels; ++c) {
            of_row[c] += sum_of(g, entry.sums, c);
            if (of_row[c] > *largest) *largest = of_row[c];
        }
    }
}

/* The unit with which the largest row sum still is a double, whatever the order; one bit is for the
 * rounding of the entries. */
static mcv_result choose_unit(maker *k, mcv_error *error) {
    mcv_wide largest = 0;
    int exponent = 0;
    MCV_TRY(find_largest(k, &largest, error));
    frexp((double)largest * k->share, &exponent);
    k->unit = ldexp(1, exponent + k->gather->exponent + 1 - DOUBLE_BITS);
    k->to_whole = ldexp(1, DOUBLE_BITS - 1 - exponent);
    return MCV_OK;
}

/* The value of an entry in units, a whole number. */
static double whole_of(const maker *k, const mcv_wide *sums, uint32_t channel) {
    return rint(double_of(sum_of(k->gather, sums, channel)) * k->share * k->to_whole);
}

/* --- thinning --- */

/* An entry of a row by its value. */
typedef struct ranked {
    double value;
    uint64_t entry; /* from the row's first one */
} ranked;

static int by_value(const void *a, const void *b) {
    const ranked *x = a, *y = b;
    if (x->value != y->value) return x->value < y->value ? 1 : -1;
    return (x->entry > y->entry) - (x->entry < y->entry);
}

/* Marks the strongest entries of a row that make up its share `keep`. */
static void choose_kept(maker *k, uint64_t first, uint64_t count) {
    double all = 0, so_far = 0;
    for (uint64_t i = 0; i < count; ++i) {
        k->order[i] = (ranked){k->m->values[first + i], i};
        all += k->m->values[first + i];
    }
    qsort(k->order, count, sizeof *k->order, by_value);
    for (uint64_t i = 0; i < count; ++i) {
        k->kept[k->order[i].entry] = so_far < k->keep * all;
        so_far += k->order[i].value;
    }
}

/* Moves an entry to a place before it, or to its own. */
static void move_entry(mcv_matrix *m, uint64_t from, uint64_t to) {
    m->columns[to] = m->columns[from];
    m->values[to] = m->values[from];
    memmove(m->replicates_of + to * m->replicates, m->replicates_of + from * m->replicates,
            m->replicates * sizeof *m->replicates_of);
}

/* Keeps the strongest entries of the last row, from `first` to `end`; the others become its last
 * one. Returns where the row ends then. */
static uint64_t thin_row(maker *k, uint64_t first, uint64_t end) {
    mcv_matrix *m = k->m;
    double rest = 0, rest_of[MCV_MAX_REPLICATES] = {0};
    bool dropped = false;
    uint64_t next = first;
    choose_kept(k, first, end - first);
    for (uint64_t i = first; i < end; ++i) {
        if (k->kept[i - first]) {
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

/* --- rows --- */

/* Bytes of a matrix of so many entries. */
static size_t bytes_of(const mcv_matrix *m, uint64_t count) {
    return count *
               (sizeof *m->columns + sizeof *m->values + m->replicates * sizeof *m->replicates_of) +
           m->row_count * sizeof *m->row_begins;
}

/* Room for so many entries. While arrays grow, the old ones may be there, too. */
static mcv_result reserve(maker *k, uint64_t count, mcv_error *error) {
    mcv_matrix *m = k->m;
    const bool first = !m->columns;
    const uint64_t capacity = first ? count : count + count / 2;
    if (!first && count <= k->capacity) return MCV_OK;
    const size_t bytes = bytes_of(m, capacity) + (first ? 0 : bytes_of(m, k->capacity));
    if (mcv_gather_bytes(k->gather) + bytes > k->gather->most_bytes)
        return mcv_fail(error, MCV_BAD_INPUT,
                        "the matrix has %llu entries or more, for which --memory has no room: give "
                        "more, fewer pixels, a lower --keep, or --elements lamps",
                        (unsigned long long)count);
    uint32_t *columns = realloc(m->columns, (capacity + 1) * sizeof *columns);
    if (columns) m->columns = columns;
    double *values = realloc(m->values, (capacity + 1) * sizeof *values);
    if (values) m->values = values;
    float *replicates =
        realloc(m->replicates_of, (capacity * m->replicates + 1) * sizeof *replicates);
    if (replicates) m->replicates_of = replicates;
    if (!columns || !values || !replicates) return no_memory(m, error);
    k->capacity = capacity;
    return MCV_OK;
}

/* The row of a channel of the pixel whose entries are there, behind the rows before it. */
static mcv_result append_row(maker *k, size_t row, mcv_error *error) {
    mcv_matrix *m = k->m;
    const mcv_gather *g = k->gather;
    const uint32_t channel = (uint32_t)(row % m->channels);
    const double scale = ldexp(1, g->exponent);
    const uint64_t first = m->row_begins[row];
    uint64_t end = first;
    MCV_TRY(reserve(k, first + k->count, error));
    for (size_t i = 0; i < k->count; ++i) {
        const mcv_wide *sums = k->sums + i * m->replicates * m->channels;
        const double whole = whole_of(k, sums, channel);
        if (whole == 0) continue;
        m->columns[end] = k->elements[i];
        m->values[end] = whole * k->unit;
        for (uint32_t r = 0; r < m->replicates; ++r) {
            /* Mostly zero where each sample finds an element of its own. */
            const mcv_wide sum = sums[r * m->channels + channel];
            m->replicates_of[end * m->replicates + r] =
                sum == 0 ? 0 : (float)(double_of(sum) / (double)m->samples * scale);
        }
        ++end;
    }
    m->row_begins[row + 1] = k->keep < 1 ? thin_row(k, first, end) : end;
    return MCV_OK;
}

/* Adds an entry to the pixel's. */
static mcv_result collect(maker *k, const mcv_gather_entry *entry, mcv_error *error) {
    const size_t cells = (size_t)k->m->replicates * k->m->channels;
    if (k->count == k->room) {
        const size_t room = 2 * k->room + 64;
        uint32_t *elements = realloc(k->elements, room * sizeof *elements);
        if (elements) k->elements = elements;
        mcv_wide *sums = realloc(k->sums, room * cells * sizeof *sums);
        if (sums) k->sums = sums;
        ranked *order = realloc(k->order, room * sizeof *order);
        if (order) k->order = order;
        bool *kept = realloc(k->kept, room * sizeof *kept);
        if (kept) k->kept = kept;
        if (!elements || !sums || !order || !kept) return no_memory(k->m, error);
        k->room = room;
    }
    k->elements[k->count] = entry->element;
    memcpy(k->sums + k->count * cells, entry->sums, cells * sizeof *k->sums);
    ++k->count;
    return MCV_OK;
}

/* The rows of all pixels before this one that are not there yet. */
static mcv_result append_rows(maker *k, size_t *row, size_t end, mcv_error *error) {
    while (*row < end) {
        MCV_TRY(append_row(k, *row, error));
        if (++*row % k->m->channels == 0) k->count = 0;
    }
    return MCV_OK;
}

static mcv_result fill_matrix(maker *k, mcv_error *error) {
    mcv_gather_entry entry;
    size_t row = 0;
    bool more = true;
    const size_t rows = bytes_of(k->m, 0);
    MCV_TRY(mcv_gather_sort(k->gather, rows, bytes_of(k->m, k->m->channels) - rows, error));
    MCV_TRY(choose_unit(k, error));
    MCV_TRY(mcv_gather_rewind(k->gather, error));
    MCV_TRY(reserve(k, k->keep < 1 ? 0 : k->all, error));
    for (;;) {
        MCV_TRY(mcv_gather_next(k->gather, &entry, &more, error));
        MCV_TRY(append_rows(k, &row, more ? (size_t)entry.pixel * k->m->channels : k->m->row_count,
                            error));
        if (!more) return MCV_OK;
        MCV_TRY(collect(k, &entry, error));
    }
}

mcv_result mcv_matrix_make(mcv_gather *gather, uint32_t width, uint32_t height, uint64_t samples,
                           uint32_t elements, double keep, mcv_matrix *matrix, mcv_error *error) {
    *matrix = (mcv_matrix){.width = width,
                           .height = height,
                           .channels = gather->channels,
                           .replicates = gather->replicates,
                           .samples = samples,
                           .kept = keep,
                           .element_count = elements,
                           .row_count = (size_t)width * height * gather->channels,
                           .column_count = elements + (keep < 1)};
    maker k = {.gather = gather,
               .m = matrix,
               .keep = keep,
               .share = 1 / ((double)samples * gather->replicates)};
    matrix->row_begins = calloc(matrix->row_count + 1, sizeof *matrix->row_begins);
    mcv_result result = matrix->row_begins ? MCV_OK : no_memory(matrix, error);
    if (result == MCV_OK) result = fill_matrix(&k, error);
    free(k.elements);
    free(k.sums);
    free(k.order);
    free(k.kept);
    if (result != MCV_OK) mcv_matrix_free(matrix);
    return result;
}
