/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stands for LAPACKE in the wheel. Debian's would bring LAPACK, BLAS and the libraries of Fortran,
 * 13 MB, for what the search, correlated tolerances and calibrations use: decompositions of
 * matrices of some hundred rows. Here are these functions alone: the first three for lower
 * triangles by rows, unit 'N'; dsyev for upper triangles by columns, with vectors.
 */
#include <math.h>
#include <stdlib.h>

enum { ROW_MAJOR = 101, COLUMN_MAJOR = 102, SWEEPS = 64 };

static int is_ours(int layout, char triangle) { return layout == ROW_MAJOR && triangle == 'L'; }

static double product(int n, const double *x, const double *y) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += x[i] * y[i];
    return sum;
}

int LAPACKE_dpotrf(int layout, char triangle, int n, double *a, int stride);
int LAPACKE_dtrtrs(int layout, char triangle, char transposed, char unit, int n, int count,
                   const double *a, int stride, double *b, int stride_b);
int LAPACKE_dpotri(int layout, char triangle, int n, double *a, int stride);
int LAPACKE_dsyev(int layout, char vectors, char triangle, int n, double *a, int stride,
                  double *values);

/* A = L Lᵀ. i: the leading minor of i rows is not positive. */
int LAPACKE_dpotrf(int layout, char triangle, int n, double *a, int stride) {
    if (!is_ours(layout, triangle)) return -1;
    for (int i = 0; i < n; ++i) {
        double *row = a + (long)i * stride;
        for (int j = 0; j < i; ++j) {
            const double *other = a + (long)j * stride;
            row[j] = (row[j] - product(j, row, other)) / other[j];
        }
        const double square = row[i] - product(i, row, row);
        if (!(square > 0)) return i + 1;
        row[i] = sqrt(square);
    }
    return 0;
}

/* One row of b less the multiple of another. */
static void subtract(int count, double factor, const double *from, double *row) {
    for (int k = 0; k < count; ++k) row[k] -= factor * from[k];
}

/* Solves L x = b, or Lᵀ x = b, for each column of b. i: the diagonal is 0 in row i. */
int LAPACKE_dtrtrs(int layout, char triangle, char transposed, char unit, int n, int count,
                   const double *a, int stride, double *b, int stride_b) {
    if (!is_ours(layout, triangle) || unit != 'N') return -1;
    for (int i = 0; i < n; ++i)
        if (a[(long)i * stride + i] == 0) return i + 1;
    for (int step = 0; step < n; ++step) {
        const int i = transposed == 'N' ? step : n - 1 - step;
        const int from = transposed == 'N' ? 0 : i + 1, to = transposed == 'N' ? i : n;
        double *row = b + (long)i * stride_b;
        for (int j = from; j < to; ++j)
            subtract(count, transposed == 'N' ? a[(long)i * stride + j] : a[(long)j * stride + i],
                     b + (long)j * stride_b, row);
        for (int k = 0; k < count; ++k) row[k] /= a[(long)i * stride + i];
    }
    return 0;
}

/* L becomes the lower triangle of the inverse of L Lᵀ: W = L⁻¹ first, then WᵀW. What a row needs
 * lies in it or below. */
int LAPACKE_dpotri(int layout, char triangle, int n, double *a, int stride) {
    if (!is_ours(layout, triangle)) return -1;
    for (int i = 0; i < n; ++i) {
        double *row = a + (long)i * stride;
        if (row[i] == 0) return i + 1;
        for (int j = 0; j < i; ++j) {
            double sum = 0;
            for (int k = j; k < i; ++k) sum += row[k] * a[(long)k * stride + j];
            row[j] = -sum / row[i];
        }
        row[i] = 1 / row[i];
    }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j) {
            double sum = 0;
            for (int k = i; k < n; ++k) sum += a[(long)k * stride + i] * a[(long)k * stride + j];
            a[(long)i * stride + j] = sum;
        }
    return 0;
}

/* Jacobi's rotation in the plane of rows p and q of the symmetric s, which makes s[p][q] 0; the
 * columns of v turn with it. */
static void rotate(int n, double *s, double *v, int p, int q) {
    const double angle = 0.5 * atan2(2 * s[p * n + q], s[q * n + q] - s[p * n + p]);
    const double c = cos(angle), t = sin(angle);
    for (int k = 0; k < n; ++k) {
        const double a = s[p * n + k], b = s[q * n + k];
        s[p * n + k] = c * a - t * b;
        s[q * n + k] = t * a + c * b;
    }
    for (int k = 0; k < n; ++k) {
        const double a = s[k * n + p], b = s[k * n + q], x = v[k * n + p], y = v[k * n + q];
        s[k * n + p] = c * a - t * b;
        s[k * n + q] = t * a + c * b;
        v[k * n + p] = c * x - t * y;
        v[k * n + q] = t * x + c * y;
    }
}

/* The sum of the squares beside the diagonal. */
static double rest(int n, const double *s) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += product(i, s + (long)i * n, s + (long)i * n);
    return sum;
}

/* The values ascend; column k of a, and so n numbers from k * stride on, is the vector of value k.
 * 1: there are none, as of numbers that are not finite. */
int LAPACKE_dsyev(int layout, char vectors, char triangle, int n, double *a, int stride,
                  double *values) {
    if (layout != COLUMN_MAJOR || vectors != 'V' || triangle != 'U') return -1;
    double *s = calloc(2 * (size_t)n * (size_t)n + 1, sizeof *s), *v = s + (size_t)n * (size_t)n;
    if (!s) return -1010; /* LAPACK_WORK_MEMORY_ERROR */
    for (int i = 0; i < n; ++i) {
        v[i * n + i] = 1;
        for (int j = 0; j <= i; ++j) s[i * n + j] = s[j * n + i] = a[(long)i * stride + j];
    }
    /* Squares vanish beside those of the diagonal; each sweep squares what is left. */
    double left = INFINITY;
    for (int sweep = 0; sweep < SWEEPS && rest(n, s) < left; ++sweep) {
        left = rest(n, s);
        for (int p = 0; p < n; ++p)
            for (int q = p + 1; q < n; ++q) rotate(n, s, v, p, q);
    }
    int failed = 0;
    for (int k = 0; k < n; ++k) {
        int least = -1;
        for (int i = 0; i < n; ++i)
            if (!isnan(s[i * n + i]) && (least < 0 || s[i * n + i] < s[least * n + least]))
                least = i;
        if (least < 0) {
            failed = 1;
            break;
        }
        values[k] = s[least * n + least];
        for (int j = 0; j < n; ++j) a[(long)k * stride + j] = v[j * n + least];
        s[least * n + least] = NAN;
    }
    free(s);
    return failed;
}
