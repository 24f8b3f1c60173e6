/* SPDX-License-Identifier: Apache-2.0 */
#ifndef MCVISI_HOST_CORE_KERNEL_FOLDER_H
#define MCVISI_HOST_CORE_KERNEL_FOLDER_H

#include <stdbool.h>

enum { MCV_KERNEL_FOLDER = 4096 };

/* The folder in which the OpenCL driver PoCL keeps compiled kernels. False where its path is empty
 * or too long. Source: PoCL, lib/CL/pocl_cache.c. */
bool mcv_kernel_folder(char path[MCV_KERNEL_FOLDER]);

#endif
