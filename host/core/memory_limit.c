/* SPDX-License-Identifier: Apache-2.0 */
#include "core/memory_limit.h"

#include <sys/resource.h>
#include <unistd.h>

uint64_t mcv_memory_default(void) {
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    uint64_t memory = pages > 0 && page > 0 ? (uint64_t)pages * (uint64_t)page : 1ull << 32;
    struct rlimit space;
    if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY &&
        space.rlim_cur < memory)
        memory = space.rlim_cur;
    return memory / 2;
}

mcv_result mcv_memory_check_image(const char *path, uint64_t pixels, uint64_t bytes,
                                  mcv_error *error) {
    const uint64_t needed = bytes + 12 * pixels, most = mcv_memory_default();
    if (needed <= most) return MCV_OK;
    return mcv_fail(error, MCV_BAD_INPUT,
                    "%s: reading and measuring it takes %.4g MB, more than the limit of %.4g MB, "
                    "half of the memory of the machine or process",
                    path, 1e-6 * (double)needed, 1e-6 * (double)most);
}
