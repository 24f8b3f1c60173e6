/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/noise.h"

#include <math.h>

void mcv_philox(const uint32_t counter[4], const uint32_t key[2], uint32_t words[4]) {
    uint32_t k0 = key[0], k1 = key[1];
    for (int i = 0; i < 4; ++i) words[i] = counter[i];
    for (int round = 0; round < 10; ++round) {
        const uint64_t p0 = (uint64_t)0xd2511f53u * words[0];
        const uint64_t p1 = (uint64_t)0xcd9e8d57u * words[2];
        words[0] = (uint32_t)(p1 >> 32) ^ words[1] ^ k0;
        words[1] = (uint32_t)p1;
        words[2] = (uint32_t)(p0 >> 32) ^ words[3] ^ k1;
        words[3] = (uint32_t)p0;
        k0 += 0x9e3779b9u;
        k1 += 0xbb67ae85u;
    }
}

mcv_noise mcv_noise_begin(uint32_t seed, uint32_t channel, uint64_t pixel) {
    return (mcv_noise){.key = {seed, 0},
                       .counter = {(uint32_t)pixel, (uint32_t)(pixel >> 32), channel, 0}};
}

double mcv_noise_uniform(mcv_noise *noise) {
    if (noise->left == 0) {
        mcv_philox(noise->counter, noise->key, noise->words);
        ++noise->counter[3];
        noise->left = 4;
    }
    noise->left -= 2;
    const uint64_t bits = (uint64_t)noise->words[noise->left] << 32 | noise->words[noise->left + 1];
    return ((double)(bits >> 12) + 0.5) * 0x1p-52;
}

double mcv_noise_normal(mcv_noise *noise) {
    const double radius = sqrt(-2 * log(mcv_noise_uniform(noise)));
    return radius * cos(2 * M_PI * mcv_noise_uniform(noise));
}

/* Walks up the distribution function. What a double cannot tell from 1 ends the walk. */
static double invert(double u, double mean) {
    double p = exp(-mean);
    double k = 0;
    while (u > p && (k < mean || p > 0x1p-60)) {
        u -= p;
        ++k;
        p *= mean / k;
    }
    return k;
}

double mcv_noise_poisson(mcv_noise *noise, double mean) {
    if (mean < 10) return invert(mcv_noise_uniform(noise), mean);
    const double b = 0.931 + 2.53 * sqrt(mean);
    const double a = -0.059 + 0.02483 * b;
    const double inverse_alpha = 1.1239 + 1.1328 / (b - 3.4);
    const double squeeze = 0.9277 - 3.6224 / (b - 2);
    for (;;) {
        const double u = mcv_noise_uniform(noise) - 0.5;
        const double v = mcv_noise_uniform(noise);
        const double us = 0.5 - fabs(u);
        const double k = floor((2 * a / us + b) * u + mean + 0.43);
        if (us >= 0.07 && v <= squeeze) return k;
        if (k < 0 || (us < 0.013 && v > us)) continue;
        int sign;
        if (log(v * inverse_alpha / (a / (us * us) + b)) <=
            k * log(mean) - mean - lgamma_r(k + 1, &sign))
            return k;
    }
}
