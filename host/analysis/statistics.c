/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/statistics.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* The k-th numerator of the continued fraction 1/(1+ d1/(1+ d2/(1+ …))) of I_x(a, b), DLMF 8.17.22
 * and 8.17.23. */
static double numerator(double a, double b, double x, int k) {
    const int half = k / 2;
    const double m = half;
    if (k % 2 == 0) return m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    return -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
}

/* Converges within about √max(a, b) steps where x < (a + 1)/(a + b + 2). */
static double continued_fraction(double a, double b, double x) {
    enum { MAX_STEPS = 100000 };
    const double tiny =
        DBL_MIN /
        DBL_EPSILON; /* keeps a vanishing denominator away from 0 (Lentz, Thompson and Barnett) */
    double value = 1, c = 1, d = 0;
    for (int k = 1; k <= MAX_STEPS; ++k) {
        const double n = numerator(a, b, x, k);
        d = 1 + n * d;
        c = 1 + n / c;
        if (fabs(d) < tiny) d = tiny;
        if (fabs(c) < tiny) c = tiny;
        d = 1 / d;
        value *= c * d;
        if (fabs(c * d - 1) <= DBL_EPSILON) break;
    }
    return 1 / value;
}

double mcv_incomplete_beta(double a, double b, double x) {
    if (x <= 0) return 0;
    if (x >= 1) return 1;
    const double front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x));
    if (x < (a + 1) / (a + b + 2)) return front * continued_fraction(a, b, x) / a;
    return 1 - front * continued_fraction(b, a, 1 - x) / b;
}

double mcv_student_two_sided(double t, double freedom) {
    const double t2 = t * t;
    if (isinf(t2)) return 0;
    /* The smaller of the two arguments is the one without cancellation. */
    if (t2 < freedom) return 1 - mcv_incomplete_beta(0.5, freedom / 2, t2 / (freedom + t2));
    return mcv_incomplete_beta(freedom / 2, 0.5, freedom / (freedom + t2));
}

double mcv_student_quantile(double p, double freedom) {
    double low = 0, high = 1;
    while (mcv_student_two_sided(high, freedom) > p && high < DBL_MAX / 2) high *= 2;
    /* Halving until neighbouring numbers are reached. */
    for (;;) {
        const double middle = low + (high - low) / 2;
        if (middle <= low || middle >= high) return high;
        if (mcv_student_two_sided(middle, freedom) > p) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

double mcv_binomial_upper(uint64_t successes, uint64_t trials, double p) {
    if (successes == 0) return 1;
    if (successes > trials) return 0;
    return mcv_incomplete_beta((double)successes, (double)(trials - successes + 1), p);
}

double *mcv_mann_whitney(uint32_t nx, uint32_t ny) {
    /* ways[j][u]: orders of i x and j y in which u pairs have x > y. The largest is an x, above all
     * j y, or a y. */
    const size_t pairs = (size_t)nx * ny, stride = pairs + 1;
    double *ways = calloc((ny + 1) * stride, sizeof *ways);
    double *lower = malloc(stride * sizeof *lower);
    if (!ways || !lower) {
        free(ways);
        free(lower);
        return NULL;
    }
    for (size_t j = 0; j <= ny; ++j) ways[j * stride] = 1;
    for (size_t i = 1; i <= nx; ++i) {
        for (size_t j = 1; j <= ny; ++j) {
            double *here = ways + j * stride;
            const double *fewer = here - stride; /* y */
            for (size_t u = stride; u-- > 0;) here[u] = (u >= j ? here[u - j] : 0) + fewer[u];
        }
    }
    const double *all = ways + ny * stride;
    double sum = 0;
    for (size_t u = 0; u < stride; ++u) lower[u] = sum += all[u];
    for (size_t u = 0; u < stride; ++u) lower[u] /= sum;
    free(ways);
    return lower;
}

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double mcv_smaller_than_uniform(double *values, uint64_t count) {
    if (count == 0) return 1;
    qsort(values, count, sizeof *values, compare_doubles);
    double distance = 0;
    for (uint64_t i = 0; i < count; ++i)
        distance = fmax(distance, (double)(i + 1) / (double)count - values[i]);
    return exp(-2 * (double)count * distance * distance);
}

double mcv_sidak(double smallest, double count) { return -expm1(count * log1p(-smallest)); }
