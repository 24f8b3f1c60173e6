/* SPDX-License-Identifier: Apache-2.0 */
#include "uncertainty/propagation.h"

#include "analysis/noise.h"

#include <math.h>
#include <string.h>

/* Enough sign vectors that each two parameters have equal signs in one and different signs in
 * another: all +, and a digit of each parameter's number. */
size_t mcv_propagation_signs(const mcv_propagation *p) {
    size_t signs = p->tolerances->count > 1;
    while (signs && (size_t)1 << (signs - 1) < p->tolerances->count) ++signs;
    return signs;
}

size_t mcv_propagation_repeat(const mcv_propagation *p) {
    return 1 + 2 * p->tolerances->count + 2 * mcv_propagation_signs(p);
}

size_t mcv_propagation_trial(const mcv_propagation *p) {
    return p->indices ? 2 + p->tolerances->count : 1;
}

size_t mcv_propagation_points(const mcv_propagation *p) {
    return p->repeats * mcv_propagation_repeat(p) + p->trials * mcv_propagation_trial(p);
}

static void point_of_repeat(const mcv_tolerances *t, size_t at, double *values) {
    const size_t step = at - 1;
    for (size_t i = 0; i < t->count; ++i) values[i] = t->of[i].centre;
    if (at == 0) return;
    const double sign = step % 2 ? -1 : 1;
    const size_t which = step / 2;
    for (size_t i = 0; i < t->count; ++i) {
        const double own = which < t->count                    ? which == i
                           : which == t->count                 ? 1
                           : (i >> (which - t->count - 1) & 1) ? -1
                                                               : 1;
        values[i] += sign * own * mcv_distribution_deviation(t->of + i);
    }
}

static void draw(const mcv_tolerances *t, uint32_t seed, uint32_t matrix, size_t trial,
                 double *values) {
    double scores[MCV_DESIGN_PARAMETERS];
    mcv_noise noise = mcv_noise_begin(seed, matrix, trial);
    for (size_t i = 0; i < t->count; ++i) scores[i] = mcv_noise_normal(&noise);
    mcv_tolerances_draw(t, scores, values);
}

void mcv_propagation_point(const mcv_propagation *p, size_t point, uint32_t seed, double *values,
                           uint32_t *offset) {
    enum { MATRIX_A = 2, MATRIX_B }; /* streams of random numbers; designs have 0 and 1 */
    const mcv_tolerances *t = p->tolerances;
    const size_t repeat = mcv_propagation_repeat(p), trial = mcv_propagation_trial(p);
    if (point < p->repeats * repeat) {
        *offset = (uint32_t)(point / repeat);
        point_of_repeat(t, point % repeat, values);
        return;
    }
    point -= p->repeats * repeat;
    *offset = (uint32_t)(p->repeats + point);
    const size_t number = point / trial, at = point % trial;
    draw(t, seed, at == 1 ? MATRIX_B : MATRIX_A, number, values);
    if (at < 2) return;
    double other[MCV_DESIGN_PARAMETERS];
    draw(t, seed, MATRIX_B, number, other);
    values[at - 2] = other[at - 2];
}

/* By the first order's effects, or else by the total indices; a selection sort of few. */
static void rank(const mcv_tolerances *t, mcv_propagated *found) {
    double weight[MCV_DESIGN_PARAMETERS];
    for (size_t i = 0; i < t->count; ++i) {
        const mcv_effect *e = found->effects + i;
        weight[i] = isnan(e->effect) ? e->total.value : fabs(e->effect);
        found->order[i] = i;
    }
    for (size_t i = 0; i < t->count; ++i)
        for (size_t k = i + 1; k < t->count; ++k)
            if (weight[found->order[k]] > weight[found->order[i]]) {
                const size_t kept = found->order[i];
                found->order[i] = found->order[k];
                found->order[k] = kept;
            }
}

mcv_result mcv_propagate(const mcv_propagation *p, const double *points, size_t stride,
                         mcv_propagated *found, mcv_error *error) {
    const mcv_bounded none = {NAN, NAN, NAN};
    *found = (mcv_propagated){.nominal = NAN,
                              .nominal_error = NAN,
                              .linear = none,
                              .mean = NAN,
                              .mean_error = NAN,
                              .deviation = none,
                              .noise = NAN,
                              .low = NAN,
                              .high = NAN};
    for (size_t i = 0; i < p->tolerances->count; ++i)
        found->effects[i] = (mcv_effect){.effect = NAN,
                                         .effect_error = NAN,
                                         .curvature = NAN,
                                         .curvature_error = NAN,
                                         .share = NAN,
                                         .first = none,
                                         .total = none};
    if (p->repeats) MCV_TRY(mcv_propagate_first_order(p, points, stride, found, error));
    if (p->trials)
        MCV_TRY(mcv_propagate_trials(p, points + p->repeats * mcv_propagation_repeat(p) * stride,
                                     stride, found, error));
    for (size_t i = 0; i < p->tolerances->count; ++i)
        found->nonlinear = found->nonlinear || found->effects[i].curved;
    /* The intervals of both deviations: JCGM 101:2008, 8 validates one by the other. */
    found->nonlinear = found->nonlinear || found->interacts ||
                       found->linear.high < found->deviation.low ||
                       found->linear.low > found->deviation.high;
    rank(p->tolerances, found);
    return MCV_OK;
}
