/* SPDX-License-Identifier: Apache-2.0 */
/* The discrete Fourier transform of lengths 2^a 3^b 5^c, by Cooley and Tukey's splitting; error about log2(n) units in the last place. */
#ifndef MCVISI_HOST_ANALYSIS_FFT_H
#define MCVISI_HOST_ANALYSIS_FFT_H

#include "mcvisi/mcvisi.h"

typedef struct mcv_complex {
    double re, im;
} mcv_complex;

/* The smallest such length >= n. */
size_t mcv_fft_length(size_t n);

/* out[k] = sum over j of in[j] e^(-2πi jk/n), k = 0 … n - 1; roots from mcv_fft_roots(n). in and out are apart. */
void mcv_fft(const mcv_complex *in, mcv_complex *out, size_t n, const mcv_complex *roots);

/* e^(-2πi k/n), k = 0 … n - 1; malloc'ed, NULL without memory. */
mcv_complex *mcv_fft_roots(size_t n);

#endif
