/* SPDX-License-Identifier: Apache-2.0 */
#include "transport/nonnegative.h"

#include <nlopt.h>
#include <stdlib.h>

typedef struct scaled {
    mcv_quadratic *quadratic;
    void *user;
    const double *scale;
    double *at; /* in the quadratic's own unit */
} scaled;

/* In units in which the quadratic is as steep in each number. */
static double evaluate(unsigned count, const double *at, double *slopes, void *user) {
    const scaled *s = user;
    for (unsigned i = 0; i < count; ++i) s->at[i] = s->scale[i] * at[i];
    const double value = s->quadratic(s->user, s->at, slopes);
    for (unsigned i = 0; i < count; ++i) slopes[i] *= s->scale[i];
    return value;
}

mcv_result mcv_minimise_nonnegative(mcv_quadratic *quadratic, void *user, const double *scale,
                                    size_t count, uint32_t most, double *at, mcv_error *error) {
    scaled s = {quadratic, user, scale, malloc((count + 1) * sizeof *s.at)};
    nlopt_opt search = nlopt_create(NLOPT_LD_LBFGS, (unsigned)count);
    double least;
    if (!s.at || !search) {
        free(s.at);
        nlopt_destroy(search);
        return mcv_fail(error, MCV_FAILED, "no memory to fit %zu weights", count);
    }
    nlopt_set_lower_bounds1(search, 0);
    nlopt_set_min_objective(search, evaluate, &s);
    /* Rounding ends the descent before these do. */
    nlopt_set_ftol_rel(search, 1e-15);
    nlopt_set_xtol_rel(search, 1e-12);
    nlopt_set_maxeval(search, (int)most);
    for (size_t i = 0; i < count; ++i) at[i] = scale[i] > 0 ? at[i] / scale[i] : 0;
    /* What it returns is the least so far, also where rounding stops it. */
    nlopt_optimize(search, at, &least);
    for (size_t i = 0; i < count; ++i) at[i] *= scale[i];
    nlopt_destroy(search);
    free(s.at);
    return MCV_OK;
}
