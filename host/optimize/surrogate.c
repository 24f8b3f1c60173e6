/* SPDX-License-Identifier: Apache-2.0 */
#include "optimize/surrogate_parts.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of s²: keeps the factorisation of equal points possible. It grows where that fails. */
static const double least_nugget = 1e-8, largest_nugget = 1e-2;

static mcv_result fail_memory(mcv_error *error) {
    return mcv_fail(error, MCV_FAILED, "no memory for a Gaussian process");
}

void mcv_surrogate_begin(mcv_surrogate *s, size_t dimensions) {
    *s = (mcv_surrogate){.dimensions = dimensions, .scale = 1};
    mcv_surrogate_usual(s, s->logarithms);
}

static void free_fit(mcv_surrogate *s) {
    free(s->factor);
    free(s->weights);
    free(s->unit);
    s->factor = s->weights = s->unit = NULL;
    s->fitted = 0;
}

void mcv_surrogate_free(mcv_surrogate *s) {
    free_fit(s);
    free(s->points);
    free(s->values);
    free(s->variances);
    *s = (mcv_surrogate){.dimensions = 0};
}

static bool grow(double **numbers, size_t count) {
    double *more = realloc(*numbers, count * sizeof *more);
    if (more) *numbers = more;
    return more;
}

mcv_result mcv_surrogate_add(mcv_surrogate *s, const double *point, double value, double variance,
                             mcv_error *error) {
    if (s->count == s->room) {
        const size_t room = 2 * s->room + 16;
        if (!grow(&s->points, room * s->dimensions) || !grow(&s->values, room) ||
            !grow(&s->variances, room))
            return fail_memory(error);
        s->room = room;
    }
    memcpy(s->points + s->count * s->dimensions, point, s->dimensions * sizeof *point);
    s->values[s->count] = value;
    s->variances[s->count++] = variance;
    return MCV_OK;
}

/* --- covariance --- */

double mcv_surrogate_off(const mcv_surrogate *s, const double *a, const double *b, size_t i) {
    return (s->named[i] ? (double)(a[i] != b[i]) : a[i] - b[i]) * s->inverse[i];
}

double mcv_surrogate_distance(const mcv_surrogate *s, const double *a, const double *b) {
    double sum = 0;
    for (size_t i = 0; i < s->dimensions; ++i) {
        const double off = mcv_surrogate_off(s, a, b, i);
        sum += off * off;
    }
    return sqrt(5 * sum);
}

static double covariance(const mcv_surrogate *s, const double *a, const double *b) {
    const double r = mcv_surrogate_distance(s, a, b);
    return s->variance * (1 + r + r * r / 3) * exp(-r);
}

void mcv_surrogate_set(mcv_surrogate *s, const double *logarithms) {
    memmove(s->logarithms, logarithms, (s->dimensions + 1) * sizeof *logarithms);
    for (size_t i = 0; i < s->dimensions; ++i) s->inverse[i] = exp(-logarithms[i]);
    s->variance = exp(logarithms[s->dimensions]);
}

/* The lower half of the covariance of all values, in units of scale². */
void mcv_surrogate_fill(const mcv_surrogate *s, double *k) {
    const size_t n = s->count;
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; j < i; ++j)
            k[i * n + j] =
                covariance(s, s->points + i * s->dimensions, s->points + j * s->dimensions);
        k[i * n + i] = s->variance * (1 + s->nugget) + s->variances[i] / (s->scale * s->scale);
    }
}

static void standardise(mcv_surrogate *s) {
    double sum = 0, squares = 0;
    for (size_t i = 0; i < s->count; ++i) sum += s->values[i];
    s->shift = sum / (double)s->count;
    for (size_t i = 0; i < s->count; ++i)
        squares += (s->values[i] - s->shift) * (s->values[i] - s->shift);
    s->scale = sqrt(squares / (double)s->count);
    if (!(s->scale > 0)) s->scale = 1;
}

/* Factors k, and finds the constant mean by generalised least squares. */
bool mcv_surrogate_solve(mcv_surrogate *s, double *k, double *unit, double *weights) {
    const lapack_int n = (lapack_int)s->count;
    if (LAPACKE_dpotrf(LAPACK_ROW_MAJOR, 'L', n, k, n) != 0) return false;
    for (size_t i = 0; i < s->count; ++i) {
        unit[i] = 1;
        weights[i] = (s->values[i] - s->shift) / s->scale;
    }
    LAPACKE_dtrtrs(LAPACK_ROW_MAJOR, 'L', 'N', 'N', n, 1, k, n, unit, 1);
    LAPACKE_dtrtrs(LAPACK_ROW_MAJOR, 'L', 'N', 'N', n, 1, k, n, weights, 1);
    double own = 0, both = 0;
    for (size_t i = 0; i < s->count; ++i) {
        own += unit[i] * unit[i];
        both += unit[i] * weights[i];
    }
    s->mean = both / own;
    s->mean_variance = 1 / own;
    for (size_t i = 0; i < s->count; ++i) weights[i] -= s->mean * unit[i];
    return true;
}

mcv_result mcv_surrogate_fit(mcv_surrogate *s, bool search, mcv_error *error) {
    const size_t n = s->count;
    free_fit(s);
    s->factor = malloc(n * n * sizeof *s->factor);
    s->weights = malloc(n * sizeof *s->weights);
    s->unit = malloc(n * sizeof *s->unit);
    if (!s->factor || !s->weights || !s->unit) return fail_memory(error);
    standardise(s);
    mcv_surrogate_set(s, s->logarithms);
    s->nugget = least_nugget;
    if (search && n > 2) mcv_surrogate_search(s);
    for (; s->nugget <= largest_nugget; s->nugget *= 100) {
        mcv_surrogate_fill(s, s->factor);
        if (!mcv_surrogate_solve(s, s->factor, s->unit, s->weights)) continue;
        s->fitted = n;
        return MCV_OK;
    }
    return mcv_fail(error, MCV_FAILED, "the Gaussian process cannot be factored");
}

/* --- prediction --- */

/* [fitted][count]: factor⁻¹ times the covariances of the values with the points. */
static double *whiten(const mcv_surrogate *s, const double *points, size_t count) {
    double *v = malloc(s->fitted * count * sizeof *v);
    if (!v) return NULL;
    for (size_t i = 0; i < s->fitted; ++i)
        for (size_t k = 0; k < count; ++k)
            v[i * count + k] =
                covariance(s, s->points + i * s->dimensions, points + k * s->dimensions);
    LAPACKE_dtrtrs(LAPACK_ROW_MAJOR, 'L', 'N', 'N', (lapack_int)s->fitted, (lapack_int)count,
                   s->factor, (lapack_int)s->fitted, v, (lapack_int)count);
    return v;
}

/* 1 - 1ᵀ K⁻¹ k of a point: the part of the mean's own error that it has. */
static double lack(const mcv_surrogate *s, const double *v, size_t count, size_t point) {
    double sum = 1;
    for (size_t i = 0; i < s->fitted; ++i) sum -= s->unit[i] * v[i * count + point];
    return sum;
}

static double mean_at(const mcv_surrogate *s, const double *v, size_t count, size_t point) {
    double sum = s->mean;
    for (size_t i = 0; i < s->fitted; ++i) sum += s->weights[i] * v[i * count + point];
    return s->shift + s->scale * sum;
}

mcv_result mcv_surrogate_predict(const mcv_surrogate *s, const double *points, size_t count,
                                 double *means, double *deviations, mcv_error *error) {
    double *v = whiten(s, points, count);
    if (!v) return fail_memory(error);
    for (size_t k = 0; k < count; ++k) {
        const double missing = lack(s, v, count, k);
        double variance = s->variance + missing * missing * s->mean_variance;
        for (size_t i = 0; i < s->fitted; ++i) variance -= v[i * count + k] * v[i * count + k];
        means[k] = mean_at(s, v, count, k);
        deviations[k] = s->scale * sqrt(fmax(0, variance));
    }
    free(v);
    return MCV_OK;
}

/* The covariance of the objective at the points, given the values. */
static void fill_joint(const mcv_surrogate *s, const double *points, const double *v, size_t count,
                       double *joint) {
    for (size_t a = 0; a < count; ++a)
        for (size_t b = 0; b <= a; ++b) {
            double sum = covariance(s, points + a * s->dimensions, points + b * s->dimensions) +
                         lack(s, v, count, a) * lack(s, v, count, b) * s->mean_variance;
            for (size_t i = 0; i < s->fitted; ++i) sum -= v[i * count + a] * v[i * count + b];
            joint[a * count + b] = sum;
        }
}

mcv_result mcv_surrogate_draw(const mcv_surrogate *s, const double *points, size_t count,
                              size_t draws, double *normals, mcv_error *error) {
    double *v = whiten(s, points, count), *joint = malloc(count * count * sizeof *joint);
    if (!v || !joint) {
        free(v);
        free(joint);
        return fail_memory(error);
    }
    double ridge = 1e-10 * s->variance;
    do {
        fill_joint(s, points, v, count, joint);
        for (size_t a = 0; a < count; ++a) joint[a * count + a] += ridge;
        ridge *= 100;
    } while (LAPACKE_dpotrf(LAPACK_ROW_MAJOR, 'L', (lapack_int)count, joint, (lapack_int)count) !=
                 0 &&
             ridge < 1e6);
    for (size_t draw = 0; draw < draws; ++draw) {
        double *out = normals + draw * count;
        for (size_t k = count; k-- > 0;) {
            double sum = 0;
            for (size_t i = 0; i <= k; ++i) sum += joint[k * count + i] * out[i];
            out[k] = mean_at(s, v, count, k) + s->scale * sum;
        }
    }
    free(v);
    free(joint);
    return MCV_OK;
}
