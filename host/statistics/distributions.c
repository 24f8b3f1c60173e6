/* SPDX-License-Identifier: Apache-2.0 */
#include "statistics/distributions.h"

#include <math.h>

double mcv_normal_cdf(double z) { return 0.5 * erfc(-z * M_SQRT1_2); }

/* Newton's steps for ln P, which is concave: from below they reach every p without a turn. */
double mcv_normal_quantile(double p) {
    if (!(p > 0 && p < 1)) return p == 0 ? -INFINITY : p == 1 ? INFINITY : NAN;
    if (p > 0.5) return -mcv_normal_quantile(1 - p);
    double z = -sqrt(-2 * log(p)); /* below the quantile: P(Z <= -t) < exp(-t²/2) turned around */
    for (int i = 0; i < 100; ++i) {
        const double cdf = mcv_normal_cdf(z);
        const double density = exp(-0.5 * z * z) / sqrt(2 * M_PI);
        const double step = cdf / density * log(p / cdf);
        z += step;
        if (fabs(step) <= 1e-15 * (1 + fabs(z))) break;
    }
    return z;
}

double mcv_noncentral_t_cdf(double t, double freedom, double noncentrality) {
    enum { STEPS = 200 };
    /* S has the mean 1 and the deviation 1/√(2 freedom), nearly; beyond 12 of these no mass. */
    const double spread = 12 / sqrt(2 * freedom);
    const double from = fmax(0, 1 - spread), to = 1 + spread, step = (to - from) / STEPS;
    const double front = log(2.0) + 0.5 * freedom * log(0.5 * freedom) - lgamma(0.5 * freedom);
    double sum = 0;
    for (int i = 1; i <= STEPS; ++i) {
        const double s = from + i * step;
        const double density = exp(front + (freedom - 1) * log(s) - 0.5 * freedom * s * s);
        sum += density * mcv_normal_cdf(t * s - noncentrality);
    }
    return fmin(1, sum * step);
}
