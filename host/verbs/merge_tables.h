/* SPDX-License-Identifier: Apache-2.0 */
/* Joining the tables of parts of a sweep (`sweep --range I/N`). */
#ifndef MCVISI_HOST_VERBS_MERGE_TABLES_H
#define MCVISI_HOST_VERBS_MERGE_TABLES_H

#include "core/basics.h"
#include "verbs/report.h"

/*
 * Writes the rows of all tables, by the numbers of their sets, to `output`, and the experiment
 * beside it; `sweep --resume` then renders what is missing and writes the page. MCV_BAD_INPUT for
 * tables of different experiments (what differs is named), a set that two of them have, and an
 * output that exists (without `force`). Parts that are missing are told as a warning.
 */
mcv_result mcv_tables_join(mcv_texts paths, const char *output, bool force, mcv_report *report,
                           mcv_error *error);

#endif
