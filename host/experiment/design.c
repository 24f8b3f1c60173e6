/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/design.h"

#include "analysis/noise.h"
#include "scene/params.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- levels --- */

static bool parse_value(const char *text, size_t length, double *value) {
    char copy[64], *end;
    if (length == 0 || length >= sizeof copy) return false;
    memcpy(copy, text, length);
    copy[length] = '\0';
    if (copy[strspn(copy, "0123456789.eE+-")] ==
        '\0') { /* strtod also accepts "inf" and the like */
        *value = strtod(copy, &end);
        return end != copy && *end == '\0' && isfinite(*value);
    }
    return mcv_parse_quantity(copy, MCV_PARAM_choice, value) && isfinite(*value);
}

static mcv_result fail_levels(const char *text, mcv_error *error) {
    return mcv_fail(error, MCV_USAGE,
                    "\"%s\": must be FROM..TO:N, FROM..TO:N:log, FROM..TO or A,B,C, numbers with "
                    "or without a unit, or words",
                    text);
}

static mcv_result parse_range(const char *text, const char *dots, mcv_levels *levels,
                              mcv_error *error) {
    const char *to = dots + 2, *rest = to + strcspn(to, ":");
    char *end;
    if (!parse_value(text, (size_t)(dots - text), &levels->from) ||
        !parse_value(to, (size_t)(rest - to), &levels->to))
        return fail_levels(text, error);
    levels->logarithmic = strcmp(rest, ":log") == 0;
    if (*rest && !levels->logarithmic) {
        if (rest[1] < '0' || rest[1] > '9') return fail_levels(text, error);
        levels->count = strtoul(rest + 1, &end, 10);
        levels->logarithmic = strcmp(end, ":log") == 0;
        if (*end && !levels->logarithmic) return fail_levels(text, error);
        if (levels->count < 1 || levels->count > MCV_DESIGN_SETS)
            return mcv_fail(error, MCV_USAGE, "\"%s\": N must be 1 to %d", text, MCV_DESIGN_SETS);
    }
    if (levels->logarithmic && !(levels->from > 0 && levels->to > 0))
        return mcv_fail(error, MCV_USAGE,
                        "\"%s\": both ends of a logarithmic range must be above 0", text);
    return MCV_OK;
}

/* Begins with a letter, and can stand in a path, a table and a shell. */
static bool is_word(const char *text, size_t length) {
    for (size_t i = 0; i < length; ++i) {
        const unsigned char c = (unsigned char)text[i];
        if (!isalpha(c) && c < 0x80 && (i == 0 || !(isdigit(c) || strchr("_-./", c)))) return false;
    }
    return length > 0 && length < 64;
}

mcv_result mcv_levels_parse(const char *text, mcv_levels *levels, mcv_error *error) {
    const char *dots = strstr(text, "..");
    *levels = (mcv_levels){0};
    if (dots) return parse_range(text, dots, levels, error);
    size_t most = 1;
    for (const char *c = text; *c; ++c) most += *c == ',';
    levels->list = malloc(most * sizeof *levels->list);
    if (!levels->list)
        return mcv_fail(error, MCV_FAILED, "no memory for the values of \"%.100s\"", text);
    levels->named = most > 1 && is_word(text, strcspn(text, ","));
    for (const char *at = text;; ++at) {
        const size_t length = strcspn(at, ",");
        double *value = levels->list + levels->count;
        *value = (double)levels->count++;
        if (levels->named ? !is_word(at, length) : !parse_value(at, length, value)) {
            mcv_levels_free(levels);
            return fail_levels(text, error);
        }
        at += length;
        if (*at == '\0') return MCV_OK;
    }
}

void mcv_levels_free(mcv_levels *levels) {
    free(levels->list);
    *levels = (mcv_levels){0};
}

/* The value at a share 0 … 1 of the range. */
static double between(const mcv_levels *l, double share) {
    if (share >= 1) return l->to;
    return l->logarithmic ? l->from * pow(l->to / l->from, share)
                          : l->from + share * (l->to - l->from);
}

static double level(const mcv_levels *l, size_t index) {
    if (l->list) return l->list[index];
    return l->count == 1 ? l->from : between(l, (double)index / (double)(l->count - 1));
}

double mcv_levels_at(const mcv_levels *l, size_t index) { return level(l, index); }

/* The value at a point of [0, 1). */
static double at_point(const mcv_levels *l, double x) {
    return l->list ? l->list[(size_t)(x * (double)l->count)] : between(l, x);
}

/* --- points --- */

/* S. Joe and F. Y. Kuo, Constructing Sobol sequences with better two-dimensional projections, 2008:
 * degree, polynomial and first numbers.
 */
static const struct {
    uint32_t degree, polynomial, numbers[6];
} directions[MCV_DESIGN_PARAMETERS] = {{0, 0, {0}},
                                       {1, 0, {1}},
                                       {2, 1, {1, 3}},
                                       {3, 1, {1, 3, 1}},
                                       {3, 2, {1, 1, 1}},
                                       {4, 1, {1, 1, 3, 3}},
                                       {4, 4, {1, 3, 5, 13}},
                                       {5, 2, {1, 1, 5, 5, 17}},
                                       {5, 4, {1, 1, 5, 5, 5}},
                                       {5, 7, {1, 1, 7, 11, 19}},
                                       {5, 11, {1, 1, 5, 1, 1}},
                                       {5, 13, {1, 1, 1, 3, 11}},
                                       {5, 14, {1, 3, 5, 5, 31}},
                                       {6, 1, {1, 3, 3, 9, 7, 49}},
                                       {6, 13, {1, 1, 1, 15, 21, 21}},
                                       {6, 16, {1, 3, 1, 13, 27, 49}}};

static void make_matrix(size_t dimension, uint32_t columns[32]) {
    const uint32_t s = directions[dimension].degree, a = directions[dimension].polynomial;
    for (uint32_t i = 0; i < 32; ++i) {
        if (s == 0) {
            columns[i] = 1u << (31 - i);
        } else if (i < s) {
            columns[i] = directions[dimension].numbers[i] << (31 - i);
        } else {
            columns[i] = columns[i - s] ^ columns[i - s] >> s;
            for (uint32_t k = 1; k < s; ++k) columns[i] ^= (a >> (s - 1 - k) & 1) * columns[i - k];
        }
    }
}

static void fill_sobol(size_t dimension, size_t points, uint32_t seed, double *x, size_t stride) {
    uint32_t columns[32];
    mcv_noise noise = mcv_noise_begin(seed, (uint32_t)dimension, 0);
    const uint32_t shift = (uint32_t)(mcv_noise_uniform(&noise) * 0x1p32);
    make_matrix(dimension, columns);
    for (size_t i = 0; i < points; ++i) {
        uint32_t word = shift;
        for (uint32_t bit = 0; i >> bit; ++bit) word ^= (i >> bit & 1) * columns[bit];
        x[i * stride] = (word + 0.5) * 0x1p-32;
    }
}

static void fill_lhs(size_t dimension, size_t points, uint32_t seed, double *x, size_t stride) {
    mcv_noise noise = mcv_noise_begin(seed, (uint32_t)dimension, 1);
    for (size_t i = 0; i < points; ++i) x[i * stride] = (double)i;
    for (size_t i = points; i-- > 1;) {
        const size_t other = (size_t)(mcv_noise_uniform(&noise) * (double)(i + 1));
        const double swapped = x[i * stride];
        x[i * stride] = x[other * stride];
        x[other * stride] = swapped;
    }
    /* A number below 1 even after rounding. */
    for (size_t i = 0; i < points; ++i)
        x[i * stride] =
            fmin((x[i * stride] + mcv_noise_uniform(&noise)) / (double)points, 1 - 0x1p-53);
}

/* --- sets --- */

static mcv_result count_sets(int design, const mcv_levels *levels, size_t parameters, size_t points,
                             size_t *sets, mcv_error *error) {
    const bool space = design == MCV_DESIGN_LHS || design == MCV_DESIGN_SOBOL;
    *sets = space ? points : design == MCV_DESIGN_LIST && parameters ? levels[0].count : 1;
    if (parameters > MCV_DESIGN_PARAMETERS)
        return mcv_fail(error, MCV_USAGE, "%zu parameters vary: at most %d can", parameters,
                        MCV_DESIGN_PARAMETERS);
    if (space && points == 0)
        return mcv_fail(error, MCV_USAGE, "this design needs --points N, the number of sets");
    if (!space && points > 0)
        return mcv_fail(error, MCV_USAGE,
                        "--points %zu is of --design lhs and sobol: name one of them, or write the "
                        "number of steps as FROM..TO:N",
                        points);
    for (size_t p = 0; p < parameters && !space; ++p) {
        if (levels[p].count == 0)
            return mcv_fail(
                error, MCV_USAGE,
                "a range without a number of steps is for --design lhs or sobol: write FROM..TO:N");
        if (design == MCV_DESIGN_LIST && levels[p].count != *sets)
            return mcv_fail(
                error, MCV_USAGE,
                "--design list takes the values of all parameters together: one parameter has %zu, "
                "another %zu",
                *sets, levels[p].count);
        if (design == MCV_DESIGN_GRID && levels[p].count > MCV_DESIGN_SETS / *sets)
            *sets = MCV_DESIGN_SETS + 1;
        if (*sets > MCV_DESIGN_SETS) break;
        if (design == MCV_DESIGN_GRID) *sets *= levels[p].count;
    }
    return *sets <= MCV_DESIGN_SETS
               ? MCV_OK
               : mcv_fail(error, MCV_USAGE, "the design has more than %d sets", MCV_DESIGN_SETS);
}

mcv_result mcv_design_make(int design, const mcv_levels *levels, size_t parameters, size_t points,
                           uint32_t seed, double **values, size_t *sets, mcv_error *error) {
    MCV_TRY(count_sets(design, levels, parameters, points, sets, error));
    double *v = calloc(*sets * (parameters ? parameters : 1), sizeof *v);
    if (!v) return mcv_fail(error, MCV_FAILED, "no memory for %zu sets of parameters", *sets);
    size_t repeat = *sets; /* of the grid: number of sets over which this parameter keeps its level,
                              times its number of levels */
    for (size_t p = 0; p < parameters; ++p) {
        if (design == MCV_DESIGN_GRID) repeat /= levels[p].count;
        if (design == MCV_DESIGN_LHS) fill_lhs(p, *sets, seed, v + p, parameters);
        if (design == MCV_DESIGN_SOBOL) fill_sobol(p, *sets, seed, v + p, parameters);
        for (size_t i = 0; i < *sets; ++i) {
            double *value = v + i * parameters + p;
            if (design == MCV_DESIGN_GRID)
                *value = level(levels + p, i / repeat % levels[p].count);
            else
                *value =
                    design == MCV_DESIGN_LIST ? level(levels + p, i) : at_point(levels + p, *value);
        }
    }
    *values = v;
    return MCV_OK;
}
