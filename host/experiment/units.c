/* SPDX-License-Identifier: Apache-2.0 */
#include "experiment/units.h"

#include "scene/params.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const mcv_shown_unit plain = {"", 1};

/* "mm" of "12mm..14mm:3". */
static bool first_unit(const char *values, char name[16]) {
    while (*values) {
        char *end;
        (void)strtod(values, &end);
        if (end == values) {
            ++values;
            continue;
        }
        values = end + strspn(end, " ");
        size_t length = 0;
        while (isalpha((unsigned char)values[length]) || (unsigned char)values[length] >= 0x80)
            ++length;
        snprintf(name, 16, "%.*s", (int)length, values);
        if (length > 0) return true;
    }
    return false;
}

mcv_shown_unit mcv_unit_of_parameter(const mcv_parameter *p) {
    mcv_shown_unit unit = plain;
    char name[16], one[24];
    double si;
    if (p->expression || p->levels.named || !first_unit(p->item + p->path_length + 1, name))
        return plain;
    snprintf(one, sizeof one, "1%s", name);
    if (!mcv_parse_quantity(one, MCV_PARAM_choice, &si)) return plain;
    const bool degrees = strcmp(name, "deg") == 0, micro = strcmp(name, "um") == 0;
    snprintf(unit.name, sizeof unit.name, "%s", degrees ? "°" : micro ? "µm" : name);
    unit.per_si = 1 / si;
    return unit;
}

mcv_shown_unit mcv_unit_of_metric(const char *expression, mcv_metric_units units, double largest) {
    mcv_shown_unit unit = plain;
    const char *name = mcv_metric_unit(expression, units);
    if (strcmp(name, "m") == 0) {
        unit.per_si = largest >= 1 ? 1 : largest >= 1e-3 ? 1e3 : 1e6;
        name = largest >= 1 ? "m" : largest >= 1e-3 ? "mm" : "µm";
    } else if (strcmp(name, "rad") == 0) {
        unit.per_si = 180 / M_PI;
        name = "°";
    }
    snprintf(unit.name, sizeof unit.name, "%s", name);
    return unit;
}

void mcv_name_with_unit(const char *name, const mcv_shown_unit *unit, char words[], size_t size) {
    if (unit->name[0])
        snprintf(words, size, "%s [%s]", name, unit->name);
    else
        snprintf(words, size, "%s", name);
}

void mcv_value_words(double value, double uncertainty, char words[48]) {
    words[0] = '\0';
    if (isnan(value)) return;
    snprintf(words, 48, "%.6g", value);
    if (!(uncertainty > 0) || !isfinite(uncertainty) || !isfinite(value)) return;
    /* Two digits: 0.0996 becomes 0.10. */
    int last = (int)floor(log10(uncertainty)) - 1;
    double digits = round(uncertainty / pow(10, last));
    if (digits >= 100) {
        ++last;
        digits = 10;
    }
    if (last > 0 || last < -12 || fabs(value) < 1e-3)
        snprintf(words, 48, "%.6g ± %.2g", value, uncertainty);
    else if (uncertainty > fabs(value))
        snprintf(words, 48, "%.*f ± %.2g", -last, value, uncertainty);
    else if (last == 0)
        snprintf(words, 48, "%.0f(%.0f)", value, digits);
    else
        snprintf(words, 48, "%.*f(%.0f)", -last, value, digits);
}

void mcv_exact_words(double value, char words[32]) {
    for (int digits = 6; digits <= 17; ++digits) {
        snprintf(words, 32, "%.*g", digits, value);
        if (strtod(words, NULL) == value) return;
    }
}
