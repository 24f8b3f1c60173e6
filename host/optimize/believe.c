/* SPDX-License-Identifier: Apache-2.0 */
/* What the process believes: of one objective, or of a weighted norm of several. */
#include "optimize/search_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static double worst_of(const mcv_search_result *r, size_t objective) {
    double worst = -INFINITY;
    for (size_t i = 0; i < r->count; ++i)
        if (r->all[i].results[objective] > worst) worst = r->all[i].results[objective];
    return worst;
}

static double range_of(const mcv_search_result *r, size_t objective) {
    double least = INFINITY;
    for (size_t i = 0; i < r->count; ++i)
        if (r->all[i].results[objective] < least) least = r->all[i].results[objective];
    return fmax(worst_of(r, objective) - least, 1e-300);
}

/* The augmented Chebyshev norm of weighted objectives, each over its range; its variance is that
 * of the objective that counts. A failed evaluation counts as the worst that was seen. */
static double weigh(const mcv_searching *s, const mcv_evaluation *e, const double *weights,
                    double *variance) {
    const size_t count = s->search->objectives;
    double most = -INFINITY, sum = 0, squares = 0;
    *variance = 0;
    for (size_t i = 0; i < count; ++i) {
        const double range = weights ? range_of(s->result, i) : 1,
                     weight = weights ? weights[i] : 1;
        const bool failed = isnan(e->results[i]);
        const double value = weight * (failed ? worst_of(s->result, i) : e->results[i]) / range,
                     error = failed ? 0.1 * weight * range_of(s->result, i) / range
                                    : weight * (isnan(e->errors[i]) ? 0 : e->errors[i]) / range;
        if (value > most) *variance = error * error;
        most = fmax(most, value);
        sum += 0.05 * value;
        squares += 0.0025 * error * error;
    }
    if (!weights) return most;
    *variance += squares;
    return most + sum;
}

mcv_result mcv_search_believe(mcv_searching *s, const double *weights, bool lengths,
                              mcv_error *error) {
    s->surrogate.count = 0;
    for (size_t i = 0; i < s->result->count; ++i) {
        const mcv_evaluation *e = s->result->all + i;
        double variance;
        /* Evaluations of the polish share their noise: they are no news to the process. */
        if (e->stage == MCV_STAGE_POLISH) continue;
        const double value = weigh(s, e, weights, &variance);
        MCV_TRY(mcv_surrogate_add(&s->surrogate, e->unit, value, variance, error));
    }
    MCV_TRY(mcv_surrogate_fit(&s->surrogate, lengths, error));
    return mcv_search_believe_margins(s, lengths, error);
}

/* The place of the best: the smallest value of those with even odds, else the best chance. */
static size_t find_best(const double *values, const double *chances, size_t count, bool *meets) {
    size_t best = 0;
    *meets = false;
    for (size_t i = 0; i < count; ++i) {
        const bool own = chances[i] >= 0.5;
        const bool better = own && *meets ? values[i] < values[best]
                                          : !*meets && (own || chances[i] > chances[best]);
        if (better) best = i;
        *meets = *meets || own;
    }
    return best;
}

mcv_result mcv_search_best(const mcv_searching *s, bool cautious, double *unit, double *mean,
                           bool *meets, mcv_error *error) {
    const size_t n = s->surrogate.count, d = s->surrogate.dimensions;
    double *means = malloc(4 * n * sizeof *means);
    if (!means) return mcv_fail(error, MCV_FAILED, "no memory for a search");
    double *values = means + 2 * n, *chances = means + 3 * n;
    mcv_result result =
        mcv_surrogate_predict(&s->surrogate, s->surrogate.points, n, means, means + n, error);
    if (result == MCV_OK) result = mcv_search_chances(s, s->surrogate.points, n, chances, error);
    if (result == MCV_OK) {
        for (size_t i = 0; i < n; ++i) values[i] = means[i] + (cautious ? means[n + i] : 0);
        const size_t best = find_best(values, chances, n, meets);
        memcpy(unit, s->surrogate.points + best * d, d * sizeof *unit);
        *mean = means[best];
    }
    free(means);
    return result;
}
