/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Stands for LAPACKE in the wheel. Debian's would bring LAPACK, BLAS and the libraries of Fortran,
 * 13 MB, for what the search and correlated tolerances use: decompositions of matrices of some
 * hundred rows. Here are these three functions alone, for lower triangles by rows, unit 'N'.
 */
#include <math.h>

enum { ROW_MAJOR = 101 };

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
