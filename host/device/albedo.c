/* SPDX-License-Identifier: Apache-2.0 */
#include "device/albedo.h"

#include <complex.h>
#include <math.h>
#include <stdbool.h>

#include "core/parallel.h"
#include "mcvisi/materials/microfacet.h"

/*
 * Points of the quadrature over visible microfacets. Those at the disk's rim reflect light
 * downwards: w² = 1 - radius² puts more points there. Entries are accurate to 4e-4, compared with
 * finer steps and with an integral over all normals.
 */
enum { RADII = 48, ANGLES = 48 };

uint32_t mcv_albedo_words(uint32_t azimuths) { return 2 + 2 * azimuths * MCV_ALBEDO_COSINES; }

static double lambda(const double alpha[2], const double w[3]) {
    const double x = alpha[0] * w[0], y = alpha[1] * w[1];
    return 0.5 * (sqrt(1 + (x * x + y * y) / (w[2] * w[2])) - 1);
}

/* A visible microfacet normal: mcv_ggx_sample with the disk's radius² and the direction of its
 * radius. */
static void facet(const double alpha[2], const double o[3], double radius_squared,
                  const double towards[2], double h[3]) {
    double s[3] = {alpha[0] * o[0], alpha[1] * o[1], o[2]};
    const double length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
    for (int k = 0; k < 3; ++k) s[k] /= length;
    const double q = radius_squared * (1 + s[2]), around = sqrt(fmax(q * (2 - q), 0));
    h[0] = alpha[0] * (around * towards[0] + s[0]);
    h[1] = alpha[1] * (around * towards[1] + s[1]);
    h[2] = (1 - radius_squared) * (1 + s[2]);
    const double size = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    for (int k = 0; k < 3; ++k) h[k] /= size;
}

void mcv_coat(double coating, double n1, double n2, double *scale, double *offset) {
    const double bare = pow((n1 - n2) / (n1 + n2), 2);
    *scale = coating > 0 ? (1 - coating) / (1 - bare) : 1;
    *offset = coating > 0 ? coating - *scale * bare : 0;
}

/* The shares of the light from o that the microfacets reflect: all of it, and that weighed by (1 -
 * c)^5; or with Fresnel's reflectance into and out of an index. */
static void integrate(const double alpha[2], const double o[3], double eta, double coating,
                      bool interface, double sums[2]) {
    const double own = lambda(alpha, o),
                 turn = o[1] == 0
                            ? M_PI
                            : 2 * M_PI; /* the two sides of the plane of incidence may be equal */
    double scale, offset;
    mcv_coat(coating, eta, 1, &scale, &offset);
    sums[0] = sums[1] = 0;
    for (int a = 0; a < ANGLES; ++a) {
        const double angle = turn * (a + 0.5) / ANGLES, towards[2] = {cos(angle), sin(angle)};
        for (int r = 0; r < RADII; ++r) {
            double h[3], reflected[3], refracted[3];
            const double w = (r + 0.5) / RADII, weight = 2 * w;
            facet(alpha, o, 1 - w * w, towards, h);
            const double c = fmin(o[0] * h[0] + o[1] * h[1] + o[2] * h[2], 1);
            const double squared = 1 - eta * eta * (1 - c * c),
                         c2 = squared > 0 ? sqrt(squared) : 0;
            for (int k = 0; k < 3; ++k) {
                reflected[k] = 2 * c * h[k] - o[k];
                refracted[k] = -eta * o[k] + (eta * c - c2) * h[k];
            }
            const double kept =
                reflected[2] > 0 ? weight * (1 + own) / (1 + own + lambda(alpha, reflected)) : 0;
            if (!interface) {
                sums[0] += kept;
                sums[1] += kept * (1 - c) * (1 - c) * (1 - c) * (1 - c) * (1 - c);
                continue;
            }
            const double s = (eta * c - c2) / (eta * c + c2), p = (c - eta * c2) / (c + eta * c2);
            const double fresnel = c2 > 0 ? fmax(scale * 0.5 * (s * s + p * p) + offset, 0) : 1;
            sums[0] += fresnel * kept;
            if (c2 > 0 && refracted[2] < 0)
                sums[0] +=
                    (1 - fresnel) * weight * (1 + own) *
                    (double)mcv_opposite_masking((float)own, (float)lambda(alpha, refracted));
        }
    }
    for (int k = 0; k < 2; ++k) sums[k] /= RADII * ANGLES;
}

/* The direction of a row and column of the block, at an azimuth. The grazing row is a limit. */
static void direction(uint32_t row, uint32_t column, uint32_t azimuths, double o[3]) {
    const double share = (double)column / (MCV_ALBEDO_COSINES - 1),
                 cosine = fmax(share * share, 1e-6), sine = sqrt(1 - cosine * cosine);
    const double x = azimuths > 1 ? (double)row / (azimuths - 1) : 1, y = 1 - x,
                 length = hypot(x, y);
    o[0] = sine * x / length;
    o[1] = sine * y / length;
    o[2] = cosine;
}

/* The means 2 ∫ μ dμ over all azimuths, of what the device interpolates. */
static void average(uint32_t azimuths, float *block) {
    enum { STEPS = 16, TURNS = 64 };
    const float *rows = block + 2;
    const uint32_t turns = azimuths > 1 ? TURNS : 1;
    double sums[2] = {0, 0}, weights = 0;
    for (uint32_t turn = 0; turn < turns; ++turn) {
        const double angle = M_PI / 2 * (turn + 0.5) / turns, x = cos(angle), y = sin(angle);
        const double across = x / (x + y) * (azimuths - 1.0);
        const uint32_t row = azimuths > 1 ? (uint32_t)across : 0;
        const double g = azimuths > 1 ? across - row : 0;
        for (int step = 0; step < STEPS * (MCV_ALBEDO_COSINES - 1); ++step) {
            const double place = (step + 0.5) / STEPS, share = place / (MCV_ALBEDO_COSINES - 1);
            const uint32_t column = (uint32_t)place;
            const double f = place - column,
                         weight = share * share * share; /* μ dμ with μ = share² */
            for (int k = 0; k < 2; ++k) {
                const float *at = rows + 2 * (row * MCV_ALBEDO_COSINES + column) + k;
                const float *next = g > 0 ? at + 2 * MCV_ALBEDO_COSINES : at;
                sums[k] += weight * ((1 - g) * ((1 - f) * at[0] + f * at[2]) +
                                     g * ((1 - f) * next[0] + f * next[2]));
            }
            weights += weight;
        }
    }
    for (int k = 0; k < 2; ++k) block[k] = (float)(sums[k] / weights);
}

typedef struct reflection {
    double alpha[2];
    uint32_t azimuths;
    float *block;
} reflection;

/* Work for one thread. */
static void fill_reflection(void *user, size_t i) {
    const reflection *f = user;
    const uint32_t entry = (uint32_t)i;
    double o[3], sums[2];
    direction(entry / MCV_ALBEDO_COSINES, entry % MCV_ALBEDO_COSINES, f->azimuths, o);
    integrate(f->alpha, o, 1, 0, false, sums);
    f->block[2 + 2 * i] = (float)(1 - sums[0]);
    f->block[3 + 2 * i] = (float)sums[1];
}

void mcv_albedo_reflection(double alpha_x, double alpha_y, uint32_t azimuths, float *block) {
    reflection filled = {{alpha_x, alpha_y}, azimuths, block};
    mcv_in_parallel((size_t)azimuths * MCV_ALBEDO_COSINES, fill_reflection, &filled);
    average(azimuths, block);
}

void mcv_albedo_interface(double alpha_x, double alpha_y, double n_outside, double n_inside,
                          double coating, uint32_t azimuths, float *block) {
    const double alpha[2] = {alpha_x, alpha_y};
    for (uint32_t i = 0; i < azimuths * MCV_ALBEDO_COSINES; ++i) {
        double o[3];
        direction(i / MCV_ALBEDO_COSINES, i % MCV_ALBEDO_COSINES, azimuths, o);
        for (uint32_t side = 0; side < 2; ++side) {
            const double eta = side ? n_inside / n_outside : n_outside / n_inside;
            double sums[2];
            integrate(alpha, o, eta, coating, true, sums);
            block[2 + 2 * i + side] = (float)fmax(1 - sums[0], 0);
        }
    }
    average(azimuths, block);
}

double mcv_conductor_mean(double n, double k) {
    enum { STEPS = 1000 };
    double sum = 0;
    for (int i = 0; i < STEPS; ++i) {
        const double cosine = (i + 0.5) / STEPS;
        const double complex index = n - k * I,
                             other = csqrt(index * index - (1 - cosine * cosine));
        const double complex s = (cosine - other) / (cosine + other);
        const double complex p =
            (index * index * cosine - other) / (index * index * cosine + other);
        sum += cosine * (creal(s * conj(s)) + creal(p * conj(p)));
    }
    return sum / STEPS;
}
