/* SPDX-License-Identifier: Apache-2.0 */
/* Several objectives: points of which none is better in all (Pareto's front), with fresh seeds. */
#include "optimize/search_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FEWEST = 2 }; /* fresh evaluations of a point */

/* Means of the process of each objective at all evaluations, [evaluation][objective]. */
static mcv_result find_means(mcv_searching *s, double *means, mcv_error *error) {
    const size_t m = s->search->objectives;
    for (size_t k = 0; k < m; ++k) {
        s->surrogate.count = 0;
        for (size_t i = 0; i < s->result->count; ++i) {
            const mcv_evaluation *e = s->result->all + i;
            if (isnan(e->results[k])) continue;
            MCV_TRY(mcv_surrogate_add(&s->surrogate, e->unit, e->results[k],
                                      isnan(e->errors[k]) ? 0 : e->errors[k] * e->errors[k],
                                      error));
        }
        MCV_TRY(mcv_surrogate_fit(&s->surrogate, true, error));
        for (size_t i = 0; i < s->result->count; ++i) {
            double deviation;
            MCV_TRY(mcv_surrogate_predict(&s->surrogate, s->result->all[i].unit, 1,
                                          means + i * m + k, &deviation, error));
        }
    }
    return MCV_OK;
}

static bool dominates(const double *a, const double *b, size_t count) {
    bool better = false;
    for (size_t i = 0; i < count; ++i) {
        if (a[i] > b[i]) return false;
        better = better || a[i] < b[i];
    }
    return better;
}

/* How far a point is from those that are taken, over the front's ranges: an even front. */
static double gap(const double *means, const double *ranges, size_t count, size_t point,
                  const size_t *taken, size_t taken_count) {
    double least = INFINITY;
    for (size_t i = 0; i < taken_count; ++i) {
        double sum = 0;
        for (size_t k = 0; k < count; ++k) {
            const double off = (means[point * count + k] - means[taken[i] * count + k]) / ranges[k];
            sum += off * off;
        }
        least = fmin(least, sum);
    }
    return least;
}

/* Ends of the front first, then each time the point that is farthest from the others. */
static size_t take_front(const mcv_searching *s, const double *means, size_t most, size_t *taken) {
    const size_t m = s->search->objectives, n = s->result->count;
    double ranges[MCV_SEARCH_OBJECTIVES];
    bool *front = calloc(n, sizeof *front);
    size_t count = 0;
    if (!front) return 0;
    for (size_t i = 0; i < n; ++i) {
        front[i] = !isnan(s->result->all[i].results[0]);
        for (size_t k = 0; k < n && front[i]; ++k)
            front[i] = !dominates(means + k * m, means + i * m, m);
    }
    for (size_t k = 0; k < m; ++k) {
        size_t least = n, largest = n;
        for (size_t i = 0; i < n; ++i) {
            if (!front[i]) continue;
            if (least == n || means[i * m + k] < means[least * m + k]) least = i;
            if (largest == n || means[i * m + k] > means[largest * m + k]) largest = i;
        }
        ranges[k] = least < n ? fmax(means[largest * m + k] - means[least * m + k], 1e-300) : 1;
        bool known = least == n || count == most;
        for (size_t i = 0; i < count; ++i) known = known || taken[i] == least;
        if (!known) taken[count++] = least;
    }
    while (count < most) {
        size_t farthest = n;
        double widest = 1e-6;
        for (size_t i = 0; i < n; ++i) {
            const double apart = front[i] ? gap(means, ranges, m, i, taken, count) : 0;
            if (!(apart > widest)) continue;
            widest = apart;
            farthest = i;
        }
        if (farthest == n) break;
        taken[count++] = farthest;
    }
    free(front);
    return count;
}

mcv_result mcv_search_confirm_front(mcv_searching *s, size_t budget, mcv_error *error) {
    mcv_search_result *r = s->result;
    const size_t m = s->search->objectives;
    size_t taken[MCV_SEARCH_FRONT],
        most = budget / FEWEST < MCV_SEARCH_FRONT ? budget / FEWEST : MCV_SEARCH_FRONT;
    double *means = malloc(r->count * m * sizeof *means);
    if (!means) return mcv_fail(error, MCV_FAILED, "no memory for a front");
    mcv_result result = find_means(s, means, error);
    r->point_count = result == MCV_OK ? take_front(s, means, most, taken) : 0;
    free(means);
    MCV_TRY(result);
    const size_t from = r->count;
    for (size_t i = 0; i < r->point_count; ++i) {
        r->points[i] = (mcv_confirmed){.point = r->all[taken[i]], .in_search = NAN};
        for (size_t k = 0; k < budget / r->point_count; ++k)
            MCV_TRY(mcv_search_evaluate(s, r->points[i].point.unit, MCV_STAGE_CONFIRM, s->fresh++,
                                        error));
        mcv_search_mean(s, from, false, r->points + i);
    }
    return MCV_OK;
}
