/* SPDX-License-Identifier: Apache-2.0 */
/* Values of options: from a text to the field of a command. */
#include "options/option_table.h"

#include "scene/params.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A decimal integer, followed by one of the letters in `end` (or, for "", by the end of the
 * text). */
static bool parse_count(const char **text, char end, double min, double max, uint64_t *value) {
    const size_t digits = strspn(*text, "0123456789");
    if (digits == 0 || digits > 18 || (*text)[digits] != end) return false;
    *value = strtoull(*text, NULL, 10);
    *text += digits + (end != '\0');
    return (double)*value >= min && (double)*value <= max;
}

static bool parse_pair(const char *text, char between, double min, double max, uint64_t pair[2]) {
    return parse_count(&text, between, min, max, pair) &&
           parse_count(&text, '\0', min, max, pair + 1);
}

static bool parse_number(const char *text, double *value) {
    char *end;
    if (text[strspn(text, "0123456789.eE+-")])
        return false; /* strtod also accepts "inf", "nan" and hexadecimal numbers */
    *value = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*value);
}

typedef struct scaled_unit {
    const char *name;
    double factor, divisor; /* divided, because 1e3 is exact in binary and 1e-3 is not */
} scaled_unit;

static const scaled_unit times[] = {{"us", 1, 1e6}, {"µs", 1, 1e6}, {"ms", 1, 1e3}, {"s", 1, 1},
                                    {"min", 60, 1}, {"h", 3600, 1}, {NULL, 0, 0}};
static const scaled_unit sizes[] = {
    {"B", 1, 1},      {"kB", 1e3, 1},     {"MB", 1e6, 1},     {"GB", 1e9, 1},     {"TB", 1e12, 1},
    {"KiB", 1024, 1}, {"MiB", 0x1p20, 1}, {"GiB", 0x1p30, 1}, {"TiB", 0x1p40, 1}, {NULL, 0, 0}};

/* A number with one of these units. */
static bool parse_scaled(const char *text, const scaled_unit *units, double *value) {
    char digits[64];
    const size_t length = strspn(text, "0123456789.eE+-"),
                 unit = length + strspn(text + length, " ");
    if (length >= sizeof digits) return false;
    snprintf(digits, sizeof digits, "%.*s", (int)length, text);
    if (!parse_number(digits, value)) return false;
    for (; units->name; ++units) {
        if (strcmp(text + unit, units->name) != 0) continue;
        *value = *value * units->factor / units->divisor;
        return true;
    }
    return false;
}

/* A number, with a unit if the kind of option has one. */
static bool parse_number_in(mcv_option_kind kind, const char *text, double min, double max,
                            double *value) {
    const bool parsed =
        parse_number(text, value) || (kind == MCV_KIND_time && parse_scaled(text, times, value)) ||
        (kind == MCV_KIND_bytes && parse_scaled(text, sizes, value)) ||
        (kind == MCV_KIND_lengths && mcv_parse_quantity(text, MCV_PARAM_length, value));
    return parsed && *value > min && *value <= max;
}

/* One number for all channels, or three with commas between them. */
static bool parse_channels(mcv_option_kind kind, const char *text, double min, double max,
                           double values[3]) {
    char part[64];
    size_t count = 0;
    for (;; ++count, ++text) {
        const size_t length = strcspn(text, ",");
        if (count == 3 || length >= sizeof part) return false;
        memcpy(part, text, length);
        part[length] = '\0';
        if (!parse_number_in(kind, part, min, max, values + count)) return false;
        text += length;
        if (*text == '\0') break;
    }
    if (count == 0) values[1] = values[2] = values[0];
    return count != 1;
}

/* The index of text in "first|second|…". */
static bool parse_choice(const char *text, const char *words, uint64_t *index) {
    const size_t length = strlen(text);
    for (*index = 0;; ++*index) {
        const size_t word = strcspn(words, "|");
        if (word == length && strncmp(words, text, word) == 0) return true;
        if (words[word] == '\0') return false;
        words += word + 1;
    }
}

bool mcv_option_has_word(const mcv_option *o, const char *text) {
    uint64_t index;
    return parse_choice(text, o->argument, &index);
}

mcv_result mcv_option_set(const mcv_option *o, const char *text, mcv_command *command,
                          mcv_error *error) {
    void *field = (char *)command + o->offset;
    switch (o->kind) {
    case MCV_KIND_flag:
        *(bool *)field = true;
        return MCV_OK;
    case MCV_KIND_text:
        if (text[0] == '\0')
            return mcv_fail(error, MCV_USAGE, "--%s: is empty: must be %s", o->name, o->argument);
        *(const char **)field = text;
        return MCV_OK;
    case MCV_KIND_list:
        ((mcv_list *)field)->items[((mcv_list *)field)->count++] = text;
        return MCV_OK;
    case MCV_KIND_number:
    case MCV_KIND_time:
    case MCV_KIND_bytes:
        if (parse_number_in(o->kind, text, o->min, o->max, field)) return MCV_OK;
        return mcv_fail(
            error, MCV_USAGE, "--%s %s: must be a number above %g and at most %g%s", o->name, text,
            o->min, o->max,
            o->kind == MCV_KIND_time    ? " [s], or with a unit (us, ms, s, min, h), as in 10ms"
            : o->kind == MCV_KIND_bytes ? " bytes, or with a unit (kB, MB, GB), as in 500MB"
                                        : "");
    case MCV_KIND_channels:
    case MCV_KIND_lengths:
        if (parse_channels(o->kind, text, o->min, o->max, field)) return MCV_OK;
        return mcv_fail(
            error, MCV_USAGE,
            "--%s %s: must be one number or three with commas, each above %g and at most %g%s",
            o->name, text, o->min, o->max,
            o->kind == MCV_KIND_lengths ? " [m], or with a unit (nm, um, mm, cm, m), as in 550nm"
                                        : "");
    case MCV_KIND_count: {
        const char *rest = text;
        if (parse_count(&rest, '\0', o->min, o->max, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be an integer from %.0f to %.0f", o->name,
                        text, o->min, o->max);
    }
    case MCV_KIND_size:
        if (parse_pair(text, 'x', o->min, o->max, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE,
                        "--%s %s: must be %s, as in 640x480, each from %.0f to %.0f", o->name, text,
                        o->argument, o->min, o->max);
    case MCV_KIND_range:
        if (parse_pair(text, ':', o->min, o->max, field) &&
            ((uint64_t *)field)[0] < ((uint64_t *)field)[1])
            return MCV_OK;
        return mcv_fail(error, MCV_USAGE,
                        "--%s %s: must be %s with A < B, as in 0:64, each from %.0f to %.0f",
                        o->name, text, o->argument, o->min, o->max);
    case MCV_KIND_choice:
        if (parse_choice(text, o->argument, field)) return MCV_OK;
        return mcv_fail(error, MCV_USAGE, "--%s %s: must be one of %s", o->name, text, o->argument);
    }
    return MCV_OK;
}
