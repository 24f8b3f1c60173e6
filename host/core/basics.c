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

void mcv_print_plain(FILE *out, const char *text) {
    for (const unsigned char *c = (const unsigned char *)text; *c; ++c) {
        const bool second = c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0; /* its low byte: c[1] */
        if (second) ++c;
        if (second || (*c < 0x20 && *c != '\n') || *c == 0x7f)
            fprintf(out, "\\u%04x", *c);
        else
            fputc(*c, out);
    }
}

uint64_t mcv_hash_bytes(uint64_t hash, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}
