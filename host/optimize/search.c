/* SPDX-License-Identifier: Apache-2.0 */
#include "optimize/search_parts.h"

#include "analysis/noise.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const mcv_search_stages[] = {"screening", "search", "polish", "confirm"};

/* When to stop: the chance that anything better is left. */
static const double enough = 0.05;

mcv_result mcv_search_evaluate(mcv_searching *s, const double *unit, int stage, uint32_t seed,
                               mcv_error *error) {
    mcv_search_result *r = s->result;
    if (r->count == r->room) {
        const size_t room = 2 * r->room + 64;
        mcv_evaluation *more = realloc(r->all, room * sizeof *more);
        if (!more) return mcv_fail(error, MCV_FAILED, "no memory for %zu evaluations", room);
        r->all = more;
        r->room = room;
    }
    mcv_evaluation *e = r->all + r->count;
    *e = (mcv_evaluation){.stage = stage, .seed = seed};
    memcpy(e->unit, unit, s->search->dimensions * sizeof *unit);
    mcv_space_place(s->search, e->unit, e->values);
    MCV_TRY(s->search->evaluate(s->search->user, e, error));
    r->failed += isnan(e->results[0]);
    ++r->count;
    return MCV_OK;
}

/* --- screening --- */

static void find_better(mcv_searching *s) {
    for (size_t i = 0; i < s->search->objectives; ++i) {
        double low = INFINITY, high = -INFINITY;
        for (size_t k = 0; k < s->result->count; ++k) {
            low = fmin(low, s->result->all[k].results[i]);
            high = fmax(high, s->result->all[k].results[i]);
        }
        s->better[i] = s->search->better[i] > 0 ? s->search->better[i] : 0.01 * (high - low);
    }
}

static mcv_result screen(mcv_searching *s, mcv_error *error) {
    const mcv_search *search = s->search;
    const size_t d = search->dimensions;
    const size_t usual = 4 * (d + 1), most = search->budget / 3 > 3 ? search->budget / 3 : 3,
                 wanted = usual < most ? usual : most;
    double *units = malloc(wanted * d * sizeof *units);
    size_t count = 0;
    mcv_result result = units ? mcv_space_fill(search, search->seed, wanted, units, &count, error)
                              : mcv_fail(error, MCV_FAILED, "no memory for a search");
    if (result == MCV_OK && count == 0)
        result =
            mcv_fail(error, MCV_BAD_INPUT,
                     "the constraints allow none of %zu points over the whole range", 64 * wanted);
    for (size_t i = 0; i < count && result == MCV_OK; ++i)
        result = mcv_search_evaluate(s, units + i * d, MCV_STAGE_SCREENING, s->fresh++, error);
    free(units);
    MCV_TRY(result);
    if (s->result->failed == s->result->count)
        return mcv_fail(error, MCV_FAILED, "all %zu evaluations of the screening have failed",
                        count);
    find_better(s);
    return MCV_OK;
}

/* --- search --- */

/* Weights of this step: evenly over the simplex, and now and then one objective alone. */
static void choose_weights(const mcv_searching *s, double *weights) {
    mcv_noise noise = mcv_noise_begin(s->search->seed, 23, s->result->count);
    double sum = 0;
    for (size_t i = 0; i < s->search->objectives; ++i) {
        weights[i] = -log(mcv_noise_uniform(&noise));
        sum += weights[i];
    }
    for (size_t i = 0; i < s->search->objectives; ++i) weights[i] /= sum;
}

/* Lengths are looked for at each new value at first, later at each tenth. */
static bool is_due(size_t count) { return count < 40 || count % (1 + count / 20) == 0; }

static mcv_result step(mcv_searching *s, bool *ended, mcv_error *error) {
    double weights[MCV_SEARCH_OBJECTIVES], unit[MCV_SURROGATE_PARAMETERS], promise, chance;
    const bool several = s->search->objectives > 1;
    if (several) choose_weights(s, weights);
    MCV_TRY(mcv_search_believe(s, several ? weights : NULL, is_due(s->result->count), error));
    MCV_TRY(mcv_search_acquire(s, s->search->seed + (uint32_t)s->result->count, unit, &promise,
                               &chance, error));
    /* Few values make a process too sure: the chance must stay small while it is tried. */
    s->calm = chance < enough || !(promise > 0) ? s->calm + 1 : 0;
    *ended = !several && (s->calm > s->search->dimensions + 3 || !(promise > 0));
    if (*ended) {
        s->result->ended = promise > 0 ? "nothing better by what matters is likely to be left"
                                       : "no point promises an improvement";
        return MCV_OK;
    }
    return mcv_search_evaluate(s, unit, MCV_STAGE_SEARCH, s->fresh++, error);
}

/* What is left for the last stages. Without noise there is little to confirm. */
static size_t confirm_budget(const mcv_searching *s) {
    const size_t share = s->search->budget / 4;
    bool noisy = false;
    for (size_t i = 0; i < s->result->count; ++i)
        for (size_t k = 0; k < s->search->objectives; ++k)
            noisy = noisy || s->result->all[i].errors[k] != 0;
    return !noisy || share < 12 ? 12 : share > 48 ? 48 : share;
}

/* BOBYQA's first model takes 2 n + 1 values. */
static size_t polish_budget(const mcv_search *search) {
    size_t smooth = 0;
    for (size_t i = 0; i < search->dimensions; ++i) smooth += search->levels[i].list == NULL;
    const size_t share = search->budget / 6, least = 2 * smooth + 4;
    /* BOBYQA knows no requirements. */
    return search->objectives > 1 || search->requirements || smooth == 0 ||
                   search->budget / 3 < least
               ? 0
           : share > least ? share
                           : least;
}

/* What is kept for the last stages, from the screening on: noise that shows up later has no room.
 * Small budgets have none for the polish. */
typedef struct last_stages {
    size_t polish, confirm;
} last_stages;

static last_stages plan_last_stages(const mcv_searching *s) {
    last_stages last = {polish_budget(s->search), confirm_budget(s)};
    if (s->result->count + last.polish + last.confirm > s->search->budget) last.polish = 0;
    return last;
}

static mcv_result look(mcv_searching *s, const last_stages *last, mcv_error *error) {
    const size_t kept = last->polish + last->confirm;
    bool ended = false;
    s->result->ended = "the budget was spent";
    while (!ended && s->result->count + kept < s->search->budget) MCV_TRY(step(s, &ended, error));
    return MCV_OK;
}

static mcv_result run(mcv_searching *s, mcv_error *error) {
    const mcv_search *search = s->search;
    MCV_TRY(screen(s, error));
    const last_stages last = plan_last_stages(s);
    MCV_TRY(look(s, &last, error));
    if (search->objectives > 1) return mcv_search_confirm_front(s, last.confirm, error);
    MCV_TRY(mcv_search_polish(s, last.polish, error));
    return mcv_search_confirm(s, last.confirm, error);
}

static void begin_surrogate(const mcv_search *search, mcv_surrogate *s) {
    mcv_surrogate_begin(s, search->dimensions);
    for (size_t i = 0; i < search->dimensions; ++i) s->named[i] = search->levels[i].named;
}

mcv_result mcv_search_run(const mcv_search *search, mcv_search_result *result, mcv_error *error) {
    mcv_searching s = {.search = search, .result = result};
    *result = (mcv_search_result){.ended = ""};
    begin_surrogate(search, &s.surrogate);
    for (size_t k = 0; k < search->requirements; ++k) begin_surrogate(search, s.limits + k);
    const mcv_result done = run(&s, error);
    mcv_surrogate_free(&s.surrogate);
    for (size_t k = 0; k < search->requirements; ++k) mcv_surrogate_free(s.limits + k);
    return done;
}

void mcv_search_free(mcv_search_result *result) {
    free(result->all);
    *result = (mcv_search_result){.ended = ""};
}
