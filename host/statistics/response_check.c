/* SPDX-License-Identifier: Apache-2.0 */
/* Tests of what a response assumes (statistics/response.h). */
#include "analysis/statistics.h"
#include "statistics/distributions.h"
#include "statistics/response.h"

#include <math.h>
#include <stdlib.h>

/* Sum of products of what lines through x leave of two lists. */
static double partial(const double *x, const double *a, const double *b, size_t count) {
    double n = (double)count, mx = 0, ma = 0, mb = 0, xx = 0, xa = 0, xb = 0, ab = 0;
    for (size_t i = 0; i < count; ++i) {
        mx += x[i] / n;
        ma += a[i] / n;
        mb += b[i] / n;
    }
    for (size_t i = 0; i < count; ++i) {
        xx += (x[i] - mx) * (x[i] - mx);
        xa += (x[i] - mx) * (a[i] - ma);
        xb += (x[i] - mx) * (b[i] - mb);
        ab += (a[i] - ma) * (b[i] - mb);
    }
    return ab - xa * xb / xx;
}

static double check_linear(const double *x, const double *r, double *work, size_t count) {
    double mean = 0;
    for (size_t i = 0; i < count; ++i) mean += x[i] / (double)count;
    for (size_t i = 0; i < count; ++i) work[i] = (x[i] - mean) * (x[i] - mean);
    const double ww = partial(x, work, work, count), rw = partial(x, r, work, count);
    const double rr = partial(x, r, r, count), left = (double)count - 3;
    /* Two sizes only: no parabola. */
    if (!(ww > 0)) return NAN;
    const double t2 = rw * rw / ww / ((rr - rw * rw / ww) / left);
    return mcv_student_two_sided(sqrt(t2), left);
}

static double check_even(const double *x, const double *r, double *work, size_t count) {
    const double n = (double)count;
    double mx = 0, mw = 0, xx = 0, xw = 0, ww = 0;
    for (size_t i = 0; i < count; ++i) {
        work[i] = r[i] * r[i];
        mx += x[i] / n;
        mw += work[i] / n;
    }
    for (size_t i = 0; i < count; ++i) {
        xx += (x[i] - mx) * (x[i] - mx);
        xw += (x[i] - mx) * (work[i] - mw);
        ww += (work[i] - mw) * (work[i] - mw);
    }
    return erfc(sqrt(0.5 * n * xw * xw / (xx * ww))); /* χ² of one degree of freedom */
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The statistic's p-value where mean and deviation are estimated. */
static double anderson_p(double a2, double n) {
    const double a = a2 * (1 + 0.75 / n + 2.25 / (n * n));
    if (a < 0.2) return 1 - exp(-13.436 + 101.14 * a - 223.73 * a * a);
    if (a < 0.34) return 1 - exp(-8.318 + 42.796 * a - 59.938 * a * a);
    if (a < 0.6) return exp(0.9177 - 4.279 * a - 1.38 * a * a);
    return fmin(1, exp(1.2937 - 5.709 * a + 0.0186 * a * a));
}

static double check_normal(const double *r, double *work, size_t count) {
    const double n = (double)count;
    double mean = 0, squares = 0, sum = 0;
    for (size_t i = 0; i < count; ++i) mean += r[i] / n;
    for (size_t i = 0; i < count; ++i) squares += (r[i] - mean) * (r[i] - mean);
    for (size_t i = 0; i < count; ++i) work[i] = (r[i] - mean) / sqrt(squares / (n - 1));
    qsort(work, count, sizeof *work, compare);
    for (size_t i = 0; i < count; ++i)
        sum += (2 * (double)i + 1) *
               (log(mcv_normal_cdf(work[i])) + log(mcv_normal_cdf(-work[count - 1 - i])));
    return anderson_p(-n - sum / n, n);
}

mcv_result mcv_response_check(const mcv_response *fit, mcv_response_checks *checks,
                              mcv_error *error) {
    const mcv_response_data *d = &fit->data;
    size_t count = 0;
    double *memory = malloc(3 * d->count * sizeof *memory);
    if (!memory) return mcv_fail(error, MCV_FAILED, "no memory for the checks");
    double *x = memory, *r = memory + d->count, *work = memory + 2 * d->count;
    for (size_t i = 0; i < d->count; ++i) {
        if (d->y[i] <= d->low || d->y[i] >= d->high) continue;
        x[count] = d->x[i];
        r[count++] = d->y[i] - fit->intercept - fit->slope * d->x[i];
    }
    checks->linear = check_linear(x, r, work, count);
    checks->even = check_even(x, r, work, count);
    checks->normal = check_normal(r, work, count);
    free(memory);
    return MCV_OK;
}
