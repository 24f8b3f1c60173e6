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

int mcv_whole_characters(const char *text, int most) {
    int count = (int)strnlen(text, (size_t)most + 1);
    if (count <= most) return count;
    for (count = most; count > 0 && ((unsigned char)text[count] & 0xc0) == 0x80;) --count;
    return count;
}
