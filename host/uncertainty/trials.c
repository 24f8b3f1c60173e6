/* SPDX-License-Identifier: Apache-2.0 */
/* Monte Carlo: moments and an interval from the trials, and Sobol' indices. */
#include "uncertainty/propagation.h"

#include <math.h>
#include <stdlib.h>

/* Of the normal distribution, two-sided 95 %. */
static const double z95 = 1.959963984540054;

typedef struct trials {
    const mcv_propagation *p;
    const double *points;
    size_t stride, per, count; /* count: trials without a failed point */
    size_t *whole;             /* their numbers */
    size_t drawn;              /* points of a trial that are draws: A, and B */
} trials;

static double value(const trials *t, size_t trial, size_t point) {
    return t->points[(t->whole[trial] * t->per + point) * t->stride];
}

static double noise(const trials *t, size_t trial, size_t point) {
    const double u = t->points[(t->whole[trial] * t->per + point) * t->stride + 1];
    return isnan(u) ? 0 : u * u;
}

/* Mean over the trials, and the standard uncertainty of that mean. */
typedef struct moments {
    double sum, squares, first;
    size_t count;
} moments;

static void add(moments *m, double x) {
    if (m->count++ == 0) m->first = x; /* about the first one: a mean far from 0 loses no digits */
    m->sum += x - m->first;
    m->squares += (x - m->first) * (x - m->first);
}

static double mean_of(const moments *m) { return m->first + m->sum / (double)m->count; }

static double error_of(const moments *m) {
    const double n = (double)m->count;
    return sqrt(fmax(0, m->squares - m->sum * m->sum / n) / (n * (n - 1)));
}

/* The share of a trial in the variance of the parameters. */
static double variance_at(const trials *t, double mean, size_t trial) {
    const double n = (double)(t->count * t->drawn);
    double sum = 0;
    for (size_t k = 0; k < t->drawn; ++k) {
        const double off = value(t, trial, k) - mean;
        sum += off * off * n / (n - 1) - noise(t, trial, k);
    }
    return sum / (double)t->drawn;
}

/* On a logarithmic scale, where the estimate of a variance is nearly normal; linear where it is
 * not clearly above 0. */
static mcv_bounded bound_deviation(double variance, double error) {
    const double half = z95 * error;
    if (variance > 2 * half)
        return (mcv_bounded){sqrt(variance), sqrt(variance * exp(-half / variance)),
                             sqrt(variance * exp(half / variance))};
    return (mcv_bounded){sqrt(fmax(0, variance)), sqrt(fmax(0, variance - half)),
                         sqrt(fmax(0, variance + half))};
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The value below which a share of all values lies: on average exactly, for any distribution
 * (Weibull's plotting position). */
static double quantile(const double *sorted, size_t count, double share) {
    const double place = share * (double)(count + 1) - 1;
    const double kept = fmin(fmax(place, 0), (double)(count - 1));
    const size_t below = (size_t)kept;
    if (below + 1 >= count) return sorted[count - 1];
    return sorted[below] + (kept - (double)below) * (sorted[below + 1] - sorted[below]);
}

/* Values are moved towards their mean until they spread as they would without the renders' noise;
 * as they would at most, where that spread is not resolved. */
static mcv_result find_interval(const trials *t, double spread, mcv_propagated *found,
                                mcv_error *error) {
    const size_t count = t->count * t->drawn;
    double *sorted = malloc(count * sizeof *sorted);
    if (!sorted) return mcv_fail(error, MCV_FAILED, "no memory for %zu trials", count);
    const mcv_bounded *d = &found->deviation;
    const double scale = spread > 0 ? (d->low > 0 ? d->value : d->high) / spread : 0;
    for (size_t i = 0; i < count; ++i)
        sorted[i] = found->mean + scale * (value(t, i / t->drawn, i % t->drawn) - found->mean);
    qsort(sorted, count, sizeof *sorted, compare);
    found->low = quantile(sorted, count, 0.025);
    found->high = quantile(sorted, count, 0.975);
    free(sorted);
    return MCV_OK;
}

/* A ratio of two means over the trials: its uncertainty is that of the mean of numerator - ratio
 * denominator. */
static mcv_bounded ratio(const trials *t, size_t parameter, bool total, double mean,
                         double variance) {
    moments top = {0}, rest = {0};
    double share = NAN;
    for (int pass = 0; pass < 2; ++pass) {
        for (size_t i = 0; i < t->count; ++i) {
            const double a = value(t, i, 0), b = value(t, i, 1), c = value(t, i, 2 + parameter);
            const double part =
                total ? ((a - c) * (a - c) - noise(t, i, 0) - noise(t, i, 2 + parameter)) / 2
                      : (b - mean) * (c - a);
            add(pass ? &rest : &top, pass ? part - share * variance_at(t, mean, i) : part);
        }
        share = mean_of(&top) / variance;
    }
    const double half = z95 * error_of(&rest) / variance;
    return (mcv_bounded){share, share - half, share + half};
}

static mcv_result find_moments(const trials *t, mcv_propagated *found, mcv_error *error) {
    moments means = {0}, variances = {0}, noises = {0};
    for (size_t i = 0; i < t->count; ++i)
        for (size_t k = 0; k < t->drawn; ++k) {
            add(&means, value(t, i, k));
            add(&noises, noise(t, i, k));
        }
    found->mean = mean_of(&means);
    found->mean_error = error_of(&means);
    found->noise = sqrt(mean_of(&noises));
    for (size_t i = 0; i < t->count; ++i) add(&variances, variance_at(t, found->mean, i));
    const double variance = mean_of(&variances);
    found->deviation = bound_deviation(variance, error_of(&variances));
    for (size_t i = 0; i < t->p->tolerances->count && t->p->indices && variance > 0; ++i) {
        found->effects[i].first = ratio(t, i, false, found->mean, variance);
        found->effects[i].total = ratio(t, i, true, found->mean, variance);
    }
    return find_interval(t, sqrt(fmax(0, variance) + mean_of(&noises)), found, error);
}

mcv_result mcv_propagate_trials(const mcv_propagation *p, const double *points, size_t stride,
                                mcv_propagated *found, mcv_error *error) {
    trials t = {.p = p,
                .points = points,
                .stride = stride,
                .per = mcv_propagation_trial(p),
                .drawn = p->indices ? 2 : 1};
    t.whole = malloc(p->trials * sizeof *t.whole);
    if (!t.whole) return mcv_fail(error, MCV_FAILED, "no memory for %zu trials", p->trials);
    for (size_t i = 0; i < p->trials; ++i) {
        bool failed = false;
        for (size_t k = 0; k < t.per; ++k)
            failed = failed || isnan(points[(i * t.per + k) * stride]);
        if (!failed) t.whole[t.count++] = i;
    }
    found->trials = t.count;
    const mcv_result result = t.count > 2 ? find_moments(&t, found, error) : MCV_OK;
    free(t.whole);
    return result;
}
