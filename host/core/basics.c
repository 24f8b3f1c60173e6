/* SPDX-License-Identifier: Apache-2.0 */
#include "core/basics.h"

#include <string.h>
#include <strings.h>
#include <time.h>

double mcv_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

bool mcv_ends_in(const char *path, const char *ending) {
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot, ending) == 0;
}
