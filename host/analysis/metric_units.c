/* SPDX-License-Identifier: Apache-2.0 */
/* The units of figures by name. */
#include "analysis/metrics.h"

#include <ctype.h>
#include <string.h>

static const char *figure_unit(const char *figure, size_t length, mcv_metric_units units) {
    const struct {
        const char *name, *unit;
    } figures[] = {
#define MCV_X(member, name, unit) {name, unit},
        MCV_REGION_METRICS(MCV_X) MCV_CONTRAST_METRICS(MCV_X) MCV_EDGE_METRICS(MCV_X)
            MCV_LINE_METRICS(MCV_X) MCV_CALIPER_METRICS(MCV_X) MCV_CIRCLE_METRICS(MCV_X)
#undef MCV_X
                {"mtf50", "cycles/pixel"},
        {"bound", units.step},
        {"distance", "pixels"},
        {"line_distance", "pixels"},
    };
    static const char in_metres[] = "length";
    const size_t ending = sizeof in_metres - 1;
    if (length >= ending && strncmp(figure + length - ending, in_metres, ending) == 0) return "m";
    for (size_t i = 0; i < sizeof figures / sizeof figures[0]; ++i)
        if (strlen(figures[i].name) == length && strncmp(figures[i].name, figure, length) == 0)
            return strcmp(figures[i].unit, MCV_UNIT_OF_VALUES) == 0 ? units.values
                                                                    : figures[i].unit;
    return "";
}

const char *mcv_metric_unit(const char *expression, mcv_metric_units units) {
    size_t length = strlen(expression);
    const bool wrapped =
        length > 3 && strncmp(expression, "u(", 2) == 0 && expression[length - 1] == ')';
    if (wrapped) {
        expression += 2;
        length -= 3;
    }
    size_t begin = length;
    for (size_t i = 0; i < length; ++i)
        if (!isalnum((unsigned char)expression[i]) && !strchr("._", expression[i])) return "";
    while (begin > 0 && expression[begin - 1] != '.') --begin;
    return figure_unit(expression + begin, length - begin, units);
}
