/* SPDX-License-Identifier: Apache-2.0 */
#include "core/basics.h"

#include <stdlib.h>
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

int mcv_character(const char *text, uint32_t *code) {
    const unsigned char *c = (const unsigned char *)text;
    const int length = c[0] < 0x80             ? 1
                       : c[0] >> 5 == 6        ? 2
                       : c[0] >> 4 == 14       ? 3
                       : (c[0] & 0xf8) == 0xf0 ? 4
                                               : 0;
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    if (length == 0) return 0;
    *code = length == 1 ? c[0] : c[0] & (0xffu >> (length + 1));
    for (int i = 1; i < length; ++i) {
        if ((c[i] & 0xc0) != 0x80) return 0;
        *code = *code << 6 | (c[i] & 0x3f);
    }
    const bool is_surrogate = *code >= 0xd800 && *code < 0xe000;
    return *code < least[length] || *code > 0x10ffff || is_surrogate ? 0 : length;
}

/* Characters that move the cursor, change colours, or turn the direction of writing. */
static bool is_control(uint32_t code) {
    return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x200e || code == 0x200f ||
           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

static void print_escaped(FILE *out, const char *text, bool is_line) {
    for (uint32_t code; *text;) {
        const int length = mcv_character(text, &code);
        if (length == 0)
            fprintf(out, "\\x%02x", (unsigned char)*text);
        else if (is_control(code) && (is_line || code != '\n'))
            fprintf(out, "\\u%04x", (unsigned)code);
        else
            fwrite(text, 1, (size_t)length, out);
        text += length ? length : 1;
    }
}

void mcv_print_plain(FILE *out, const char *text) { print_escaped(out, text, false); }

void mcv_print_line(FILE *out, const char *text) { print_escaped(out, text, true); }

uint64_t mcv_hash_bytes(uint64_t hash, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}

bool mcv_text_close(FILE *stream, char **text) {
    const bool whole = stream && !ferror(stream);
    if (stream && fclose(stream) == 0 && whole && *text) return true;
    free(*text);
    *text = NULL;
    return false;
}
