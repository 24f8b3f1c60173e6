/* SPDX-License-Identifier: Apache-2.0 */
#include "statistics/response_censored.h"

#include "statistics/distributions.h"

#include <math.h>
#include <string.h>

/* ln Φ(z), also far out, where Φ underflows: the asymptotic series. */
static double log_cdf(double z) {
    if (z > -30) return log(mcv_normal_cdf(z));
    return -0.5 * z * z - 0.5 * log(2 * M_PI) - log(-z) + log1p(-1 / (z * z));
}

/* φ(z)/Φ(z), the first derivative of ln Φ. */
static double mills(double z) { return exp(-0.5 * z * z - 0.5 * log(2 * M_PI) - log_cdf(z)); }

/* Olsen's parameters t = (b0, b1, 1)/scatter make residuals r = t2 y - t0 - t1 x linear. */
typedef struct sums {
    double value, slope[3], curvature[3][3];
} sums;

/* Adds a term f of the residual with the derivatives f', f'', along d = dr/dt. */
static void add_term(sums *s, const double d[3], double f, double f1, double f2) {
    s->value += f;
    for (int i = 0; i < 3; ++i) s->slope[i] += f1 * d[i];
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) s->curvature[i][j] += f2 * d[i] * d[j];
}

static sums likelihood(const mcv_response_data *data, const double t[3]) {
    sums s;
    memset(&s, 0, sizeof s);
    for (size_t i = 0; i < data->count; ++i) {
        const bool lost = data->y[i] <= data->low, saturated = data->y[i] >= data->high;
        const double y = lost ? data->low : saturated ? data->high : data->y[i];
        const double d[3] = {-1, -data->x[i], y}, r = t[2] * y - t[0] - t[1] * data->x[i];
        if (lost || saturated) {
            const double side = lost ? 1 : -1, m = mills(side * r);
            add_term(&s, d, log_cdf(side * r), side * m, -m * (m + side * r));
        } else {
            add_term(&s, d, log(t[2]) - 0.5 * log(2 * M_PI) - 0.5 * r * r, -r, -1);
            s.slope[2] += 1 / t[2];
            s.curvature[2][2] -= 1 / (t[2] * t[2]);
        }
    }
    return s;
}

/* Solves a x = b of three unknowns, a positive definite, by Cholesky's decomposition. */
static bool solve(double a[3][3], const double b[3], double x[3]) {
    for (int j = 0; j < 3; ++j) {
        for (int k = 0; k < j; ++k)
            for (int i = j; i < 3; ++i) a[i][j] -= a[i][k] * a[j][k];
        if (!(a[j][j] > 0)) return false;
        const double root = sqrt(a[j][j]);
        for (int i = j; i < 3; ++i) a[i][j] /= root;
    }
    for (int i = 0; i < 3; ++i) {
        x[i] = b[i];
        for (int k = 0; k < i; ++k) x[i] -= a[i][k] * x[k];
        x[i] /= a[i][i];
    }
    for (int i = 2; i >= 0; --i) {
        for (int k = i + 1; k < 3; ++k) x[i] -= a[k][i] * x[k];
        x[i] /= a[i][i];
    }
    return true;
}

/* One of Newton's steps, halved until it climbs. False at the top. */
static bool climb(const mcv_response_data *data, double t[3], sums *s) {
    double minus[3][3], step[3], gain = 0;
    for (int i = 0; i < 9; ++i) minus[i / 3][i % 3] = -s->curvature[i / 3][i % 3];
    if (!solve(minus, s->slope, step)) return false;
    for (int i = 0; i < 3; ++i) gain += step[i] * s->slope[i];
    if (gain < 1e-14) return false;
    for (double share = 1; share > 1e-6; share /= 2) {
        const double next[3] = {t[0] + share * step[0], t[1] + share * step[1],
                                t[2] + share * step[2]};
        if (!(next[2] > 0)) continue;
        const sums there = likelihood(data, next);
        if (!(there.value > s->value)) continue;
        memcpy(t, next, sizeof next);
        *s = there;
        return true;
    }
    return false;
}

bool mcv_response_censored_fit(const mcv_response_data *data, double parameters[3],
                               double *log_likelihood) {
    double t[3] = {parameters[0] / parameters[2], parameters[1] / parameters[2], 1 / parameters[2]};
    sums s = likelihood(data, t);
    int steps = 0;
    while (steps < 200 && climb(data, t, &s)) ++steps;
    parameters[0] = t[0] / t[2];
    parameters[1] = t[1] / t[2];
    parameters[2] = 1 / t[2];
    *log_likelihood = s.value;
    return steps < 200 && isfinite(s.value);
}
