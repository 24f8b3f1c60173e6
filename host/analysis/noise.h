/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Random numbers of physical noise. Each (seed, channel, pixel) has a stream of its own,
 * Philox4x32-10 (Salmon, Moraes, Dror and Shaw, Parallel random numbers: as easy as 1, 2, 3, SC
 * 2011): the order in which pixels are treated does not matter.
 */
#ifndef MCVISI_HOST_ANALYSIS_NOISE_H
#define MCVISI_HOST_ANALYSIS_NOISE_H

#include <stdint.h>

typedef struct mcv_noise {
    uint32_t key[2];     /* the seed */
    uint32_t counter[4]; /* pixel (two words), channel, number of the next block */
    uint32_t words[4];   /* the last block */
    int left;            /* of its words */
} mcv_noise;

/* One block: ten rounds on the counter. */
void mcv_philox(const uint32_t counter[4], const uint32_t key[2], uint32_t words[4]);

mcv_noise mcv_noise_begin(uint32_t seed, uint32_t channel, uint64_t pixel);

/* Uniform in (0, 1): the odd multiples of 2^-53. */
double mcv_noise_uniform(mcv_noise *noise);

/* Standard normal: Box and Muller 1958. */
double mcv_noise_normal(mcv_noise *noise);

/*
 * Poisson, exact up to the rounding of doubles, for a mean >= 0: below 10 by inversion, above by
 * transformed rejection (Hörmann, The transformed rejection method for generating Poisson random
 * variables, 1993, algorithm PTRS).
 */
double mcv_noise_poisson(mcv_noise *noise, double mean);

#endif
