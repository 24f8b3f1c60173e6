/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/fft.h"

#include <math.h>
#include <stdlib.h>

enum { MAX_RADIX = 5 };

static size_t smallest_factor(size_t n) { return n % 4 == 0 ? 4 : n % 2 == 0 ? 2 : n % 3 == 0 ? 3 : n % 5 == 0 ? 5 : n; }

size_t mcv_fft_length(size_t n) {
    for (;; ++n) {
        size_t rest = n;
        for (size_t f = 2; f <= MAX_RADIX; ++f)
            while (rest % f == 0) rest /= f;
        if (rest == 1) return n;
    }
}

mcv_complex *mcv_fft_roots(size_t n) {
    mcv_complex *roots = malloc(n * sizeof *roots);
    for (size_t k = 0; roots && k < n; ++k) {
        const double angle = -2 * M_PI * (double)k / (double)n;
        roots[k] = (mcv_complex){cos(angle), sin(angle)};
    }
    return roots;
}

/* C's own complex product looks out for infinities, at the cost of a call. */
static inline mcv_complex times(mcv_complex a, mcv_complex b) {
    return (mcv_complex){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

/* The transform of every stride-th of in; `all` roots are there. */
static void transform(const mcv_complex *in, size_t stride, mcv_complex *out, size_t n, const mcv_complex *roots, size_t all) {
    if (n == 1) {
        out[0] = in[0];
        return;
    }
    const size_t radix = smallest_factor(n), m = n / radix, step = all / n, turn = all / radix;
    for (size_t q = 0; q < radix; ++q) transform(in + q * stride, stride * radix, out + q * m, m, roots, all);
    for (size_t j = 0; j < m; ++j) {
        mcv_complex t[MAX_RADIX];
        for (size_t q = 0; q < radix; ++q) t[q] = times(out[q * m + j], roots[q * j * step]);
        for (size_t p = 0; p < radix; ++p) {
            mcv_complex sum = t[0];
            for (size_t q = 1; q < radix; ++q) {
                const mcv_complex product = times(t[q], roots[p * q % radix * turn]);
                sum.re += product.re;
                sum.im += product.im;
            }
            out[p * m + j] = sum;
        }
    }
}

void mcv_fft(const mcv_complex *in, mcv_complex *out, size_t n, const mcv_complex *roots) { transform(in, 1, out, n, roots, n); }
