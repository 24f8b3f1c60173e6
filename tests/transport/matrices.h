/* SPDX-License-Identifier: Apache-2.0 */
/* Two light transport matrices that must be the same. */
#ifndef MCVISI_TESTS_TRANSPORT_MATRICES_H
#define MCVISI_TESTS_TRANSPORT_MATRICES_H

#include "test.h"

#include "transport/matrix.h"

#include <string.h>

static inline void expect_equal(const char *what, const mcv_matrix *a, const mcv_matrix *b) {
    if (!a->row_begins || !b->row_begins) {
        fail_msg("%s: there is no matrix", what);
        return;
    }
    const uint64_t count = a->row_begins[a->row_count];
    if (a->row_count != b->row_count || b->row_begins[b->row_count] != count ||
        memcmp(a->row_begins, b->row_begins, (a->row_count + 1) * sizeof *a->row_begins) != 0 ||
        memcmp(a->columns, b->columns, count * sizeof *a->columns) != 0 ||
        memcmp(a->values, b->values, count * sizeof *a->values) != 0 ||
        memcmp(a->replicates_of, b->replicates_of,
               count * a->replicates * sizeof *a->replicates_of) != 0)
        fail_msg("%s: the matrices differ", what);
}

#endif
