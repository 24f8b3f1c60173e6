/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The discrete Fourier transform of lengths 2^a 3^b 5^c, by Cooley and Tukey's splitting in
 * Stockham's order; error about log2(n) units in the last place. Lines are transformed side by
 * side, so that processors with vectors take several at a time.
 */
#ifndef MCVISI_HOST_ANALYSIS_FFT_H
#define MCVISI_HOST_ANALYSIS_FFT_H

#include "core/error.h"

enum { MCV_FFT_LINES = 8 };

/* The smallest such length >= n. */
size_t mcv_fft_length(size_t n);

/* cos and -sin of 2πk/n, k = 0 … n - 1: 2n numbers; malloc'ed, NULL without memory. */
double *mcv_fft_roots(size_t n);

/*
 * Each line x becomes X[k] = sum over j of x[j] e^(-2πi jk/n), k = 0 … n - 1, with roots from
 * mcv_fft_roots(n). The real part of line l's number k is values[(2 k) MCV_FFT_LINES + l], its
 * imaginary part values[(2 k + 1) MCV_FFT_LINES + l]; `work` is as large as values, and which of
 * both then holds the outcome is returned.
 */
double *mcv_fft(double *values, double *work, size_t n, const double *roots);

#endif
