/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The results of an experiment: one row of numbers for each set, in memory and in a CSV file that
 * grows row by row. Beside F.csv stand F.json, the experiment (experiment/sidecar.h), and F.html,
 * the page (experiment/page.h).
 *
 * A row holds the parameters of the plan; value and standard uncertainty of each metric; and what
 * mcv_row_fixed tells. NaN: there is no such number.
 */
#ifndef MCVISI_HOST_EXPERIMENT_TABLE_H
#define MCVISI_HOST_EXPERIMENT_TABLE_H

#include "experiment/measure.h"
#include "experiment/plan.h"

#include <limits.h>

/* Samples per pixel; relative error of the image; seconds of the set; number of the set. */
enum { MCV_ROW_SAMPLES, MCV_ROW_ERROR, MCV_ROW_SECONDS, MCV_ROW_SET, MCV_ROW_FIXED };
/* With this begins the message of a set that is tried again: its failure is not of its own. */
#define MCV_ROW_RETRY "device trouble: "
enum { MCV_ROW_MOST = MCV_DESIGN_PARAMETERS + 2 * MCV_METRICS + MCV_ROW_FIXED };

typedef struct mcv_table {
    const mcv_plan *plan; /* of the rows */
    const mcv_measurement *measurement;
    char path[PATH_MAX], sidecar[PATH_MAX], page[PATH_MAX];
    size_t columns;  /* numbers of a row */
    double *rows;    /* [row][columns], in the order of the file */
    char **messages; /* why each row failed, or NULL */
    size_t row_count;
    int descriptor; /* of the file, -1: not open */
    bool locked;
} mcv_table;

/*
 * Names the files by `path`, which must end in .csv (NULL: there are none), and makes room for a
 * row of each set of the plan. Plan and measurement must outlive the table. After failure, too, it
 * is freed by mcv_table_free.
 */
mcv_result mcv_table_plan(mcv_table *table, const char *path, const mcv_plan *plan,
                          const mcv_measurement *measurement, mcv_error *error);

/*
 * Opens the file, which is made where there is none, and locks it until the table is freed.
 * *exists: it has rows or a header. MCV_BAD_INPUT where another process writes it: the sentence
 * tells which, where the system does. One that was made and has got no header is removed again when
 * the table is freed.
 */
mcv_result mcv_table_lock(mcv_table *table, bool *exists, mcv_error *error);

/* Empties the file that is locked, and writes the header. */
mcv_result mcv_table_begin(mcv_table *table, mcv_error *error);

/* Reads the rows of the file that is locked. What follows the last whole one is removed, and so are
 * the rows of sets that failed for want of a device (MCV_ROW_RETRY). done[set] is set for each.
 * MCV_BAD_INPUT for a line that begins with no set of the plan; the file then stays as it is. */
mcv_result mcv_table_resume(mcv_table *table, bool *done, mcv_error *error);

/* Appends a row to the file, in one write, and to memory. message: why the set failed, or NULL. */
mcv_result mcv_table_append(mcv_table *table, const double *row, const char *message,
                            mcv_error *error);

/* The column of a metric's value; its uncertainty is the next one. The column of one of
 * MCV_ROW_…. */
size_t mcv_row_metric(const mcv_table *table, size_t metric);
size_t mcv_row_fixed(const mcv_table *table, int which);

/* The number of rows that have failed. */
size_t mcv_table_failed(const mcv_table *table);

/* The rows in which a metric is smallest and largest, the first of several; NULL where no row has
 * it. */
void mcv_table_extremes(const mcv_table *table, size_t metric, const double *extremes[2]);

void mcv_table_free(mcv_table *table);

#endif
