/* SPDX-License-Identifier: Apache-2.0 */
/* The box of a search as the unit cube. */
#include "optimize/search_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double lowest(const mcv_levels *l) {
    double low = l->list[0];
    for (size_t i = 1; i < l->count; ++i) low = fmin(low, l->list[i]);
    return low;
}

static double highest(const mcv_levels *l) {
    double high = l->list[0];
    for (size_t i = 1; i < l->count; ++i) high = fmax(high, l->list[i]);
    return high;
}

/* Of a list: the nearest member, and where it lies between the smallest and the largest. */
static double to_list(const mcv_levels *l, double *unit) {
    const double low = lowest(l), range = highest(l) - low;
    double nearest = l->list[0];
    for (size_t i = 1; i < l->count; ++i)
        if (fabs(l->list[i] - low - *unit * range) < fabs(nearest - low - *unit * range))
            nearest = l->list[i];
    *unit = range > 0 ? (nearest - low) / range : 0;
    return nearest;
}

/* Of words, all have the same share of the unit interval. */
static double to_word(const mcv_levels *l, double *unit) {
    const double last = (double)l->count - 1;
    const double place = fmin(last, floor(fmax(0, *unit) * (double)l->count));
    *unit = last > 0 ? place / last : 0;
    return place;
}

static double to_value(const mcv_levels *l, double *unit) {
    char digits[32];
    if (l->named) return to_word(l, unit);
    if (l->list) return to_list(l, unit);
    *unit = fmin(1, fmax(0, *unit));
    const double value = l->logarithmic ? l->from * pow(l->to / l->from, *unit)
                                        : l->from + *unit * (l->to - l->from);
    snprintf(digits, sizeof digits, "%.10g", value);
    return strtod(digits, NULL);
}

bool mcv_space_place(const mcv_search *search, double *unit, double *values) {
    for (size_t i = 0; i < search->dimensions; ++i)
        values[i] = to_value(search->levels + i, unit + i);
    return !search->allowed || search->allowed(search->user, values);
}

mcv_result mcv_space_fill(const mcv_search *search, uint32_t seed, size_t wanted, double *units,
                          size_t *count, mcv_error *error) {
    enum { TRIES = 64 }; /* points for each that is wanted */
    const size_t d = search->dimensions;
    mcv_levels cube[MCV_SURROGATE_PARAMETERS];
    double *points, values[MCV_SURROGATE_PARAMETERS];
    size_t made;
    for (size_t i = 0; i < d; ++i) cube[i] = (mcv_levels){.from = 0, .to = 1};
    MCV_TRY(mcv_design_make(MCV_DESIGN_SOBOL, cube, d, wanted * (search->allowed ? TRIES : 1), seed,
                            &points, &made, error));
    *count = 0;
    for (size_t i = 0; i < made && *count < wanted; ++i)
        if (mcv_space_place(search, points + i * d, values))
            memcpy(units + (*count)++ * d, points + i * d, d * sizeof *units);
    free(points);
    return MCV_OK;
}
