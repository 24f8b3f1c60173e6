/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the rows of a table have one noise: those of a sweep with common random numbers. */
#ifndef MCVISI_HOST_POD_COMMON_NOISE_H
#define MCVISI_HOST_POD_COMMON_NOISE_H

#include <stdbool.h>

/* By the experiment F.json beside the table F.csv; false where there is none. Exposures that a
 * program looks at have noise of their own. */
bool mcv_pod_common_noise(const char *table, const char *value_name);

#endif
