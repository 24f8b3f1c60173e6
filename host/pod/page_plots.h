/* SPDX-License-Identifier: Apache-2.0 */
/* The plots of a study's page (pod/page.h). */
#ifndef MCVISI_HOST_POD_PAGE_PLOTS_H
#define MCVISI_HOST_POD_PAGE_PLOTS_H

#include "pod/page.h"

/* The probability over the size: curve, band, hits and misses, and a90 with its bound. */
void mcv_pod_put_curve(FILE *out, const mcv_pod_study *study, const char *size_name);

/* Signals over the size, with the line and the threshold. */
void mcv_pod_put_signals(FILE *out, const mcv_pod_study *study, const char *size_name,
                         const char *signal_name);

#endif
