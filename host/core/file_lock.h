/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files that one writer at a time may have, of one process or of several. The system ends a lock
 * with its process, however that ends. File systems without locks do without.
 */
#ifndef MCVISI_HOST_CORE_FILE_LOCK_H
#define MCVISI_HOST_CORE_FILE_LOCK_H

#include "core/error.h"

/*
 * Opens a file for appending, which is made where there is none, and locks it until the descriptor
 * is closed. MCV_BAD_INPUT where somebody has locked it: the sentence tells who writes the file
 * `written`, where the system does, and which option gives it another name. *descriptor is -1 after
 * failure.
 */
mcv_result mcv_file_lock(const char *path, const char *written, const char *option, int *descriptor,
                         mcv_error *error);

#endif
