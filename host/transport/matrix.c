/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/matrix.h"

#include <stdlib.h>
#include <string.h>

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
