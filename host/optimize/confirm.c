/* SPDX-License-Identifier: Apache-2.0 */
/* The best points once more, with seeds that have not chosen them. */
#include "optimize/search_parts.h"

#include "analysis/statistics.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST = 3, FEWEST_OF_WINNER = 4 }; /* fresh evaluations */

/* --- a point's fresh evaluations --- */

/* Is it an evaluation of this point with a result? */
static bool is_of(const mcv_searching *s, const mcv_evaluation *e, const mcv_confirmed *c,
                  size_t objective) {
    return !isnan(e->results[objective]) &&
           memcmp(e->unit, c->point.unit, s->search->dimensions * sizeof *e->unit) == 0;
}

/* One of the numbers of an evaluation, by their place in it. */
typedef double number_of(const mcv_evaluation *e, size_t k);
static double result_of(const mcv_evaluation *e, size_t k) { return e->results[k]; }
static double error_of(const mcv_evaluation *e, size_t k) { return e->errors[k]; }
static double margin_of(const mcv_evaluation *e, size_t k) { return e->margins[k]; }
static double margin_error_of(const mcv_evaluation *e, size_t k) { return e->margin_errors[k]; }

/* The mean of a number, its standard uncertainty in *u; `objective`: whose evaluations count. */
static double mean_of(const mcv_searching *s, size_t from, bool stated_counts, mcv_confirmed *c,
                      size_t objective, size_t k, number_of *value, number_of *stated_of,
                      double *u) {
    double sum = 0, squares = 0, stated = 0, n = 0;
    for (size_t i = from; i < s->result->count; ++i) {
        const mcv_evaluation *e = s->result->all + i;
        if (!is_of(s, e, c, objective)) continue;
        sum += value(e, k);
        stated += isnan(stated_of(e, k)) ? 0 : stated_of(e, k) * stated_of(e, k);
        ++n;
    }
    const double mean = sum / n;
    for (size_t i = from; i < s->result->count; ++i) {
        const double off = value(s->result->all + i, k) - mean;
        if (is_of(s, s->result->all + i, c, objective)) squares += off * off;
    }
    c->count = (size_t)n;
    *u = stated_counts && stated > 0 ? sqrt(stated) / n
         : n > 1                     ? sqrt(squares / ((n - 1) * n))
                                     : NAN;
    return n > 0 ? mean : NAN;
}

void mcv_search_mean(const mcv_searching *s, size_t from, bool stated_counts, mcv_confirmed *c) {
    for (size_t k = 0; k < s->search->requirements; ++k)
        c->point.margins[k] = mean_of(s, from, stated_counts, c, 0, k, margin_of, margin_error_of,
                                      c->point.margin_errors + k);
    for (size_t k = 0; k < s->search->objectives; ++k)
        c->point.results[k] =
            mean_of(s, from, stated_counts, c, k, k, result_of, error_of, c->point.errors + k);
}

static mcv_result evaluate_again(mcv_searching *s, const mcv_evaluation *point, size_t times,
                                 mcv_error *error) {
    for (size_t i = 0; i < times; ++i)
        MCV_TRY(mcv_search_evaluate(s, point->unit, MCV_STAGE_CONFIRM, s->fresh++, error));
    return MCV_OK;
}

/* --- rivals --- */

static bool is_near(const mcv_searching *s, const double *a, const double *b) {
    double most = 0;
    for (size_t i = 0; i < s->search->dimensions; ++i) most = fmax(most, fabs(a[i] - b[i]));
    return most < 1e-3;
}

/* The smallest value that the search has seen near a point. */
static double seen_near(const mcv_searching *s, const double *unit) {
    double least = INFINITY;
    for (size_t i = 0; i < s->result->count; ++i) {
        const mcv_evaluation *e = s->result->all + i;
        if (is_near(s, e->unit, unit) && e->results[0] < least) least = e->results[0];
    }
    return least;
}

static void add_rival(const mcv_searching *s, const mcv_evaluation *e) {
    mcv_search_result *r = s->result;
    for (size_t i = 0; i < r->point_count; ++i)
        if (is_near(s, r->points[i].point.unit, e->unit)) return;
    r->points[r->point_count++] = (mcv_confirmed){.point = *e, .in_search = seen_near(s, e->unit)};
}

static int by_first(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The best of the polish by its own values, and the best means of the process. */
static mcv_result find_rivals(mcv_searching *s, size_t most, mcv_error *error) {
    mcv_search_result *r = s->result;
    const mcv_evaluation *polished = NULL;
    for (size_t i = 0; i < r->count; ++i) {
        const mcv_evaluation *e = r->all + i;
        if (e->stage == MCV_STAGE_POLISH && !isnan(e->results[0]) &&
            (!polished || e->results[0] < polished->results[0]))
            polished = e;
    }
    if (polished) add_rival(s, polished);
    double chance;
    double(*order)[2] = malloc(r->count * sizeof *order);
    if (!order) return mcv_fail(error, MCV_FAILED, "no memory for rivals");
    size_t count = 0;
    mcv_result result = MCV_OK;
    for (size_t i = 0; i < r->count && result == MCV_OK; ++i) {
        double deviation;
        if (r->all[i].stage == MCV_STAGE_POLISH || isnan(r->all[i].results[0])) continue;
        result = mcv_search_chances(s, r->all[i].unit, 1, &chance, error);
        if (result != MCV_OK || chance < 0.5) continue;
        result = mcv_surrogate_predict(&s->surrogate, r->all[i].unit, 1, order[count], &deviation,
                                       error);
        order[count++][1] = (double)i;
    }
    qsort(order, count, sizeof *order, by_first);
    /* A rival that is worse by more than four times what matters needs no second look. */
    for (size_t i = 0; i < count && r->point_count < most && result == MCV_OK; ++i)
        if (i == 0 || order[i][0] < order[0][0] + 4 * s->better[0])
            add_rival(s, r->all + (size_t)order[i][1]);
    free(order);
    return result;
}

/* --- the choice among rivals --- */

/* Are all requirements met, by the mean of the fresh evaluations? */
static bool is_met(const mcv_searching *s, const mcv_confirmed *c) {
    for (size_t k = 0; k < s->search->requirements; ++k)
        if (!(c->point.margins[k] <= 0)) return false;
    return true;
}

static size_t best_of(const mcv_searching *s) {
    const mcv_search_result *r = s->result;
    size_t best = 0;
    for (size_t i = 1; i < r->point_count; ++i) {
        const bool met = is_met(s, r->points + i), best_met = is_met(s, r->points + best);
        if (met != best_met ? met
                            : !(r->points[best].point.results[0] <= r->points[i].point.results[0]))
            best = i;
    }
    return best;
}

/* To whom the next evaluation goes: shares in proportion to (σ_i/Δ_i)², that of the best
 * σ_b √Σ (n_i/σ_i)². */
static size_t next_of(const mcv_searching *s, size_t best) {
    const mcv_search_result *r = s->result;
    double shares[MCV_SEARCH_RIVALS] = {0}, squares = 0, most = -1;
    size_t next = best;
    for (size_t i = 0; i < r->point_count; ++i) {
        const mcv_confirmed *c = r->points + i;
        const double sigma = c->point.errors[0] * sqrt((double)c->count),
                     behind = fmax(c->point.results[0] - r->points[best].point.results[0],
                                   s->better[0] / 4);
        if (i == best || !(sigma > 0)) continue;
        shares[i] = sigma * sigma / (behind * behind);
        squares += shares[i] * shares[i] / (sigma * sigma);
    }
    shares[best] = r->points[best].point.errors[0] * sqrt((double)r->points[best].count * squares);
    for (size_t i = 0; i < r->point_count; ++i) {
        const double lacking = shares[i] / (double)r->points[i].count;
        if (!(lacking > most)) continue;
        most = lacking;
        next = i;
    }
    return next;
}

static mcv_result compare_rivals(mcv_searching *s, size_t budget, mcv_error *error) {
    mcv_search_result *r = s->result;
    const size_t from = r->count;
    for (size_t i = 0; i < r->point_count && r->point_count > 1; ++i) {
        MCV_TRY(evaluate_again(s, &r->points[i].point, FIRST, error));
        mcv_search_mean(s, from, true, r->points + i);
    }
    while (r->point_count > 1 && r->count - from < budget) {
        const size_t next = next_of(s, best_of(s));
        MCV_TRY(evaluate_again(s, &r->points[next].point, 1, error));
        mcv_search_mean(s, from, true, r->points + next);
    }
    const size_t best = best_of(s);
    const mcv_confirmed first = r->points[0];
    r->points[0] = r->points[best];
    r->points[best] = first;
    return MCV_OK;
}

/* --- the surroundings --- */

/* How far each parameter alone may go until the process's mean is worse by what matters. */
static mcv_result find_surroundings(const mcv_searching *s, mcv_error *error) {
    enum { STEPS = 200 };
    mcv_search_result *r = s->result;
    const mcv_evaluation *winner = &r->winner.point;
    double least, deviation;
    MCV_TRY(mcv_surrogate_predict(&s->surrogate, winner->unit, 1, &least, &deviation, error));
    for (size_t i = 0; i < s->search->dimensions; ++i)
        for (int up = 0; up < 2; ++up) {
            mcv_evaluation at = *winner;
            r->near[i][up] = winner->values[i];
            for (int k = 1; k <= STEPS; ++k) {
                double mean;
                memcpy(at.unit, winner->unit, sizeof at.unit);
                at.unit[i] += (up ? 1.0 : -1.0) * k / STEPS;
                if (at.unit[i] < 0 || at.unit[i] > 1) break;
                if (!mcv_space_place(s->search, at.unit, at.values)) break;
                MCV_TRY(mcv_surrogate_predict(&s->surrogate, at.unit, 1, &mean, &deviation, error));
                if (mean > least + s->better[0]) break;
                r->near[i][up] = at.values[i];
            }
        }
    return MCV_OK;
}

mcv_result mcv_search_confirm(mcv_searching *s, size_t budget, mcv_error *error) {
    mcv_search_result *r = s->result;
    const size_t of_winner = budget / 3 < FEWEST_OF_WINNER ? FEWEST_OF_WINNER : budget / 3,
                 most = (budget - of_winner) / FIRST;
    MCV_TRY(find_rivals(s, most < MCV_SEARCH_RIVALS ? most : MCV_SEARCH_RIVALS, error));
    if (r->point_count == 0)
        return mcv_fail(error, MCV_FAILED,
                        "none of %zu sets seems to meet the requirements: allow more evaluations, "
                        "or require less",
                        r->count);
    MCV_TRY(compare_rivals(s, budget - of_winner, error));
    const size_t from = r->count;
    r->winner = r->points[0];
    MCV_TRY(evaluate_again(s, &r->winner.point, of_winner, error));
    mcv_search_mean(s, from, false, &r->winner);
    if (r->winner.count < 2)
        return mcv_fail(error, MCV_FAILED,
                        "the best point fails with other random numbers: it cannot be confirmed");
    const double half =
        mcv_student_quantile(0.05, (double)r->winner.count - 1) * r->winner.point.errors[0];
    r->low = r->winner.point.results[0] - half;
    r->high = r->winner.point.results[0] + half;
    return find_surroundings(s, error);
}
