/* SPDX-License-Identifier: Apache-2.0 */
#include "loader/data_uri.h"

#include <string.h>
#include <strings.h>

const char *const mcv_buffer_types[] = {"application/octet-stream", "application/gltf-buffer",
                                        "text/plain", NULL};

static int hex_digit(char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

static int base64_digit(int c) {
    return c >= 'A' && c <= 'Z'   ? c - 'A'
           : c >= 'a' && c <= 'z' ? c - 'a' + 26
           : c >= '0' && c <= '9' ? c - '0' + 52
           : c == '+'             ? 62
           : c == '/'             ? 63
                                  : -1;
}

/* The next byte, with %-escapes decoded; -1 at the end, -2 for a broken escape. */
static int next_byte(const char **text) {
    if (!**text) return -1;
    if (**text != '%') return (unsigned char)*(*text)++;
    const int high = hex_digit((*text)[1]), low = high < 0 ? -1 : hex_digit((*text)[2]);
    if (low < 0) return -2;
    *text += 3;
    return 16 * high + low;
}

/* The data behind "data:TYPE;PARAMETERS,"; *type_length characters behind "data:" are the type.
 * NULL without a comma. */
static const char *split(const char *uri, size_t *type_length, bool *base64) {
    static const char last[] = ";base64";
    const char *type = uri + strlen("data:"), *comma = strchr(type, ',');
    if (!comma) return NULL;
    *type_length = strcspn(type, ";,");
    const size_t head = (size_t)(comma - type), n = sizeof last - 1;
    *base64 = head >= n && strncasecmp(comma - n, last, n) == 0;
    return comma + 1;
}

static bool has_type(const char *uri, size_t length, const char *const *types) {
    const char *type = length ? uri + strlen("data:") : "text/plain"; /* what RFC 2397 says */
    if (length == 0) length = strlen(type);
    for (; *types; ++types)
        if (strlen(*types) == length && strncasecmp(*types, type, length) == 0) return true;
    return false;
}

mcv_result mcv_data_uri_length(const char *uri, const char *const *types, uint64_t *length,
                               const mcv_json_path *place, mcv_error *error) {
    size_t type_length = 0, digits = 0, padding = 0;
    bool base64 = false;
    const char *data = split(uri, &type_length, &base64), *at = data;
    *length = 0;
    if (!data || !has_type(uri, type_length, types))
        return mcv_fail_at(place, error, "\"%.40s...\" must begin with data:%s;base64,", uri,
                           types[0]);
    for (int c; (c = next_byte(&at)) != -1;) {
        const bool wrong = base64 && (padding ? c != '=' : base64_digit(c) < 0 && c != '=');
        if (c < 0 || wrong)
            return mcv_fail_at(place, error, "has broken %s at character %zu",
                               base64 ? "base64" : "%-escapes", (size_t)(at - uri));
        *(base64 && c == '=' ? &padding : &digits) += 1;
    }
    if (base64 && (padding > 2 || (digits + padding) % 4 != 0))
        return mcv_fail_at(place, error, "has broken base64 at character %zu", strlen(uri));
    if (digits == 0) return mcv_fail_at(place, error, "has no data");
    *length = base64 ? digits / 4 * 3 + (digits % 4 ? digits % 4 - 1 : 0) : digits;
    return MCV_OK;
}

void mcv_data_uri_decode(const char *uri, uint64_t first, uint64_t size, uint8_t *bytes) {
    size_t type_length;
    bool base64 = false;
    const char *at = split(uri, &type_length, &base64);
    uint32_t bits = 0;
    int count = 0;
    uint64_t index = 0;
    for (int c; index < first + size && (c = next_byte(&at)) >= 0;) {
        if (base64) {
            bits = bits << 6 | (uint32_t)(base64_digit(c) & 63);
            count += 6;
            if (count < 8) continue;
            count -= 8;
            c = (int)(bits >> count & 0xff);
        }
        if (index >= first) bytes[index - first] = (uint8_t)c;
        ++index;
    }
}
