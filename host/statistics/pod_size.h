/* SPDX-License-Identifier: Apache-2.0 */
/* The sizes of a fitted POD (statistics/pod.h). */
#ifndef MCVISI_HOST_STATISTICS_POD_SIZE_H
#define MCVISI_HOST_STATISTICS_POD_SIZE_H

#include "statistics/pod.h"

/* The size that is found with this probability, 0 < p < 1, and its bounds. */
mcv_pod_size mcv_pod_find_size(const mcv_pod *pod, double probability);

#endif
