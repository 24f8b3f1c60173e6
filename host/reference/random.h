/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Random numbers: SplitMix64 (Steele, Lea and Flood 2014). Each path has its own stream, seeded by
 * pixel, replicate and sample, so that an image depends neither on the number of threads nor on how
 * a sample range is split.
 */
#ifndef MCVISI_HOST_REFERENCE_RANDOM_H
#define MCVISI_HOST_REFERENCE_RANDOM_H

#include <stdint.h>

typedef struct ref_random {
    uint64_t state;
} ref_random;

static inline uint64_t ref_random_bits(ref_random *random) {
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Uniform in [0, 1), a multiple of 2^-53. */
static inline double ref_random_unit(ref_random *random) {
    return (double)(ref_random_bits(random) >> 11) * 0x1p-53;
}

static inline ref_random ref_random_begin(uint32_t seed, uint64_t pixel, uint32_t replicate,
                                          uint64_t sample) {
    ref_random random = {seed};
    random.state = ref_random_bits(&random) ^ pixel;
    random.state = ref_random_bits(&random) ^ replicate;
    random.state = ref_random_bits(&random) ^ sample;
    random.state = ref_random_bits(&random);
    return random;
}

#endif
