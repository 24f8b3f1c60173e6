/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/expression.h"

#include "scene/params.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct known {
    char name[128];
    mcv_quantity quantity;
    double shift; /* added to the value, in uncertainties */
} known;

/* One walk through the text, which computes as it reads. */
typedef struct reader {
    const char *text, *at;
    mcv_lookup *lookup;
    void *user;
    known names[MCV_EXPRESSION_NAMES];
    size_t count;
    int depth;
    mcv_result result;
    mcv_error *error;
} reader;

static double wrong(reader *r, const char *what) {
    if (r->result == MCV_OK) {
        r->result =
            *r->at ? mcv_fail(r->error, MCV_USAGE, "\"%s\": %s at \"%.20s\"", r->text, what, r->at)
                   : mcv_fail(r->error, MCV_USAGE, "\"%s\": %s at its end", r->text, what);
    }
    return NAN;
}

static void skip_spaces(reader *r) { r->at += strspn(r->at, " \t\n"); }

static bool take(reader *r, const char *token) {
    skip_spaces(r);
    const size_t length = strlen(token);
    if (strncmp(r->at, token, length) != 0) return false;
    r->at += length;
    return true;
}

static double read_sum(reader *r);
static double read_either(reader *r);

static double value_of(reader *r, const char *name) {
    for (size_t i = 0; i < r->count; ++i)
        if (strcmp(r->names[i].name, name) == 0)
            return r->names[i].shift == 0
                       ? r->names[i].quantity.value
                       : r->names[i].quantity.value +
                             r->names[i].shift * r->names[i].quantity.uncertainty;
    if (r->count == MCV_EXPRESSION_NAMES) return wrong(r, "too many names");
    known *new = r->names + r->count;
    *new = (known){.quantity = {NAN, 0}};
    snprintf(new->name, sizeof new->name, "%s", name);
    const mcv_result result = r->lookup(r->user, name, &new->quantity, r->error);
    if (result != MCV_OK && r->result == MCV_OK) r->result = result;
    ++r->count;
    return new->quantity.value;
}

static double call(reader *r, const char *name) {
    static const struct {
        const char *name;
        double (*of)(double);
    } functions[] = {{"abs", fabs}, {"sqrt", sqrt}, {"exp", exp},   {"log", log},   {"sin", sin},
                     {"cos", cos},  {"tan", tan},   {"asin", asin}, {"acos", acos}, {"atan", atan}};
    const double a = read_either(r);
    const bool least = strcmp(name, "min") == 0;
    if (least || strcmp(name, "max") == 0) {
        if (!take(r, ",")) return wrong(r, "min and max take two values: a comma is missing");
        const double b = read_either(r);
        if (!take(r, ")")) return wrong(r, "a ) is missing");
        return least ? fmin(a, b) : fmax(a, b);
    }
    if (!take(r, ")")) return wrong(r, "a ) is missing");
    for (size_t i = 0; i < sizeof functions / sizeof functions[0]; ++i)
        if (strcmp(functions[i].name, name) == 0) return functions[i].of(a);
    return wrong(r, "there is no such function before the brackets");
}

static double read_number(reader *r) {
    char text[64], *end;
    const double plain = strtod(r->at, &end);
    const size_t digits = (size_t)(end - r->at);
    size_t length = digits;
    while (isalpha((unsigned char)r->at[length]) || (unsigned char)r->at[length] >= 0x80) ++length;
    double value = plain;
    if (length >= sizeof text) return wrong(r, "this is no number");
    snprintf(text, sizeof text, "%.*s", (int)length, r->at);
    if (length > digits && !mcv_parse_quantity(text, MCV_PARAM_choice, &value))
        return wrong(r, "this is no number with a unit");
    r->at += length;
    return value;
}

static bool read_name(reader *r, char name[128]) {
    size_t length = 0;
    skip_spaces(r);
    if (!isalpha((unsigned char)*r->at) && *r->at != '_') {
        wrong(r, "a number or a name is missing");
        return false;
    }
    while (isalnum((unsigned char)r->at[length]) || r->at[length] == '_' || r->at[length] == '.')
        ++length;
    if (length >= 128) {
        wrong(r, "the name is too long");
        return false;
    }
    snprintf(name, 128, "%.*s", (int)length, r->at);
    r->at += length;
    return true;
}

/* u(NAME): the standard uncertainty itself, which has none. */
static double read_uncertainty(reader *r) {
    char name[128];
    if (!read_name(r, name)) return NAN;
    (void)value_of(r, name);
    if (!take(r, ")")) return wrong(r, "u takes one name: a ) is missing");
    for (size_t i = 0; i < r->count; ++i)
        if (strcmp(r->names[i].name, name) == 0) return r->names[i].quantity.uncertainty;
    return NAN;
}

static double read_primary(reader *r) {
    char name[128];
    skip_spaces(r);
    if (take(r, "(")) {
        const double value = read_either(r);
        return take(r, ")") ? value : wrong(r, "a ) is missing");
    }
    if (isdigit((unsigned char)*r->at) || (*r->at == '.' && isdigit((unsigned char)r->at[1])))
        return read_number(r);
    if (!read_name(r, name)) return NAN;
    if (take(r, "(")) return strcmp(name, "u") == 0 ? read_uncertainty(r) : call(r, name);
    return strcmp(name, "pi") == 0 ? 3.141592653589793 : value_of(r, name);
}

static double read_power(reader *r) {
    if (++r->depth > MCV_EXPRESSION_DEPTH) {
        --r->depth;
        return wrong(r, "it is nested too deeply");
    }
    const bool negative = take(r, "-");
    double value = negative ? -read_power(r) : read_primary(r);
    if (!negative && take(r, "^")) value = pow(value, read_power(r));
    --r->depth;
    return value;
}

static double read_product(reader *r) {
    double value = read_power(r);
    while (r->result == MCV_OK) {
        if (take(r, "*"))
            value *= read_power(r);
        else if (take(r, "/"))
            value /= read_power(r);
        else
            break;
    }
    return value;
}

static double read_sum(reader *r) {
    double value = read_product(r);
    while (r->result == MCV_OK) {
        if (take(r, "+"))
            value += read_product(r);
        else if (take(r, "-"))
            value -= read_product(r);
        else
            break;
    }
    return value;
}

static double read_comparison(reader *r) {
    const double a = read_sum(r);
    if (take(r, "<=")) return a <= read_sum(r);
    if (take(r, ">=")) return a >= read_sum(r);
    if (take(r, "==")) return a == read_sum(r);
    if (take(r, "!=")) return a != read_sum(r);
    if (take(r, "<")) return a < read_sum(r);
    if (take(r, ">")) return a > read_sum(r);
    return a;
}

static double read_both(reader *r) {
    double value = read_comparison(r);
    while (r->result == MCV_OK && take(r, "&&")) {
        const double other = read_comparison(r);
        value = value != 0 && other != 0;
    }
    return value;
}

static double read_either(reader *r) {
    double value = read_both(r);
    while (r->result == MCV_OK && take(r, "||")) {
        const double other = read_both(r);
        value = value != 0 || other != 0;
    }
    return value;
}

static double read_all(reader *r) {
    r->at = r->text;
    const double value = read_either(r);
    skip_spaces(r);
    return *r->at ? wrong(r, "this is not an expression") : value;
}

mcv_result mcv_expression_evaluate(const char *text, mcv_lookup *lookup, void *user,
                                   mcv_quantity *value, mcv_error *error) {
    reader r = {.text = text, .lookup = lookup, .user = user, .error = error};
    *value = (mcv_quantity){read_all(&r), 0};
    MCV_TRY(r.result);
    const size_t count = r.count;
    for (size_t i = 0; i < count; ++i) {
        if (r.names[i].quantity.uncertainty == 0) continue;
        r.names[i].shift = 1;
        const double above = read_all(&r);
        r.names[i].shift = -1;
        const double below = read_all(&r);
        r.names[i].shift = 0;
        value->uncertainty += 0.5 * fabs(above - below);
    }
    return MCV_OK;
}
