/* SPDX-License-Identifier: Apache-2.0 */
/* Studies of the probability of detection by the options of `mcvisi pod`, and what is told of
 * them. */
#ifndef MCVISI_HOST_VERBS_POD_H
#define MCVISI_HOST_VERBS_POD_H

#include "options/command.h"
#include "pod/study.h"
#include "verbs/report.h"

/* What the options ask for. `hits`: values are these, whatever the options name. MCV_USAGE for
 * texts that are no numbers. */
mcv_result mcv_pod_asked_of(const mcv_command *command, bool hits, mcv_pod_asked *asked,
                            mcv_error *error);

/* The columns that the options name, and whether the values are hits. MCV_USAGE where not one of
 * --signal and --hit is given. */
mcv_result mcv_pod_names_of(const mcv_command *command, mcv_column_names *names, bool *hits,
                            mcv_error *error);

/* The study as a report. MCV_FAILED without memory. */
mcv_result mcv_pod_report(const mcv_pod_study *study, mcv_report *report, mcv_error *error);

#endif
