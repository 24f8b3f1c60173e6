/* SPDX-License-Identifier: Apache-2.0 */
/* The lengths and the variance of a process: the largest posterior density, by L-BFGS. */
#include "optimize/surrogate_parts.h"

#include <lapacke.h>
#include <math.h>
#include <nlopt.h>
#include <string.h>

/* The priors: medians and deviations of the logarithms of lengths and of s². */
static const double usual_length = -0.7, usual_variance = 0.0, width_of_length = 1.0,
                    width_of_variance = 1.5;

void mcv_surrogate_usual(const mcv_surrogate *s, double *logarithms) {
    for (size_t i = 0; i < s->dimensions; ++i) logarithms[i] = usual_length;
    logarithms[s->dimensions] = usual_variance;
}

typedef struct fitting {
    mcv_surrogate *s;
    double *k, *unit, *weights;
} fitting;

static double prior(const mcv_surrogate *s, double *slopes) {
    double sum = 0;
    for (size_t i = 0; i <= s->dimensions; ++i) {
        const bool length = i < s->dimensions;
        const double width = length ? width_of_length : width_of_variance,
                     off = (s->logarithms[i] - (length ? usual_length : usual_variance)) / width;
        sum += off * off / 2;
        if (slopes) slopes[i] += off / width;
    }
    return sum;
}

/* Slopes of the likelihood's negative logarithm: ½ tr((K⁻¹ - ααᵀ) dK). k becomes K⁻¹. */
static void find_slopes(const fitting *f, double *slopes) {
    const mcv_surrogate *s = f->s;
    const size_t n = s->count, d = s->dimensions;
    const double variance = s->variance;
    LAPACKE_dtrtrs(LAPACK_ROW_MAJOR, 'L', 'T', 'N', (lapack_int)n, 1, f->k, (lapack_int)n,
                   f->weights, 1); /* α */
    LAPACKE_dpotri(LAPACK_ROW_MAJOR, 'L', (lapack_int)n, f->k, (lapack_int)n);
    for (size_t i = 0; i <= d; ++i) slopes[i] = 0;
    for (size_t i = 0; i < n; ++i) {
        slopes[d] += (f->k[i * n + i] - f->weights[i] * f->weights[i]) * variance / 2;
        for (size_t j = 0; j < i; ++j) {
            const double *a = s->points + i * d, *b = s->points + j * d;
            const double with = f->k[i * n + j] - f->weights[i] * f->weights[j],
                         r = mcv_surrogate_distance(s, a, b), e = variance * exp(-r);
            slopes[d] += with * e * (1 + r + r * r / 3);
            for (size_t p = 0; p < d; ++p) {
                const double off = mcv_surrogate_off(s, a, b, p);
                slopes[p] += with * e * 5.0 / 3 * (1 + r) * off * off;
            }
        }
    }
}

static double misfit(unsigned count, const double *logarithms, double *slopes, void *user) {
    const fitting *f = user;
    mcv_surrogate *s = f->s;
    double sum = 0;
    mcv_surrogate_set(s, logarithms);
    mcv_surrogate_fill(s, f->k);
    if (!mcv_surrogate_solve(s, f->k, f->unit, f->weights)) {
        for (unsigned i = 0; slopes && i < count; ++i) slopes[i] = 0;
        return HUGE_VAL;
    }
    for (size_t i = 0; i < s->count; ++i)
        sum += f->weights[i] * f->weights[i] / 2 + log(f->k[i * s->count + i]);
    if (slopes) find_slopes(f, slopes);
    return sum + prior(s, slopes);
}

/* From the last lengths and from the usual ones; the better result. */
void mcv_surrogate_search(mcv_surrogate *s) {
    fitting f = {s, s->factor, s->unit, s->weights};
    const unsigned count = (unsigned)s->dimensions + 1;
    double best[MCV_SURROGATE_PARAMETERS + 1], least = HUGE_VAL;
    double starts[2][MCV_SURROGATE_PARAMETERS + 1], low[MCV_SURROGATE_PARAMETERS + 1],
        high[MCV_SURROGATE_PARAMETERS + 1];
    mcv_surrogate_usual(s, starts[1]);
    for (unsigned i = 0; i < count; ++i) {
        const bool length = i + 1 < count;
        starts[0][i] = best[i] = s->logarithms[i];
        low[i] = length ? -3.5 : -6;
        high[i] = length ? 2.5 : 7;
    }
    for (int k = 0; k < 2; ++k) {
        double value = HUGE_VAL;
        nlopt_opt search = nlopt_create(NLOPT_LD_LBFGS, count);
        if (!search) break;
        nlopt_set_lower_bounds(search, low);
        nlopt_set_upper_bounds(search, high);
        nlopt_set_min_objective(search, misfit, &f);
        nlopt_set_maxeval(search, 40);
        nlopt_set_ftol_abs(search, 1e-3);
        const nlopt_result result = nlopt_optimize(search, starts[k], &value);
        nlopt_destroy(search);
        if ((result > 0 || result == NLOPT_ROUNDOFF_LIMITED || result == NLOPT_FAILURE) &&
            value < least) {
            least = value;
            memcpy(best, starts[k], count * sizeof *best);
        }
    }
    mcv_surrogate_set(s, best);
}
