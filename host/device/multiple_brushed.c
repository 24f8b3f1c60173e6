/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering between the microfacets of a brushed metal (multiple.h). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/parallel.h"
#include "device/albedo.h"
#include "device/microsurface.h"
#include "device/multiple.h"
#include "device/multiple_orders.h"
#include "mcvisi/materials/brushed.h"

static const double pi = 3.14159265358979323846;

enum {
    MIDDLES = MCV_BRUSHED_MIDDLES,
    HALVES = MCV_BRUSHED_HALVES,
    ACROSS = 2 * HALVES - 1, /* entries of d_y, of both signs */
    WORDS = MCV_MULTIPLE_WORDS,
    ENTRIES = MCV_BRUSHED_ENTRIES
};

typedef struct surface {
    double alpha[2];
    mcv_facet_metal metal;
    float *table;          /* WORDS for each entry */
    double *white, *ratio; /* two reflections of white microfacets, and three over these */
} surface;

uint32_t mcv_multiple_brushed_words(void) { return WORDS * ENTRIES; }

static double middle_of(int entry) {
    const double rest = 1 - (double)entry / (MIDDLES - 1);
    return 1 - rest * rest;
}

/* The cosine of twice the angle whose tangent is p. */
static double cosine_of(double p) { return (1 - p * p) / (1 + p * p); }

/* The d of an entry, by bisection. */
static double half_of(int entry, double most, double width) {
    double low = 0, high = most;
    for (int round = 0; round < 24 && entry < HALVES - 1; ++round) {
        const double half = 0.5 * (low + high);
        const float place = mcv_brushed_half((float)half, (float)most, (float)width);
        *(place < (float)entry ? &low : &high) = half;
    }
    return high;
}

/* The direction of two places, not below the horizon. */
static void direction_of(double p_x, double p_y, double w[3]) {
    const double most = 1 - 1e-4, x = fmax(-most, fmin(most, p_x)),
                 y = fmax(-most, fmin(most, p_y)), upright = cosine_of(y);
    w[0] = 2 * x / (1 + x * x) * upright;
    w[1] = 2 * y / (1 + y * y);
    w[2] = fmax(cosine_of(x) * upright, 1e-3);
    const double length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    for (int k = 0; k < 3; ++k) w[k] /= length;
}

/* The two directions of an entry. */
static void pair_of(const surface *s, int entry, double o[3], double i[3]) {
    const int places[2][2] = {{entry / (ACROSS * HALVES * MIDDLES), entry / ACROSS % HALVES},
                              {entry / (ACROSS * HALVES) % MIDDLES, entry % ACROSS - (HALVES - 1)}};
    double m[2], d[2];
    for (int k = 0; k < 2; ++k) m[k] = middle_of(places[k][0]);
    const double upright = (double)mcv_brushed_upright((float)m[0], (float)m[1]);
    for (int k = 0; k < 2; ++k) {
        const double most = 1 - m[k], width = (double)MCV_BRUSHED_WIDTH * s->alpha[k] * upright;
        d[k] = most > 0 ? half_of(abs(places[k][1]), most, width) : 0;
        if (places[k][1] < 0) d[k] = -d[k];
    }
    direction_of(d[0] + m[0], d[1] + m[1], o);
    direction_of(d[0] - m[0], d[1] - m[1], i);
}

/*
 * Adds two reflections from one direction to another, the first by its visible microfacets; units
 * and weights are those of add_twice in multiple.c. `offset` shifts the points, so that errors of
 * entries are not alike.
 */
static void add_twice(const surface *s, const double from[3], const double to[3], double offset,
                      double sums[WORDS + 1]) {
    enum { FACETS = 64 };
    const double near = mcv_smith_at(s->alpha, from), far = mcv_smith_at(s->alpha, to);
    const double own = 1 / (4 * from[2] * (1 + near)), other = 1 / (4 * to[2] * (1 + far));
    for (int f = 0; f < FACETS; ++f) {
        const double chance = (f + offset) / FACETS,
                     angle = 2 * pi * (offset + 0.618033988749895 * f),
                     turn[2] = {cos(angle), sin(angle)};
        double w[3], h[3], back[3], c;
        mcv_reflect_by_facet(s->alpha, from, sqrt(chance), turn, w, &c, h);
        for (int k = 0; k < 3; ++k) back[k] = -w[k];
        const double first = mcv_facet_between(s->alpha, from, w),
                     second = mcv_facet_between(s->alpha, back, to);
        if (!(first > 0 && second > 0)) continue;
        const double reach = 1 / (1 + mcv_smith_at(s->alpha, w) + (w[2] > 0 ? near : far));
        const double value = first * second * reach /
                             (4 * fmax(fabs(w[2]), 1e-12) * (own * first + other * second)) /
                             FACETS;
        const double half = 0.5 + 0.5 * (back[0] * to[0] + back[1] * to[1] + back[2] * to[2]);
        mcv_add_two_reflections(&s->metal, value, (float)c, (float)fmin(sqrt(fmax(half, 0)), 1),
                                sums);
    }
}

/* Work for one thread. */
static void fill_entry(void *user, size_t number) {
    enum { CHOICES = 8 };
    const surface *s = user;
    const int entry = (int)number;
    const double offset = fmod(0.5 + 0.7548776662466927 * entry, 1);
    double o[3], i[3], sums[WORDS + 1] = {0};
    pair_of(s, entry, o, i);
    const double once = mcv_facet_between(s->alpha, o, i);
    add_twice(s, o, i, offset, sums);
    add_twice(s, i, o, offset, sums);
    for (int k = 0; k < WORDS; ++k) s->table[entry * WORDS + k] = (float)(sums[k] / once);
    s->white[entry] = sums[WORDS] / once;
    s->ratio[entry] = mcv_three_reflections(s->alpha, o, i, CHOICES, CHOICES * entry) /
                      fmax(sums[WORDS], 1e-12 * once);
}

/* A ratio of few choices is noisy and changes slowly: it is smoothed along each axis, but at its
 * ends. */
static void smooth(double *ratio) {
    static const int counts[4] = {MIDDLES, MIDDLES, HALVES, ACROSS};
    for (int axis = 0, step = ENTRIES; axis < 4; ++axis) {
        step /= counts[axis];
        for (int first = 0; first < ENTRIES; ++first) {
            if (first / step % counts[axis] != 0) continue;
            double before = ratio[first];
            for (int k = 1; k < counts[axis] - 1; ++k) {
                double *here = ratio + first + k * step;
                const double was = *here;
                *here = 0.25 * before + 0.5 * was + 0.25 * here[step];
                before = was;
            }
        }
    }
}

/* splitmix64, as a number in (0, 1). */
static double unit(uint64_t *state) {
    uint64_t x = *state += 0x9e3779b97f4a7c15U;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9U;
    x = (x ^ x >> 27) * 0x94d049bb133111ebU;
    return ((double)((x ^ x >> 31) >> 11) + 0.5) * 0x1p-53;
}

/* Of diffuse light that white microfacets reflect three and more times, the share that they reflect
 * again after the third. */
static double left_after_three(const double alpha[2]) {
    enum { WALKS = 8192, MOST = 100 };
    double counts[2] = {0, 0};
    uint64_t state = 0;
    for (int walk = 0; walk < WALKS; ++walk) {
        const double sine = sqrt((walk + 0.5) / WALKS), phi = 2 * pi * unit(&state);
        double back[3] = {sine * cos(phi), sine * sin(phi), sqrt(1 - sine * sine)}, below = 1;
        int reflections = 0;
        for (; reflections < MOST; ++reflections) {
            const double l = mcv_smith_at(alpha, back), chance = unit(&state);
            const bool up = back[2] < 0;
            const double left = up ? pow(chance, 1 / fmax(l, 1e-12)) : pow(chance, -1 / (1 + l));
            if (up && below >= left) break;
            below = up ? below / left : fmin(below / left, 1);
            const double angle = 2 * pi * unit(&state), turn[2] = {cos(angle), sin(angle)};
            double w[3], c, h[3];
            mcv_reflect_by_facet(alpha, back, sqrt(unit(&state)), turn, w, &c, h);
            for (int k = 0; k < 3; ++k) back[k] = -w[k];
        }
        if (reflections >= 3) ++counts[reflections > 3];
    }
    return counts[1] / fmax(counts[0] + counts[1], 1);
}

/* Directions at which the table's light is counted, at equal steps of √(1 - p) along and across. */
enum { SIDE = 5, NODES = SIDE * SIDE };

/* The share of a direction's places in a node. */
static double share_in(int node, const double w[3]) {
    const int places[2] = {node % SIDE, node / SIDE};
    const mcv_vec3 v = {(float)w[0], (float)w[1], (float)w[2]};
    const double p[2] = {fabs((double)mcv_brushed_along(v)), fabs((double)mcv_brushed_across(v))};
    double share = 1;
    for (int k = 0; k < 2; ++k) {
        const double place = (SIDE - 1) * (1 - sqrt(fmax(1 - p[k], 0)));
        share *= fmax(1 - fabs(place - places[k]), 0);
    }
    return share;
}

/* What white microfacets send from a node's direction towards each node, as the device
 * interpolates; returns the light that does not leave after one reflection. */
static double follow(const surface *s, const float *table, int node, double shares[NODES]) {
    enum { RADII = 24, ANGLES = 24 };
    const int places[2] = {node % SIDE, node / SIDE};
    const double rest[2] = {1 - (double)places[0] / (SIDE - 1), 1 - (double)places[1] / (SIDE - 1)};
    const mcv_alpha alpha = {(float)s->alpha[0], (float)s->alpha[1]};
    double o[3], missing = 1;
    direction_of(1 - rest[0] * rest[0], 1 - rest[1] * rest[1], o);
    const double own = mcv_smith_at(s->alpha, o);
    memset(shares, 0, NODES * sizeof *shares);
    for (int f = 0; f < RADII * ANGLES; ++f) {
        const int around = f / RADII;
        const double left = (f % RADII + 0.5) / RADII, angle = 2 * pi * (around + 0.5) / ANGLES,
                     turn[2] = {cos(angle), sin(angle)};
        double w[3], h[3], c;
        mcv_reflect_by_facet(s->alpha, o, left, turn, w, &c, h);
        if (!(w[2] > 0)) continue;
        const double kept =
            2 * left * (1 + own) / (1 + own + mcv_smith_at(s->alpha, w)) / (RADII * ANGLES);
        const mcv_brushed_place place =
            mcv_find_brushed(alpha, (mcv_vec3){(float)o[0], (float)o[1], (float)o[2]},
                             (mcv_vec3){(float)w[0], (float)w[1], (float)w[2]});
        const double sent = kept * (double)mcv_brushed_at(table, place).word[0];
        missing -= kept;
        for (int k = 0; k < NODES; ++k) shares[k] += sent * share_in(k, w);
    }
    return missing;
}

/*
 * Factors r(o) r(i) with which white microfacets lose no light at any of the nodes. What one
 * reflection loses is known well; interpolation and few points have errors. `all` has entries of
 * white microfacets' light after two and more reflections.
 */
static void complete(const surface *s, const float *all, double r[NODES]) {
    enum { ROUNDS = 40 };
    double shares[NODES][NODES], missing[NODES];
    for (int node = 0; node < NODES; ++node) {
        missing[node] = follow(s, all, node, shares[node]);
        r[node] = 1;
    }
    for (int k = 0; k < ROUNDS * NODES; ++k) {
        const int node = k % NODES;
        double sum = 0;
        for (int other = 0; other < NODES; ++other) sum += shares[node][other] * r[other];
        if (sum > 0) r[node] = fmin(fmax(sqrt(r[node] * missing[node] / sum), 0.8), 1.25);
    }
}

static double factor_of(const double r[NODES], const double w[3]) {
    double sum = 0;
    for (int node = 0; node < NODES; ++node) sum += r[node] * share_in(node, w);
    return sum;
}

bool mcv_multiple_brushed(const double alpha[2], const double *n, const double *k, float *table) {
    surface *s = malloc(sizeof *s);
    double *white = malloc(2 * ENTRIES * sizeof *white);
    float *all = calloc(WORDS * ENTRIES, sizeof *all);
    const bool made = s && white && all;
    if (made) {
        const double left = left_after_three(alpha);
        double more[3] = {0}, r[NODES];
        *s = (surface){.alpha = {alpha[0], alpha[1]},
                       .table = table,
                       .white = white,
                       .ratio = white + ENTRIES};
        mcv_facet_metal_fill(n, k, &s->metal);
        for (uint32_t c = 0; c < s->metal.channels; ++c)
            more[c] = mcv_more_reflections(mcv_conductor_mean(n[c], k[c]), left);
        mcv_in_parallel(ENTRIES, fill_entry, s);
        smooth(s->ratio);
        for (int entry = 0; entry < ENTRIES; ++entry) {
            const double rest = s->ratio[entry] / (1 - left); /* three and more over two */
            for (uint32_t c = 0; c < s->metal.channels; ++c)
                s->table[entry * WORDS + (int)c] *= (float)(1 + rest * more[c]);
            s->table[entry * WORDS + WORDS - 1] = (float)(white[entry] * rest);
            all[(size_t)entry * WORDS] = (float)(white[entry] * (1 + rest));
        }
        complete(s, all, r);
        for (int entry = 0; entry < ENTRIES; ++entry) {
            double o[3], i[3];
            pair_of(s, entry, o, i);
            const double factor = factor_of(r, o) * factor_of(r, i);
            for (int word = 0; word < WORDS; ++word) table[entry * WORDS + word] *= (float)factor;
        }
    }
    free(all);
    free(s);
    free(white);
    return made;
}
