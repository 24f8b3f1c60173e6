/* SPDX-License-Identifier: Apache-2.0 */
/* How much memory a file may ask for. */
#ifndef MCVISI_HOST_CORE_MEMORY_LIMIT_H
#define MCVISI_HOST_CORE_MEMORY_LIMIT_H

#include "core/error.h"

#include <stdint.h>

/* Half of the machine's memory, or of the limit of the address space (RLIMIT_AS), if that is
 * lower. */
uint64_t mcv_memory_default(void);

/* Can an image be read and measured? To read it takes `bytes`: its file, 4 bytes a value, and what
 * the decoder needs. To measure it takes 12 more for each of `pixels` (measured: 15 in all for one
 * channel, 23 for three). MCV_BAD_INPUT, with the numbers, where that is more than the default. */
mcv_result mcv_memory_check_image(const char *path, uint64_t pixels, uint64_t bytes,
                                  mcv_error *error);

#endif
