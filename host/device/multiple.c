/* SPDX-License-Identifier: Apache-2.0 */
#include "device/multiple.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/parallel.h"
#include "device/albedo.h"
#include "device/microsurface.h"
#include "device/multiple_orders.h"

static const double pi = 3.14159265358979323846;

enum {
    COSINES = MCV_MULTIPLE_COSINES,
    AZIMUTHS = MCV_MULTIPLE_AZIMUTHS,
    WORDS = MCV_MULTIPLE_WORDS
};

/* Visible microfacets of a direction, over which the second reflection is summed: accurate to 1 %,
 * compared with finer steps. */
enum { RADII = 24, ANGLES = 24, FACETS = RADII * ANGLES };

uint32_t mcv_multiple_words(void) { return WORDS * COSINES * COSINES * AZIMUTHS; }

/* A direction in the plane y = 0, and the directions into which its visible microfacets reflect. */
typedef struct heading {
    double cosine, sine, lambda;
    double w[FACETS][3], weight[FACETS];
    double density[FACETS]; /* D of the microfacet */
    double hit[FACETS];     /* Λ of w */
    float c[FACETS];        /* cosine of incidence */
} heading;

/* Three reflections over two, at every third row and column and some angles; linear interpolation
 * between. */
enum { COARSE = (COSINES + 1) / 3, TURNS = 3 };
static const uint32_t turns[TURNS] = {0, 3, AZIMUTHS - 1};

typedef struct surface {
    double alpha;
    mcv_facet_metal metal;
    heading nodes[COSINES];
    float *table, *white; /* of all entries; white holds two reflections of white microfacets */
    double ratios[COARSE][COARSE][TURNS];
    double shares[COSINES][COSINES], counted[COSINES][3];
} surface;

/*
 * Adds two reflections from one direction to a second, `turn` away in azimuth. The first reflection
 * goes to the directions of `from`'s visible microfacets. The sum is 4 |o_z| |i_z| (1 + Λ(o) +
 * Λ(i)) times the BRDF of two reflections, for white microfacets and for the words of an entry. The
 * heights between the reflections are integrated in closed form; the balance heuristic combines the
 * microfacets of both directions.
 */
static void add_twice(const surface *work, const heading *from, const heading *to,
                      double turn_cosine, double turn_sine, double sums[WORDS + 1]) {
    const double alpha = work->alpha, x = to->sine * turn_cosine, y = to->sine * turn_sine,
                 z = to->cosine;
    const double own = 1 / (4 * from->cosine * (1 + from->lambda)),
                 other = 1 / (4 * to->cosine * (1 + to->lambda));
    for (int f = 0; f < FACETS; ++f) {
        const double *w = from->w[f], d[3] = {x - w[0], y - w[1], z - w[2]};
        if (!(d[2] > 0)) continue;
        const double squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2],
                     second = mcv_facet_density(alpha, d[2] * d[2] / squared);
        const double reach = 1 / (1 + from->hit[f] + (w[2] > 0 ? from->lambda : to->lambda));
        const double first = from->density[f];
        const double value = from->weight[f] * first * second * reach /
                             (4 * fabs(w[2]) * (own * first + other * second));
        mcv_add_two_reflections(&work->metal, value, from->c[f],
                                (float)fmin(0.5 * sqrt(squared), 1), sums);
    }
}

static void fill_node(double alpha, double cosine, heading *node) {
    node->cosine = cosine;
    node->sine = sqrt(1 - cosine * cosine);
    node->lambda = mcv_smith(alpha, cosine);
    for (int a = 0; a < ANGLES; ++a)
        for (int r = 0; r < RADII; ++r) {
            const int f = a * RADII + r;
            const double left = (r + 0.5) / RADII;
            const double angle = 2 * pi * (a + 0.5) / ANGLES, turn[2] = {cos(angle), sin(angle)},
                         o[3] = {node->sine, 0, cosine};
            double c, h[3];
            mcv_reflect_by_facet((const double[2]){alpha, alpha}, o, left, turn, node->w[f], &c, h);
            node->weight[f] = 2 * left / FACETS;
            node->density[f] = mcv_facet_density(alpha, h[2] * h[2]);
            node->hit[f] = mcv_smith(alpha, fmax(fabs(node->w[f][2]), 1e-12));
            node->c[f] = (float)c;
        }
}

static float *entry_at(float *table, uint32_t row, uint32_t column, uint32_t entry) {
    return table + (size_t)WORDS * ((row * COSINES + column) * AZIMUTHS + entry);
}

/* One reflection of white microfacets, in the units of add_twice: the density of the microfacet
 * between. */
static double once_at(double alpha, const heading *a, const heading *b, double half) {
    const double c = 2 * half * half - 1, z = a->cosine + b->cosine,
                 across = b->sine * sqrt(fmax(1 - c * c, 0));
    const double along = a->sine + b->sine * c;
    return mcv_facet_density(alpha, z * z / (z * z + along * along + across * across));
}

/* The shares of light from a direction that leave white microfacets after one, two and more
 * reflections. */
static void count_reflections(double alpha, const heading *from, double shares[3]) {
    enum { RADII_1 = 24, ANGLES_1 = 12, RADII_2 = 12, ANGLES_2 = 12 };
    const double own = from->lambda, o[3] = {from->sine, 0, from->cosine};
    double turns_2[ANGLES_2][2];
    for (int a = 0; a < ANGLES_2; ++a) {
        const double angle = 2 * pi * (a + 0.5) / ANGLES_2;
        turns_2[a][0] = cos(angle);
        turns_2[a][1] = sin(angle);
    }
    memset(shares, 0, 3 * sizeof *shares);
    for (int f = 0; f < RADII_1 * ANGLES_1; ++f) {
        /* Steep microfacets reflect light downwards: left = v² puts points there. The two sides of
         * the plane of incidence are equal. */
        const double v = (f % RADII_1 + 0.5) / RADII_1,
                     first = 4 * v * v * v / (RADII_1 * ANGLES_1);
        const int around = f / RADII_1;
        const double angle = pi * (around + 0.5) / ANGLES_1, turn[2] = {cos(angle), sin(angle)};
        double w[3], back[3], c, h[3];
        mcv_reflect_by_facet((const double[2]){alpha, alpha}, o, v * v, turn, w, &c, h);
        const double hit = mcv_smith(alpha, fmax(fabs(w[2]), 1e-12)),
                     goes_on = w[2] > 0 ? hit / (1 + own + hit) : 1;
        shares[0] += first * (1 - goes_on);
        for (int k = 0; k < 3; ++k) back[k] = -w[k];
        for (int g = 0; g < RADII_2 * ANGLES_2; ++g) {
            const double u = (g % RADII_2 + 0.5) / RADII_2,
                         second = first * 4 * u * u * u / (RADII_2 * ANGLES_2);
            double i[3];
            mcv_reflect_by_facet((const double[2]){alpha, alpha}, back, u * u, turns_2[g / RADII_2],
                                 i, &c, h);
            const double out = i[2] > 0 ? mcv_smith(alpha, i[2]) : 0;
            const double leaves = i[2] > 0 ? (1 + own) / (1 + own + out) *
                                                 (w[2] > 0 ? 1 : (1 + hit) / (1 + hit + out))
                                           : 0;
            shares[1] += second * goes_on * leaves;
            shares[2] += second * goes_on * (1 - leaves);
        }
    }
}

/* Three reflections between two directions, by the cosine between their azimuths. */
static double thrice(double alpha, const heading *from, const heading *to, double c) {
    enum { CHOICES = 1024 };
    const double alphas[2] = {alpha, alpha}, o[3] = {from->sine, 0, from->cosine},
                 i[3] = {to->sine * c, to->sine * sqrt(fmax(1 - c * c, 0)), to->cosine};
    return mcv_three_reflections(alphas, o, i, CHOICES, 0);
}

/* The ratios of a row and of the column of this number: work for one thread. */
static void fill_ratios(void *user, size_t last) {
    surface *work = user;
    const uint32_t row = (uint32_t)last;
    for (uint32_t column = 0; column <= row; ++column)
        for (uint32_t turn = 0; turn < TURNS; ++turn) {
            const uint32_t r = 3 * row + 1, c = 3 * column + 1;
            const heading *a = &work->nodes[r], *b = &work->nodes[c];
            const double half = mcv_multiple_half(turns[turn], a->cosine + b->cosine),
                         once = once_at(work->alpha, a, b, half);
            const double more = thrice(work->alpha, a, b, 2 * half * half - 1) / once;
            work->ratios[row][column][turn] = work->ratios[column][row][turn] =
                more / fmax((double)work->white[(r * COSINES + c) * AZIMUTHS + turns[turn]], 1e-12);
        }
}

static double ratio_at(const surface *work, uint32_t row, uint32_t column, double entry) {
    const double places[2] = {fmax((row - 1.0) / 3, 0), fmax((column - 1.0) / 3, 0)};
    const uint32_t low[2] = {(uint32_t)fmin(places[0], COARSE - 2),
                             (uint32_t)fmin(places[1], COARSE - 2)},
                   turn = entry >= turns[1];
    const double share = (entry - turns[turn]) / (turns[turn + 1] - turns[turn]);
    double sum = 0;
    for (uint32_t k = 0; k < 8; ++k) {
        const double f = k & 1 ? places[0] - low[0] : 1 - (places[0] - low[0]),
                     g = k & 2 ? places[1] - low[1] : 1 - (places[1] - low[1]);
        sum += f * g * (k & 4 ? share : 1 - share) *
               work->ratios[low[0] + (k & 1)][low[1] + (k >> 1 & 1)][turn + (k >> 2)];
    }
    return sum;
}

/* shares[b] is the light, from the direction of a row, that white microfacets send towards column b
 * by three reflections, as the device interpolates. */
static void follow(const surface *work, uint32_t row, double shares[COSINES]) {
    const heading *from = &work->nodes[row];
    const double alpha = work->alpha, o[3] = {from->sine, 0, from->cosine};
    memset(shares, 0, COSINES * sizeof *shares);
    for (int f = 0; f < RADII * ANGLES; ++f) {
        const int around = f / RADII;
        const double left = (f % RADII + 0.5) / RADII, angle = pi * (around + 0.5) / ANGLES,
                     turn[2] = {cos(angle), sin(angle)};
        double w[3], c, h[3];
        mcv_reflect_by_facet((const double[2]){alpha, alpha}, o, left, turn, w, &c, h);
        if (!(w[2] > 0)) continue;
        const double z = fmin(w[2], 1), kept = 2 * left * (1 + from->lambda) /
                                               (1 + from->lambda + mcv_smith(alpha, z));
        const double across = hypot(w[0], w[1]),
                     half = across > 0 ? sqrt(fmax(0.5 + 0.5 * w[0] / across, 0)) : 1;
        const double place = mcv_multiple_place(z, COSINES),
                     entry = mcv_multiple_entry(half, from->cosine + z);
        const uint32_t column = (uint32_t)fmin(place, COSINES - 2),
                       first = (uint32_t)fmin(entry, AZIMUTHS - 2);
        for (uint32_t k = 0; k < 2; ++k) {
            const float *at = work->white + (row * COSINES + column + k) * AZIMUTHS + first;
            const double value = (at[0] + (entry - first) * (double)(at[1] - at[0])) *
                                 ratio_at(work, row, column + k, entry);
            shares[column + k] +=
                kept / FACETS * value * (k ? place - column : 1 - (place - column));
        }
    }
}

/* Where the light of a row's direction goes: work for one thread. */
static void follow_row(void *user, size_t row) {
    surface *work = user;
    follow(work, (uint32_t)row, work->shares[row]);
    count_reflections(work->alpha, &work->nodes[row], work->counted[row]);
}

/*
 * Three and more reflections over three are r(o) r(i); r >= 1 is chosen so that white microfacets
 * lose no light at any angle. Returns the mean after one reflection.
 */
static double find_rest(const surface *work, double r[COSINES]) {
    enum { ROUNDS = 40 };
    double mean = 0, weights = 0;
    for (uint32_t row = 0; row < COSINES; ++row) {
        const double *counted = work->counted[row];
        r[row] = 1;
        const double weight =
            work->nodes[row].cosine * (work->nodes[row < COSINES - 1 ? row + 1 : row].cosine -
                                       work->nodes[row > 0 ? row - 1 : row].cosine);
        mean += weight * (counted[1] + counted[2]);
        weights += weight;
    }
    for (int round = 0; round < ROUNDS; ++round)
        for (uint32_t row = 0; row < COSINES; ++row) {
            double sum = 0;
            for (uint32_t b = 0; b < COSINES; ++b) sum += work->shares[row][b] * r[b];
            r[row] = sum > 0 ? fmin(fmax(sqrt(r[row] * work->counted[row][2] / sum), 1), 2) : 1;
        }
    return mean / weights;
}

/* Fills the words of a row's entries, without three and more reflections, and of the column of this
 * number: work for one thread. */
static void fill_twice(void *user, size_t last) {
    const surface *work = user;
    const uint32_t row = (uint32_t)last;
    for (uint32_t column = 0; column <= row; ++column)
        for (uint32_t entry = 0; entry < AZIMUTHS; ++entry) {
            const heading *a = &work->nodes[row], *b = &work->nodes[column];
            const double half = mcv_multiple_half(entry, a->cosine + b->cosine),
                         c = 2 * half * half - 1, s = sqrt(fmax(1 - c * c, 0));
            const double once = once_at(work->alpha, a, b, half);
            double sums[WORDS + 1] = {0};
            add_twice(work, a, b, c, s, sums);
            add_twice(work, b, a, c, s, sums);
            float *const at[2] = {entry_at(work->table, row, column, entry),
                                  entry_at(work->table, column, row, entry)};
            for (int side = 0; side < 2; ++side) {
                for (int k = 0; k < WORDS; ++k) at[side][k] = (float)(sums[k] / once);
                work->white[(at[side] - work->table) / WORDS] = (float)(sums[WORDS] / once);
            }
        }
}

bool mcv_multiple_reflection(double alpha, const double *n, const double *k, float *table) {
    surface *work = malloc(sizeof *work);
    float *white = malloc(sizeof *white * COSINES * COSINES * AZIMUTHS);
    double r[COSINES], more[3] = {0};
    if (work && white) {
        work->alpha = alpha;
        work->table = table;
        work->white = white;
        mcv_facet_metal_fill(n, k, &work->metal);
        for (uint32_t row = 0; row < COSINES; ++row)
            fill_node(alpha, mcv_multiple_cosine(row, COSINES), &work->nodes[row]);
        mcv_in_parallel(COSINES, fill_twice, work);
        mcv_in_parallel(COARSE, fill_ratios, work);
        mcv_in_parallel(COSINES, follow_row, work);
        const double left = find_rest(work, r);
        for (uint32_t c = 0; c < work->metal.channels; ++c)
            more[c] = mcv_more_reflections(mcv_conductor_mean(n[c], k[c]), left);
        for (uint32_t entry = 0; entry < COSINES * COSINES * AZIMUTHS; ++entry) {
            const uint32_t row = entry / AZIMUTHS / COSINES, column = entry / AZIMUTHS % COSINES;
            const double rest = r[row] * r[column] * ratio_at(work, row, column, entry % AZIMUTHS);
            float *at = table + (size_t)WORDS * entry;
            for (uint32_t c = 0; c < work->metal.channels; ++c)
                at[c] = (float)((double)at[c] * (1 + rest * more[c]));
            at[WORDS - 1] = (float)((double)white[entry] * rest);
        }
    }
    const bool made = work && white;
    free(work);
    free(white);
    return made;
}
