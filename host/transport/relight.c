/* SPDX-License-Identifier: Apache-2.0 */
/* The image of a pattern: the product with a light transport matrix. */
#include "transport/matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/parallel.h"

enum { ROWS_AT_ONCE = 1 << 12 };

typedef struct product {
    const mcv_matrix *matrix;
    const float *pattern; /* [column][channel]: of the dropped column, too */
    mcv_image *mean, *deviation;
} product;

/* The sums of a row over its entries, of the means and of each replicate. */
static inline void add_entries(const product *p, size_t row, uint32_t replicates, double *sum,
                               double *by_replicate) {
    const mcv_matrix *m = p->matrix;
    const uint32_t channel = (uint32_t)(row % m->channels);
    for (uint64_t i = m->row_begins[row]; i < m->row_begins[row + 1]; ++i) {
        const double shown = p->pattern[(size_t)m->columns[i] * m->channels + channel];
        const float *of = m->replicates_of + i * replicates;
        *sum += m->values[i] * shown;
        for (uint32_t r = 0; r < replicates; ++r) by_replicate[r] += shown * (double)of[r];
    }
}

static void light_row(const product *p, size_t row) {
    enum { USUAL = 4 };
    const mcv_matrix *m = p->matrix;
    const uint32_t replicates = m->replicates;
    const size_t to = row % m->channels * (size_t)m->width * m->height + row / m->channels;
    double sum = 0, by_replicate[MCV_MAX_REPLICATES];
    if (replicates == USUAL) { /* their number is known to the compiler: in registers */
        double few[USUAL] = {0};
        add_entries(p, row, USUAL, &sum, few);
        memcpy(by_replicate, few, sizeof few);
    } else {
        memset(by_replicate, 0, replicates * sizeof *by_replicate);
        add_entries(p, row, replicates, &sum, by_replicate);
    }
    p->mean->pixels[to] = (float)sum;
    p->deviation->pixels[to] =
        (float)sqrt(mcv_estimate_replicates(by_replicate, replicates).variance);
}

static void light_rows(void *user, size_t i) {
    const product *p = user;
    const size_t first = i * ROWS_AT_ONCE, rows = p->matrix->row_count;
    const size_t last = first + ROWS_AT_ONCE < rows ? first + ROWS_AT_ONCE : rows;
    for (size_t row = first; row < last; ++row) light_row(p, row);
}

/* The pattern with the value of the dropped column: its mean over all elements. */
static float *with_mean(const mcv_matrix *m, const float *pattern) {
    float *all = malloc((size_t)m->column_count * m->channels * sizeof *all);
    for (uint32_t c = 0; all && c < m->channels; ++c) {
        double sum = 0;
        for (size_t e = 0; e < m->element_count; ++e) {
            all[e * m->channels + c] = pattern[e * m->channels + c];
            sum += (double)pattern[e * m->channels + c];
        }
        if (m->column_count > m->element_count)
            all[(size_t)m->element_count * m->channels + c] = (float)(sum / m->element_count);
    }
    return all;
}

mcv_result mcv_matrix_relight(const mcv_matrix *matrix, const float *pattern, mcv_image *mean,
                              mcv_image *deviation, mcv_error *error) {
    *mean = *deviation = (mcv_image){0};
    float *shown = with_mean(matrix, pattern);
    mcv_result result = shown ? MCV_OK : mcv_fail(error, MCV_FAILED, "no memory for a pattern");
    if (result == MCV_OK)
        result = mcv_image_new(mean, matrix->width, matrix->height, matrix->channels, error);
    if (result == MCV_OK)
        result = mcv_image_new(deviation, matrix->width, matrix->height, matrix->channels, error);
    if (result == MCV_OK) {
        product p = {matrix, shown, mean, deviation};
        mcv_in_parallel((matrix->row_count + ROWS_AT_ONCE - 1) / ROWS_AT_ONCE, light_rows, &p);
    } else {
        mcv_image_free(mean);
        mcv_image_free(deviation);
    }
    free(shown);
    return result;
}
