/* SPDX-License-Identifier: Apache-2.0 */
/* Text of lens files, its words, and messages that name their place. */
#include "lens/lens.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/basics.h"
#include "core/output_file.h"

static size_t write_utf8(char *out, unsigned code) {
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    if (code < 0x800) {
        out[0] = (char)(0xc0 | code >> 6);
        out[1] = (char)(0x80 | (code & 63));
        return 2;
    }
    out[0] = (char)(0xe0 | code >> 12);
    out[1] = (char)(0x80 | (code >> 6 & 63));
    out[2] = (char)(0x80 | (code & 63));
    return 3;
}

/* Length of the UTF-8 character that begins here, 0 if none does. */
static size_t utf8_length(const uint8_t *bytes, size_t size) {
    const size_t length = bytes[0] < 0x80                       ? 1
                          : bytes[0] >= 0xc2 && bytes[0] < 0xe0 ? 2
                          : bytes[0] >= 0xe0 && bytes[0] < 0xf0 ? 3
                                                                : 0;
    if (length == 0 || length > size) return 0;
    for (size_t i = 1; i < length; ++i)
        if ((bytes[i] & 0xc0) != 0x80) return 0;
    if (length == 3 &&
        ((bytes[0] == 0xe0 && bytes[1] < 0xa0) || (bytes[0] == 0xed && bytes[1] >= 0xa0)))
        return 0;
    return length;
}

/* Which byte of a pair is the low one: 0 or 1; -1 for single bytes. `skip`: the bytes of the mark.
 */
static int find_pairs(const uint8_t *bytes, size_t size, size_t *skip) {
    *skip = 2;
    if (size >= 2 && bytes[0] == 0xff && bytes[1] == 0xfe) return 0;
    if (size >= 2 && bytes[0] == 0xfe && bytes[1] == 0xff) return 1;
    *skip = size >= 3 && bytes[0] == 0xef && bytes[1] == 0xbb && bytes[2] == 0xbf ? 3 : 0;
    if (size >= 2 && bytes[0] && !bytes[1]) return 0;
    return size >= 2 && !bytes[0] && bytes[1] ? 1 : -1;
}

mcv_result mcv_lens_text_load(const char *path, char **text, mcv_error *error) {
    uint8_t *bytes;
    size_t size, skip, n = 0;
    MCV_TRY(mcv_file_load(path, &bytes, &size, error));
    const int low = find_pairs(bytes, size, &skip);
    char *out = malloc(3 * size + 1);
    if (!out) {
        free(bytes);
        return mcv_fail(error, MCV_FAILED, "%s: no memory for it", path);
    }
    for (size_t i = skip; i < size;) {
        if (low >= 0) {
            const unsigned code =
                i + 1 < size ? bytes[i + (size_t)low] | (unsigned)bytes[i + 1 - (size_t)low] << 8
                             : '?';
            n += write_utf8(out + n, code == 0 || (code >= 0xd800 && code < 0xe000) ? '?' : code);
            i += 2;
            continue;
        }
        const size_t length = utf8_length(bytes + i, size - i);
        if (length > 1) memcpy(out + n, bytes + i, length);
        n += length > 1 ? length : write_utf8(out + n, bytes[i] ? bytes[i] : '?');
        i += length > 1 ? length : 1;
    }
    out[n] = '\0';
    free(bytes);
    *text = out;
    return MCV_OK;
}

int mcv_lens_split(char *statement, char *words[MCV_LENS_WORDS]) {
    int n = 0;
    while (n < MCV_LENS_WORDS) {
        while (isspace((unsigned char)*statement)) ++statement;
        if (!*statement) break;
        const char quote = (char)(*statement == '\'' || *statement == '"' ? *statement : 0);
        if (quote) ++statement;
        words[n++] = statement;
        while (*statement && (quote ? *statement != quote : !isspace((unsigned char)*statement)))
            ++statement;
        if (!*statement) break;
        *statement++ = '\0';
    }
    return n;
}

bool mcv_lens_is(const char *word, const char *other) { return strcasecmp(word, other) == 0; }

bool mcv_lens_is_one_of(const char *word, const char *list) {
    const size_t length = strlen(word);
    if (length == 0 || strchr(word, ' ')) return false;
    for (const char *found = list; (found = strcasestr(found, word)); ++found)
        if (found > list && found[-1] == ' ' && found[length] == ' ') return true;
    return false;
}

void mcv_lens_copy_name(char out[MCV_LENS_NAME], const char *text) {
    snprintf(out, MCV_LENS_NAME, "%.*s", mcv_whole_characters(text, MCV_LENS_NAME - 1), text);
}

mcv_result mcv_lens_distance(const mcv_lens *l, const char *word, double *value, mcv_error *error) {
    char *end;
    *value = strtod(word, &end);
    if (end != word && *end == '\0' && !isnan(*value)) return MCV_OK;
    return mcv_lens_fail(l, l->line, l->count - 1, error, "\"%s\" must be a number", word);
}

mcv_result mcv_lens_number(const mcv_lens *l, const char *word, double *value, mcv_error *error) {
    MCV_TRY(mcv_lens_distance(l, word, value, error));
    if (fabs(*value) < 1e30) return MCV_OK;
    return mcv_lens_fail(l, l->line, l->count - 1, error, "\"%s\" is too large a number", word);
}

mcv_result mcv_lens_fail(const mcv_lens *l, int line, int surface, mcv_error *error,
                         const char *format, ...) {
    char what[400], place[64] = "";
    int n = 0;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    if (line > 0) n = snprintf(place, sizeof place, " line %d:", line);
    if (surface >= 0) snprintf(place + n, sizeof place - (size_t)n, " surface %d:", surface);
    return mcv_fail(error, MCV_BAD_INPUT, "%s:%s %s", l->path, place, what);
}

void mcv_lens_warn(mcv_lens *l, const char *format, ...) {
    if (l->report->warning_count == MCV_LENS_WARNINGS) return;
    char *text = l->report->warnings[l->report->warning_count++];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof l->report->warnings[0], format, arguments);
    va_end(arguments);
}

mcv_result mcv_lens_add_surface(mcv_lens *l, mcv_error *error) {
    if (l->count == MCV_LENS_SURFACES)
        return mcv_lens_fail(l, l->line, -1, error, "more than %d surfaces", MCV_LENS_SURFACES);
    l->surfaces[l->count++] = (mcv_lens_surface){.line = l->line};
    return MCV_OK;
}
