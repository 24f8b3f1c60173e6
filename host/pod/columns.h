/* SPDX-License-Identifier: Apache-2.0 */
/* Columns of a CSV table by their names, such as `mcvisi sweep` writes: comma between fields,
 * "quotes" about those that hold commas, a header in the first line. */
#ifndef MCVISI_HOST_POD_COLUMNS_H
#define MCVISI_HOST_POD_COLUMNS_H

#include "core/error.h"

#include <stddef.h>
#include <stdint.h>

/* NULL for a column that is not wanted. */
typedef struct mcv_columns {
    double *sizes, *values; /* NaN where the field is empty */
    uint64_t *defects;      /* hashes of the fields */
    size_t count;
} mcv_columns;

/* The names of the columns; defect may be NULL. */
typedef struct mcv_column_names {
    const char *size, *value, *defect;
} mcv_column_names;

/* Reads the columns. MCV_BAD_INPUT names the file and the line: a column that is missing, or a
 * field that is no number. To be freed also after a failure. */
mcv_result mcv_columns_read(const char *path, const mcv_column_names *names, mcv_columns *columns,
                            mcv_error *error);
void mcv_columns_free(mcv_columns *columns);

#endif
