/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/fft.h"

#include <math.h>
#include <stdlib.h>

enum { MAX_RADIX = 5, LINES = MCV_FFT_LINES };

static size_t next_radix(size_t n) { return n % 4 == 0 ? 4 : n % 2 == 0 ? 2 : n % 3 == 0 ? 3 : 5; }

size_t mcv_fft_length(size_t n) {
    for (;; ++n) {
        size_t rest = n;
        for (size_t f = 2; f <= MAX_RADIX; ++f)
            while (rest % f == 0) rest /= f;
        if (rest == 1) return n;
    }
}

double *mcv_fft_roots(size_t n) {
    double *roots = malloc(2 * n * sizeof *roots);
    for (size_t k = 0; roots && k < n; ++k) {
        const double angle = -2 * M_PI * (double)k / (double)n;
        roots[2 * k] = cos(angle);
        roots[2 * k + 1] = sin(angle);
    }
    return roots;
}

/* One complex number of each line. */
typedef struct numbers {
    double re[LINES], im[LINES];
} numbers;

/* to = from turned by the root. */
static inline void turn(const numbers *from, double re, double im, numbers *to) {
    for (int l = 0; l < LINES; ++l) {
        to->re[l] = from->re[l] * re - from->im[l] * im;
        to->im[l] = from->re[l] * im + from->im[l] * re;
    }
}

static inline void combine(const numbers *a, double sign, const numbers *b, numbers *to) {
    for (int l = 0; l < LINES; ++l) {
        to->re[l] = a->re[l] + sign * b->re[l];
        to->im[l] = a->im[l] + sign * b->im[l];
    }
}

/* to = a + sign i b */
static inline void combine_turned(const numbers *a, double sign, const numbers *b, numbers *to) {
    for (int l = 0; l < LINES; ++l) {
        to->re[l] = a->re[l] - sign * b->im[l];
        to->im[l] = a->im[l] + sign * b->re[l];
    }
}

static inline void transform_2(const numbers *x, numbers *y) {
    combine(x, 1, x + 1, y);
    combine(x, -1, x + 1, y + 1);
}

static inline void transform_4(const numbers *x, numbers *y) {
    numbers even, odd, even_off, odd_off;
    combine(x, 1, x + 2, &even);
    combine(x, -1, x + 2, &even_off);
    combine(x + 1, 1, x + 3, &odd);
    combine(x + 1, -1, x + 3, &odd_off);
    combine(&even, 1, &odd, y);
    combine_turned(&even_off, -1, &odd_off, y + 1);
    combine(&even, -1, &odd, y + 2);
    combine_turned(&even_off, 1, &odd_off, y + 3);
}

/* By the sum itself; root: how far apart the roots of this radix lie among all n. */
static inline void transform_sum(const numbers *x, numbers *y, size_t radix, const double *roots,
                                 size_t root) {
    for (size_t t = 0; t < radix; ++t) {
        y[t] = x[0];
        for (size_t k = 1; k < radix; ++k) {
            numbers turned;
            turn(x + k, roots[2 * (t * k % radix) * root], roots[2 * (t * k % radix) * root + 1],
                 &turned);
            combine(y + t, 1, &turned, y + t);
        }
    }
}

/*
 * One splitting: of `stride` interleaved transforms of `length` numbers into radix times as many,
 * which come out in order (Stockham, in Van Loan, Computational Frameworks for the Fast Fourier
 * Transform, 1.7).
 */
static void split(const numbers *from, numbers *to, size_t length, size_t stride, size_t radix,
                  const double *roots, size_t n) {
    const size_t m = length / radix, step = n / length;
    numbers x[MAX_RADIX], y[MAX_RADIX];
    for (size_t q = 0; q < m; ++q)
        for (size_t j = 0; j < stride; ++j) {
            for (size_t k = 0; k < radix; ++k) x[k] = from[j + stride * (q + m * k)];
            if (radix == 4)
                transform_4(x, y);
            else if (radix == 2)
                transform_2(x, y);
            else
                transform_sum(x, y, radix, roots, n / radix);
            to[j + stride * radix * q] = y[0];
            for (size_t t = 1; t < radix; ++t)
                turn(y + t, roots[2 * q * t * step], roots[2 * q * t * step + 1],
                     to + j + stride * (radix * q + t));
        }
}

double *mcv_fft(double *values, double *work, size_t n, const double *roots) {
    for (size_t length = n, stride = 1; length > 1;) {
        const size_t radix = next_radix(length);
        double *swap = values;
        /* The compiler makes one of each. */
        if (radix == 4)
            split((const numbers *)values, (numbers *)work, length, stride, 4, roots, n);
        else if (radix == 2)
            split((const numbers *)values, (numbers *)work, length, stride, 2, roots, n);
        else
            split((const numbers *)values, (numbers *)work, length, stride, radix, roots, n);
        values = work;
        work = swap;
        length /= radix;
        stride *= radix;
    }
    return values;
}
