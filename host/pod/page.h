/* SPDX-License-Identifier: Apache-2.0 */
/* The page of a study: the answer in a sentence, the curve with its band, what it rests on, and
 * what it does not hold. One HTML file that needs nothing else. */
#ifndef MCVISI_HOST_POD_PAGE_H
#define MCVISI_HOST_POD_PAGE_H

#include "pod/study.h"

/* What the page tells beside the study; each may be NULL. */
typedef struct mcv_pod_page {
    const char *table;                  /* the file of the rows */
    const char *size_name, *value_name; /* of the columns; NULL: size, signal or hit */
    const char *title, *note;           /* the heading, and a sentence below it */
    const char *pictures;               /* HTML that stands behind the curves (pod/pictures.h) */
} mcv_pod_page;

/* Writes it; the file appears whole or not at all. The date is today's, or that of
 * SOURCE_DATE_EPOCH. */
mcv_result mcv_pod_page_write(const char *path, const mcv_pod_study *study,
                              const mcv_pod_page *page, mcv_error *error);

#endif
