/* SPDX-License-Identifier: Apache-2.0 */
/* BOBYQA about the best point (Powell, The BOBYQA algorithm for bound constrained optimization
 * without derivatives, 2009). All its evaluations have one seed, so that their differences are
 * less noisy; their values are those of one noise, and never the result. */
#include "optimize/search_parts.h"

#include <math.h>
#include <nlopt.h>
#include <string.h>

typedef struct polishing {
    mcv_searching *s;
    nlopt_opt search;
    uint32_t seed;
    double start[MCV_SURROGATE_PARAMETERS];       /* lists stay as there */
    size_t axes[MCV_SURROGATE_PARAMETERS], count; /* which parameters are polished */
    mcv_result result;
    mcv_error *error;
} polishing;

static double worst(const mcv_search_result *r) {
    double most = -INFINITY;
    for (size_t i = 0; i < r->count; ++i)
        if (r->all[i].results[0] > most) most = r->all[i].results[0];
    return most;
}

// NOLINTNEXTLINE(readability-non-const-parameter): as NLopt has it
static double evaluate(unsigned count, const double *at, double *slopes, void *user) {
    polishing *p = user;
    double unit[MCV_SURROGATE_PARAMETERS], values[MCV_SURROGATE_PARAMETERS];
    (void)slopes;
    memcpy(unit, p->start, sizeof unit);
    for (unsigned i = 0; i < count; ++i) unit[p->axes[i]] = at[i];
    if (!mcv_space_place(p->s->search, unit, values)) return worst(p->s->result);
    p->result = mcv_search_evaluate(p->s, unit, MCV_STAGE_POLISH, p->seed, p->error);
    if (p->result != MCV_OK) {
        nlopt_force_stop(p->search);
        return worst(p->s->result);
    }
    const double found = p->s->result->all[p->s->result->count - 1].results[0];
    return isnan(found) ? worst(p->s->result) : found;
}

mcv_result mcv_search_polish(mcv_searching *s, size_t budget, mcv_error *error) {
    polishing p = {.s = s, .seed = s->fresh++, .result = MCV_OK, .error = error};
    double at[MCV_SURROGATE_PARAMETERS], steps[MCV_SURROGATE_PARAMETERS], mean, least, noise;
    bool meets;
    MCV_TRY(mcv_search_believe(s, NULL, true, error));
    MCV_TRY(mcv_search_best(s, false, p.start, &mean, &meets, error));
    for (size_t i = 0; i < s->search->dimensions; ++i) {
        if (s->search->levels[i].list) continue;
        p.axes[p.count] = i;
        at[p.count] = p.start[i];
        steps[p.count++] = fmin(0.1, 0.2 * exp(s->surrogate.logarithms[i]));
    }
    if (p.count == 0 || budget == 0) return MCV_OK;
    noise = s->result->all[s->result->count - 1].errors[0];
    p.search = nlopt_create(NLOPT_LN_BOBYQA, (unsigned)p.count);
    if (!p.search) return mcv_fail(error, MCV_FAILED, "no memory to polish");
    nlopt_set_lower_bounds1(p.search, 0);
    nlopt_set_upper_bounds1(p.search, 1);
    nlopt_set_min_objective(p.search, evaluate, &p);
    nlopt_set_initial_step(p.search, steps);
    nlopt_set_xtol_abs1(p.search, 1e-4);
    nlopt_set_ftol_abs(p.search, fmax(0.01 * s->better[0], isnan(noise) ? 0 : 0.1 * noise));
    nlopt_set_maxeval(p.search, (int)budget);
    nlopt_optimize(p.search, at, &least);
    nlopt_destroy(p.search);
    return p.result;
}
