/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes of defects as drawings of optical elements state them (defects.h). */
#include "defects/defects.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How a type is stated: the number of the indication, and the letter before N x A; 0: none. */
typedef struct statement {
    char indication; /* 0: this type has no such size */
    char letter;
} statement;

static statement statement_of(uint32_t type) {
    switch (type) {
    case MCV_DEFECT_BUBBLE:
    case MCV_DEFECT_INCLUSION:
        return (statement){'1', 0};
    case MCV_DEFECT_DIG:
    case MCV_DEFECT_STAIN:
    case MCV_DEFECT_ROUGH_PATCH:
        return (statement){'5', 0};
    case MCV_DEFECT_SCRATCH:
        return (statement){'5', 'L'};
    case MCV_DEFECT_CHIP:
        return (statement){'5', 'E'};
    default:
        return (statement){0, 0};
    }
}

static const char *skip(const char *text) {
    while (isspace((unsigned char)*text)) ++text;
    return text;
}

/* A number without sign; what follows it. False without one. */
static bool take_number(const char **text, double *number) {
    char *end;
    if (!isdigit((unsigned char)**text) && **text != '.') return false;
    *number = strtod(*text, &end);
    if (end == *text || !isfinite(*number)) return false;
    *text = skip(end);
    return true;
}

/* x, X or × (two bytes of UTF-8). */
static bool take_times(const char **text) {
    static const char times[] = "\xc3\x97";
    const size_t length = **text == 'x' || **text == 'X'                 ? 1
                          : strncmp(*text, times, sizeof times - 1) == 0 ? sizeof times - 1
                                                                         : 0;
    *text = skip(*text + length);
    return length > 0;
}

/* One term: [C|L] N x A or E A. */
typedef struct term {
    char letter;
    double count, grade;
} term;

static bool take_term(const char **text, term *one) {
    *one = (term){.letter = 0, .count = 1};
    if (**text == 'C' || **text == 'L' || **text == 'E') {
        if (**text != 'C') one->letter = **text; /* coatings count as surfaces do */
        *text = skip(*text + 1);
    }
    if (one->letter != 'E' && !(take_number(text, &one->count) && take_times(text))) return false;
    if (!take_number(text, &one->grade)) return false;
    return one->grade > 0 && one->count >= 1 && one->count <= 1000 &&
           one->count == floor(one->count);
}

/* The term of the type in "N x A; L N x A; E A". */
static bool find_term(const char *text, char letter, term *found) {
    bool have = false;
    for (bool more = true; more;) {
        term one;
        if (!take_term(&text, &one)) return false;
        if (one.letter == letter && !have) *found = one, have = true;
        more = *text == ';';
        if (more) text = skip(text + 1);
    }
    return have && *text == '\0';
}

/* The diameter of a disc of the area A²; the width of a scratch; a ball that reaches A from an
 * edge. */
static double size_of(const term *one) {
    const double mm = 1e-3;
    if (one->letter == 'L') return one->grade * mm;
    return (one->letter == 'E' ? 2 : M_2_SQRTPI) * one->grade * mm;
}

/* "60-40": tenths of a micrometre for a scratch, hundredths of a millimetre for others. */
static bool read_scratch_dig(const char *text, uint32_t type, double *size) {
    double scratch, dig;
    if (!take_number(&text, &scratch) || *text != '-') return false;
    ++text;
    if (!take_number(&text, &dig) || *text) return false;
    *size = type == MCV_DEFECT_SCRATCH ? scratch * 1e-7 : dig * 1e-5;
    return *size > 0;
}

bool mcv_defect_is_notation(const char *text) {
    const char *dash = strchr(text, '-');
    return ((text[0] == '1' || text[0] == '5') && text[1] == '/') ||
           (dash && dash > text && isdigit((unsigned char)dash[-1]) &&
            isdigit((unsigned char)dash[1]));
}

mcv_result mcv_defect_read_notation(const char *text, uint32_t type, double *size, uint64_t *count,
                                    const mcv_json_path *place, mcv_error *error) {
    const statement wanted = statement_of(type);
    term one;
    *count = 0;
    if (!wanted.indication)
        return mcv_fail_at(place, error, "\"%s\": a %s has no size on drawings: give a length",
                           text, mcv_defect_types[type]);
    if (text[1] != '/') {
        if (wanted.letter != 'E' && read_scratch_dig(text, type, size)) return MCV_OK;
        return mcv_fail_at(place, error,
                           "\"%s\" must be a length, or for a scratch, a dig or a bubble the "
                           "scratch-dig numbers, as in \"60-40\"",
                           text);
    }
    if (text[0] != wanted.indication || !find_term(skip(text + 2), wanted.letter, &one))
        return mcv_fail_at(place, error, "\"%s\" must be a length, or for a %s as in \"%c/ %s\"",
                           text, mcv_defect_types[type], wanted.indication,
                           wanted.letter == 'E'   ? "E 0.5"
                           : wanted.letter == 'L' ? "L 2 x 0.008"
                                                  : "3 x 0.16");
    *size = size_of(&one);
    if (wanted.letter != 'E') *count = (uint64_t)one.count;
    return MCV_OK;
}
