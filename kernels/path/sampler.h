/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The random numbers of a path: pairs in [0, 1)², each named for its use, depending on (seed,
 * pixel, replicate, branch, sample, number of the pair) alone. Sobol' (default): dimensions 0 and 1
 * with the sample index shuffled and the values scrambled per pair by hashed Owen scrambling
 * (Burley, Practical Hash-based Owen Scrambling, JCGT 2020; hash constants by Vegdahl 2021), so
 * that the samples [0, 2^m) of a pixel's replicate are a (0, m, 2)-net in every pair.
 * MCV_SAMPLER_RANDOM: independent numbers.
 */
#ifndef MCVISI_KERNELS_SAMPLER_H
#define MCVISI_KERNELS_SAMPLER_H

#include "mcvisi/sampling.h"

/* Pairs of the sensor, then a group per surface the path meets. */
enum { MCV_PAIR_PIXEL, MCV_PAIR_APERTURE, MCV_PAIR_SURFACES };
enum { MCV_PAIR_SCATTER, MCV_PAIR_EMITTER, MCV_PAIR_CHOICE, MCV_PAIR_STRIDE };
/* What light paths take the same pairs for: the emitter, as surface 0, and a point of the lens on
 * each surface. */
enum {
    MCV_PAIR_LIGHT_EMITTER = MCV_PAIR_CHOICE,
    MCV_PAIR_LIGHT_PLACE = MCV_PAIR_EMITTER,
    MCV_PAIR_LIGHT_DIRECTION = MCV_PAIR_SCATTER,
    MCV_PAIR_LIGHT_LENS = MCV_PAIR_EMITTER
};
#define MCV_PAIR_CHANNEL 0xffffffffu /* the same pair at every body */
#define MCV_PAIR_TIME 0xfffffffeu    /* of sensors that move */
#define MCV_SURFACE_PAIR(depth, use) \
    ((uint)MCV_PAIR_SURFACES + (depth) * (uint)MCV_PAIR_STRIDE + (uint)(use))

typedef struct mcv_pair {
    float x, y;
} mcv_pair;

MCV_FUNCTION uint mcv_reverse_bits(uint x) {
    x = ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x00ff00ffu) << 8) | ((x >> 8) & 0x00ff00ffu);
    return (x << 16) | (x >> 16);
}

/* Permutes numbers whose bits are reversed so that each bit depends on the lower ones only (Laine
 * and Karras). */
MCV_FUNCTION uint mcv_permute_reversed(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* The second Sobol' coordinate of index i with its bits reversed: row j is the sum of the bits k of
 * i with C(k, j) odd. */
MCV_FUNCTION uint mcv_sobol_reversed(uint i) {
    i ^= (i & 0xaaaaaaaau) >> 1;
    i ^= (i & 0xccccccccu) >> 2;
    i ^= (i & 0xf0f0f0f0u) >> 4;
    i ^= (i & 0xff00ff00u) >> 8;
    i ^= (i & 0xffff0000u) >> 16;
    return i;
}

MCV_FUNCTION float mcv_unit_interval(uint bits) {
    return (float)(bits >> 8) * 5.9604644775390625e-8f;
}

/* `stream` identifies pixel, replicate, the user's seed and the branch (of a light path
 * mcv_identify_light makes it); `sample` counts within them. */
MCV_LOOP_FUNCTION mcv_pair mcv_sample_pair(uint stream, uint sample, uint number) {
    const uint seed = mcv_hash_2(stream, number);
    mcv_pair result;
#if MCV_SAMPLER_RANDOM
    const uint bits = mcv_hash_2(seed, sample);
    result.x = mcv_unit_interval(mcv_hash(bits ^ 0x68bc21ebu));
    result.y = mcv_unit_interval(mcv_hash(bits ^ 0x02e5be93u));
#else
    const uint index = mcv_reverse_bits(mcv_permute_reversed(mcv_reverse_bits(sample), seed));
    result.x = mcv_unit_interval(
        mcv_reverse_bits(mcv_permute_reversed(index, mcv_hash(seed ^ 0x68bc21ebu))));
    result.y = mcv_unit_interval(mcv_reverse_bits(
        mcv_permute_reversed(mcv_sobol_reversed(index), mcv_hash(seed ^ 0x02e5be93u))));
#endif
    return result;
}

#endif
