/* SPDX-License-Identifier: Apache-2.0 */
/* PoCL keeps compiled kernels in files, and ends or crashes the process when one is damaged, after
 * a full disk or a loss of power. Such files are found before PoCL sees them. */
#ifndef MCVISI_HOST_CL_POCL_CACHE_H
#define MCVISI_HOST_CL_POCL_CACHE_H

#include "core/error.h"

/* An error where PoCL would end the process at once: POCL_CACHE_DIR is set and empty. */
mcv_result mcv_pocl_check(mcv_error *error);

/* Deletes damaged files of PoCL's cache, which PoCL then compiles again. */
void mcv_pocl_mend(void);

/* MCV_DEVICE, with `what` and the reason, where PoCL cannot write its files: it then finds no
 * device, or builds no program. Writes a file there, and removes it. */
mcv_result mcv_pocl_writes(const char *what, mcv_error *error);

#endif
