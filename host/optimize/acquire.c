/* SPDX-License-Identifier: Apache-2.0 */
/* Where to look next: the augmented expected improvement, and the chance of any. */
#include "optimize/search_parts.h"

#include "analysis/noise.h"

#include <math.h>
#include <nlopt.h>
#include <stdlib.h>
#include <string.h>

enum {
    SPREAD = 1024, /* candidates over the whole box */
    NEAR = 256,    /* about the best */
    STARTS = 3,    /* of the search between candidates */
    JOINT = 128,   /* candidates that are drawn together, */
    DRAWS = 256    /* so often */
};

/* --- expected improvement --- */

typedef struct improving {
    mcv_searching *s;
    double best;  /* mean of the process at the best point */
    double noise; /* standard uncertainty of a usual evaluation */
    bool meets; /* that point meets the requirements; else the chance to do so is all that counts */
} improving;

static double improvement(const improving *i, double mean, double deviation, double chance) {
    if (!i->meets) return chance;
    if (!(deviation > 0)) return 0;
    const double z = (i->best - mean) / deviation,
                 expected = (i->best - mean) * erfc(-z / M_SQRT2) / 2 +
                            deviation * exp(-z * z / 2) / sqrt(2 * M_PI);
    return chance * fmax(0, expected) * (1 - i->noise / hypot(i->noise, deviation));
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double usual_noise(const mcv_surrogate *s) {
    double *sorted = malloc(s->count * sizeof *sorted);
    if (!sorted) return 0;
    memcpy(sorted, s->variances, s->count * sizeof *sorted);
    qsort(sorted, s->count, sizeof *sorted, compare);
    const double median = sqrt(sorted[s->count / 2]);
    free(sorted);
    return median;
}

/* --- candidates --- */

typedef struct candidates {
    size_t count;
    double *units, *means, *deviations, *promises;
    double *chances; /* to meet the requirements */
} candidates;

static void free_candidates(candidates *c) {
    free(c->units);
    free(c->means);
    free(c->deviations);
    free(c->promises);
    free(c->chances);
}

/* The chance that a step takes another word. */
static const double OTHER_WORD = 0.25;

/* About a point, in steps of a share of each length, from a hundredth up. */
static void step_from(const mcv_searching *s, const double *from, mcv_noise *noise, double *unit) {
    const size_t d = s->search->dimensions;
    const double size = pow(10, -2 * mcv_noise_uniform(noise));
    for (size_t i = 0; i < d; ++i) {
        if (s->search->levels[i].named) {
            const bool other = mcv_noise_uniform(noise) < OTHER_WORD;
            unit[i] = other ? mcv_noise_uniform(noise) : from[i];
            continue;
        }
        const double length = fmin(1, exp(s->surrogate.logarithms[i]));
        unit[i] = fmin(1, fmax(0, from[i] + size * length * mcv_noise_normal(noise)));
    }
}

static mcv_result make_candidates(mcv_searching *s, uint32_t seed, const double *best,
                                  candidates *c, mcv_error *error) {
    const size_t d = s->search->dimensions, most = SPREAD + NEAR + s->surrogate.count;
    double values[MCV_SURROGATE_PARAMETERS];
    mcv_noise noise = mcv_noise_begin(seed, 21, 0);
    *c = (candidates){.units = malloc(most * d * sizeof(double)),
                      .means = malloc(most * sizeof(double)),
                      .deviations = malloc(most * sizeof(double)),
                      .promises = malloc(most * sizeof(double)),
                      .chances = malloc(most * sizeof(double))};
    if (!c->units || !c->means || !c->deviations || !c->promises || !c->chances)
        return mcv_fail(error, MCV_FAILED, "no memory for a search");
    MCV_TRY(mcv_space_fill(s->search, seed, SPREAD, c->units, &c->count, error));
    for (size_t i = 0; i < NEAR; ++i) {
        double *unit = c->units + c->count * d;
        step_from(s, best, &noise, unit);
        c->count += mcv_space_place(s->search, unit, values);
    }
    /* Once more what was seen: a mean of two values may tell more than a new point. */
    memcpy(c->units + c->count * d, s->surrogate.points, s->surrogate.count * d * sizeof *c->units);
    c->count += s->surrogate.count;
    MCV_TRY(mcv_search_chances(s, c->units, c->count, c->chances, error));
    return mcv_surrogate_predict(&s->surrogate, c->units, c->count, c->means, c->deviations, error);
}

// NOLINTNEXTLINE(readability-non-const-parameter): as NLopt has it
static double promise_at(unsigned count, const double *unit, double *slopes, void *user) {
    improving *i = user;
    double placed[MCV_SURROGATE_PARAMETERS], values[MCV_SURROGATE_PARAMETERS], mean, deviation,
        chance;
    mcv_error ignored;
    (void)slopes;
    memcpy(placed, unit, count * sizeof *placed);
    if (!mcv_space_place(i->s->search, placed, values) ||
        mcv_surrogate_predict(&i->s->surrogate, placed, 1, &mean, &deviation, &ignored) != MCV_OK ||
        mcv_search_chances(i->s, placed, 1, &chance, &ignored) != MCV_OK)
        return 0;
    return improvement(i, mean, deviation, chance);
}

/* Between the candidates; the result is placed. */
static double refine(improving *i, double *unit, double promise) {
    const unsigned d = (unsigned)i->s->search->dimensions;
    double at[MCV_SURROGATE_PARAMETERS], values[MCV_SURROGATE_PARAMETERS], found = promise;
    nlopt_opt search = nlopt_create(NLOPT_LN_SBPLX, d);
    if (!search) return promise;
    memcpy(at, unit, d * sizeof *at);
    nlopt_set_lower_bounds1(search, 0);
    nlopt_set_upper_bounds1(search, 1);
    nlopt_set_max_objective(search, promise_at, i);
    nlopt_set_initial_step1(search, 0.02);
    nlopt_set_xtol_abs1(search, 1e-4);
    nlopt_set_maxeval(search, 20 * (int)d);
    const nlopt_result result = nlopt_optimize(search, at, &found);
    nlopt_destroy(search);
    if (result < 0 || !(found > promise) || !mcv_space_place(i->s->search, at, values))
        return promise;
    memcpy(unit, at, d * sizeof *unit);
    return found;
}

/* --- the chance that something better is left --- */

/* Below this chance to meet the requirements a point is no hope. */
static const double least_chance = 0.05;

/* The best point, then the candidates whose mean less two deviations is smallest: *count of them,
 * JOINT + 1 at most. */
static void take_hopes(const mcv_searching *s, const candidates *c, const double *best,
                       double *hopes, double *points, size_t *count) {
    const size_t d = s->search->dimensions;
    for (size_t i = 0; i < c->count; ++i)
        hopes[i] = c->chances[i] < least_chance ? INFINITY : c->means[i] - 2 * c->deviations[i];
    double *sorted = hopes + c->count;
    memcpy(sorted, hopes, c->count * sizeof *sorted);
    qsort(sorted, c->count, sizeof *sorted, compare);
    const double limit = sorted[c->count > JOINT ? JOINT - 1 : c->count - 1];
    memcpy(points, best, d * sizeof *points);
    *count = 1;
    for (size_t i = 0; i < c->count && *count <= JOINT; ++i)
        if (hopes[i] <= limit && isfinite(hopes[i]))
            memcpy(points + (*count)++ * d, c->units + i * d, d * sizeof *points);
}

/* Of joint draws, those in which a candidate is better than the best. */
static mcv_result find_chance(const mcv_searching *s, const candidates *c, const double *best,
                              uint32_t seed, double *chance, mcv_error *error) {
    double *points = malloc((JOINT + 1) * s->search->dimensions * sizeof *points),
           *draws = malloc((size_t)(JOINT + 1) * DRAWS * sizeof *draws),
           *hopes = malloc(2 * c->count * sizeof *hopes);
    mcv_result result = MCV_OK;
    size_t count = 0, hits = 0;
    if (points && draws && hopes) {
        mcv_noise noise = mcv_noise_begin(seed, 22, 0);
        take_hopes(s, c, best, hopes, points, &count);
        for (size_t i = 0; i < count * DRAWS; ++i) draws[i] = mcv_noise_normal(&noise);
        result = mcv_surrogate_draw(&s->surrogate, points, count, DRAWS, draws, error);
    } else {
        result = mcv_fail(error, MCV_FAILED, "no memory for a search");
    }
    for (size_t draw = 0; draw < DRAWS && result == MCV_OK; ++draw) {
        const double *row = draws + draw * count;
        bool better = false;
        for (size_t i = 1; i < count; ++i) better = better || row[i] < row[0] - s->better[0];
        hits += better;
    }
    *chance = (double)hits / DRAWS;
    free(points);
    free(draws);
    free(hopes);
    return result;
}

static mcv_result choose(improving *i, candidates *c, const double *best, uint32_t seed,
                         double *unit, double *promise, double *chance, mcv_error *error) {
    const size_t d = i->s->search->dimensions;
    for (size_t k = 0; k < c->count; ++k)
        c->promises[k] = improvement(i, c->means[k], c->deviations[k], c->chances[k]);
    *promise = -1;
    for (int start = 0; start < STARTS; ++start) {
        size_t most = 0;
        for (size_t k = 1; k < c->count; ++k)
            if (c->promises[k] > c->promises[most]) most = k;
        double at[MCV_SURROGATE_PARAMETERS] = {0};
        memcpy(at, c->units + most * d, d * sizeof *at);
        const double found = refine(i, at, c->promises[most]);
        if (found > *promise) {
            *promise = found;
            memcpy(unit, at, d * sizeof *unit);
        }
        c->promises[most] = -1;
    }
    *chance = 1;
    /* The draws cost more than the improvement, which is small before the chance is. */
    if (i->s->search->objectives > 1 || !i->meets || *promise > i->s->better[0]) return MCV_OK;
    return find_chance(i->s, c, best, seed, chance, error);
}

mcv_result mcv_search_acquire(mcv_searching *s, uint32_t seed, double *unit, double *promise,
                              double *chance, mcv_error *error) {
    double best[MCV_SURROGATE_PARAMETERS];
    improving i = {.s = s, .noise = usual_noise(&s->surrogate)};
    candidates c;
    MCV_TRY(mcv_search_best(s, true, best, &i.best, &i.meets, error));
    mcv_result result = make_candidates(s, seed, best, &c, error);
    if (result == MCV_OK) result = choose(&i, &c, best, seed, unit, promise, chance, error);
    free_candidates(&c);
    return result;
}
