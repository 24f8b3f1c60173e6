/* SPDX-License-Identifier: Apache-2.0 */
#include "device/multiple.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device/albedo.h"
#include "device/microsurface.h"

static const double pi = 3.14159265358979323846;

enum {
    COSINES = MCV_MULTIPLE_COSINES,
    AZIMUTHS = MCV_MULTIPLE_AZIMUTHS,
    WORDS = MCV_MULTIPLE_WORDS
};

/* Visible microfacets of a direction, over which the second reflection is summed: accurate to 1 %,
 * compared with finer steps. */
enum { RADII = 24, ANGLES = 24, FACETS = RADII * ANGLES };

/* Steps of a metal's reflectance by the cosine. */
enum { STEPS = 512 };

uint32_t mcv_multiple_words(void) { return WORDS * COSINES * COSINES * AZIMUTHS; }

/* A direction in the plane y = 0, and the directions into which its visible microfacets reflect. */
typedef struct heading {
    double cosine, sine, lambda;
    double w[FACETS][3], weight[FACETS];
    double density[FACETS]; /* D of the microfacet */
    double hit[FACETS];     /* Λ of w */
    float c[FACETS];        /* cosine of incidence */
} heading;

typedef struct surface {
    double alpha;
    float reflectance[3][STEPS + 2];
    uint32_t channels; /* of a metal; 0: Schlick */
    heading nodes[COSINES];
} surface;

static float reflectance(const float *steps, float c) {
    const float x = c * (float)STEPS;
    const uint32_t step = (uint32_t)x;
    return steps[step] + (x - (float)step) * (steps[step + 1] - steps[step]);
}

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
        const float c[2] = {from->c[f], (float)fmin(0.5 * sqrt(squared), 1)};
        sums[WORDS] += value;
        for (uint32_t k = 0; k < work->channels; ++k)
            sums[k] += value * (double)(reflectance(work->reflectance[k], c[0]) *
                                        reflectance(work->reflectance[k], c[1]));
        if (work->channels > 0) continue;
        const double a = pow(1 - (double)c[0], 5), b = pow(1 - (double)c[1], 5);
        sums[0] += value * (1 - a) * (1 - b);
        sums[1] += value * (a + b - 2 * a * b);
        sums[2] += value * a * b;
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
            mcv_reflect_by_facet(alpha, o, left, turn, node->w[f], &c, h);
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
    memset(shares, 0, 3 * sizeof *shares);
    for (int f = 0; f < RADII_1 * ANGLES_1; ++f) {
        /* Steep microfacets reflect light downwards: left = v² puts points there. The two sides of
         * the plane of incidence are equal. */
        const double v = (f % RADII_1 + 0.5) / RADII_1,
                     first = 4 * v * v * v / (RADII_1 * ANGLES_1);
        const int around = f / RADII_1;
        const double angle = pi * (around + 0.5) / ANGLES_1, turn[2] = {cos(angle), sin(angle)};
        double w[3], back[3], c, h[3];
        mcv_reflect_by_facet(alpha, o, v * v, turn, w, &c, h);
        const double hit = mcv_smith(alpha, fmax(fabs(w[2]), 1e-12)),
                     goes_on = w[2] > 0 ? hit / (1 + own + hit) : 1;
        shares[0] += first * (1 - goes_on);
        for (int k = 0; k < 3; ++k) back[k] = -w[k];
        for (int g = 0; g < RADII_2 * ANGLES_2; ++g) {
            const double u = (g % RADII_2 + 0.5) / RADII_2,
                         second = first * 4 * u * u * u / (RADII_2 * ANGLES_2);
            const int about = g / RADII_2;
            const double other = 2 * pi * (about + 0.5) / ANGLES_2,
                         to[2] = {cos(other), sin(other)};
            double i[3];
            mcv_reflect_by_facet(alpha, back, u * u, to, i, &c, h);
            const double out = i[2] > 0 ? mcv_smith(alpha, i[2]) : 0;
            const double leaves = i[2] > 0 ? (1 + own) / (1 + own + out) *
                                                 (w[2] > 0 ? 1 : (1 + hit) / (1 + hit + out))
                                           : 0;
            shares[1] += second * goes_on * leaves;
            shares[2] += second * goes_on * (1 - leaves);
        }
    }
}

/* The density of the microfacet that reflects from a to b; 0 if there is none. */
static double between(double alpha, const double a[3], const double b[3]) {
    const double sum[3] = {a[0] + b[0], a[1] + b[1], a[2] + b[2]},
                 squared = sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2];
    return sum[2] > 0 && squared > 1e-20 ? mcv_facet_density(alpha, sum[2] * sum[2] / squared) : 0;
}

/*
 * The integral over the heights of three reflections from o by way of w1 and w2 to i, of which Λ is
 * given, and whether w1 and w2 go up. Light at the share u of the surface below it meets the next
 * microfacet at u' with Λ u^Λ/u'^(1 + Λ) upwards, (1 + Λ) u'^Λ/u^(1 + Λ) down; the factors Λ and 1
 * + Λ are left out.
 */
static double heights(double o, double w1, bool up1, double w2, bool up2, double i) {
    const double all = 1 + o + i;
    if (up1) return 1 / ((1 + o + w1) * (up2 ? 1 + o + w2 : 1 + w2 + i) * all);
    if (!up2) return 1 / ((1 + i + w1) * (1 + i + w2) * all);
    double x = o - w1,
           y = i -
               w2; /* down, then up: the limits for vanishing values are taken by a small step */
    if (fabs(x) < 1e-4) w1 = o - (x = 1e-4);
    if (fabs(y) < 1e-4) w2 = i - (y = 1e-4);
    return (1 / (1 + w1 + w2) - 1 / (1 + w2 + o) - 1 / (1 + w1 + i) + 1 / all) / (x * y);
}

/*
 * Three reflections of white microfacets between two directions; c is the cosine between their
 * azimuths. Units are those of add_twice. Two of the three microfacets are chosen among the visible
 * ones by an additive recurrence; the balance heuristic combines the three choices.
 */
static double thrice(double alpha, const heading *from, const heading *to, double c) {
    enum { CHOICES = 1024 };
    static const double steps[4] = {0.85667488385450, 0.73389185662717, 0.62870672005510,
                                    0.53859725722362}; /* g^-k, g^5 = g + 1 */
    const double o[3] = {from->sine, 0, from->cosine},
                 i[3] = {to->sine * c, to->sine * sqrt(fmax(1 - c * c, 0)), to->cosine};
    const double all = 1 + from->lambda + to->lambda;
    double sum = 0;
    for (int choice = 0; choice < 3 * CHOICES; ++choice) {
        const int number = choice / 3 + 1;
        double u[4], w1[3] = {0}, w2[3] = {0}, m1[3] = {0}, m2[3] = {0}, cosine, h[3];
        for (int k = 0; k < 4; ++k) u[k] = fmod(0.5 + steps[k] * number, 1);
        const double turn1[2] = {cos(2 * pi * u[1]), sin(2 * pi * u[1])},
                     turn2[2] = {cos(2 * pi * u[3]), sin(2 * pi * u[3])};
        const int first = choice % 3; /* 0: one from each end; 1: both from o, 2: both from i */
        if (first < 2) {
            mcv_reflect_by_facet(alpha, o, sqrt(u[0]), turn1, w1, &cosine, h);
            for (int k = 0; k < 3; ++k) m1[k] = -w1[k];
        } else {
            mcv_reflect_by_facet(alpha, i, sqrt(u[0]), turn1, m2, &cosine, h);
            for (int k = 0; k < 3; ++k) w2[k] = -m2[k];
        }
        if (first == 0) mcv_reflect_by_facet(alpha, i, sqrt(u[2]), turn2, m2, &cosine, h);
        if (first == 1) mcv_reflect_by_facet(alpha, m1, sqrt(u[2]), turn2, w2, &cosine, h);
        if (first == 2) mcv_reflect_by_facet(alpha, w2, sqrt(u[2]), turn2, m1, &cosine, h);
        for (int k = 0; k < 3; ++k) {
            if (first == 0) w2[k] = -m2[k];
            if (first == 1) m2[k] = -w2[k];
            if (first == 2) w1[k] = -m1[k];
        }
        const double d1 = between(alpha, o, w1), d2 = between(alpha, m1, w2),
                     d3 = between(alpha, m2, i);
        if (!(d1 > 0 && d2 > 0 && d3 > 0)) continue;
        const double z1 = fmax(fabs(w1[2]), 1e-12), z2 = fmax(fabs(w2[2]), 1e-12);
        const double value = d1 * d2 * d3 / (16 * z1 * z2) *
                             heights(from->lambda, mcv_smith(alpha, z1), w1[2] > 0,
                                     mcv_smith(alpha, z2), w2[2] > 0, to->lambda);
        const double p1 = d1 / (4 * from->cosine * (1 + from->lambda)),
                     p3 = d3 / (4 * to->cosine * (1 + to->lambda));
        const double middle = d2 / 4, chances = p1 * p3 +
                                                p1 * middle / mcv_visible_area(alpha, m1) +
                                                p3 * middle / mcv_visible_area(alpha, w2);
        if (chances > 0) sum += value / chances;
    }
    return all * sum / CHOICES;
}

/* Three reflections over two, at every third row and column and some angles; linear interpolation
 * between. */
enum { COARSE = (COSINES + 1) / 3, TURNS = 3 };
static const uint32_t turns[TURNS] = {0, 3, AZIMUTHS - 1};

static void fill_ratios(const surface *work, const float *white,
                        double ratios[COARSE][COARSE][TURNS]) {
    for (uint32_t row = 0; row < COARSE; ++row)
        for (uint32_t column = 0; column <= row; ++column)
            for (uint32_t turn = 0; turn < TURNS; ++turn) {
                const uint32_t r = 3 * row + 1, c = 3 * column + 1;
                const heading *a = &work->nodes[r], *b = &work->nodes[c];
                const double half = mcv_multiple_half(turns[turn], a->cosine + b->cosine),
                             once = once_at(work->alpha, a, b, half);
                const double more = thrice(work->alpha, a, b, 2 * half * half - 1) / once;
                ratios[row][column][turn] = ratios[column][row][turn] =
                    more / fmax((double)white[(r * COSINES + c) * AZIMUTHS + turns[turn]], 1e-12);
            }
}

static double ratio_at(double ratios[COARSE][COARSE][TURNS], uint32_t row, uint32_t column,
                       double entry) {
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
               ratios[low[0] + (k & 1)][low[1] + (k >> 1 & 1)][turn + (k >> 2)];
    }
    return sum;
}

/*
 * shares[b] is the light, from the direction of a row, that white microfacets send towards column b
 * by three reflections, as the device interpolates. `white` holds two reflections, one word per
 * entry. ratios == NULL: by two reflections.
 */
static void follow(double alpha, const heading *from, const float *white,
                   double ratios[COARSE][COARSE][TURNS], uint32_t row, double shares[COSINES]) {
    const double o[3] = {from->sine, 0, from->cosine};
    memset(shares, 0, COSINES * sizeof *shares);
    for (int f = 0; f < RADII * ANGLES; ++f) {
        const int around = f / RADII;
        const double left = (f % RADII + 0.5) / RADII, angle = pi * (around + 0.5) / ANGLES,
                     turn[2] = {cos(angle), sin(angle)};
        double w[3], c, h[3];
        mcv_reflect_by_facet(alpha, o, left, turn, w, &c, h);
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
            const float *at = white + (row * COSINES + column + k) * AZIMUTHS + first;
            const double value = (at[0] + (entry - first) * (double)(at[1] - at[0])) *
                                 (ratios ? ratio_at(ratios, row, column + k, entry) : 1);
            shares[column + k] +=
                kept / FACETS * value * (k ? place - column : 1 - (place - column));
        }
    }
}

/*
 * Three and more reflections over three are r(o) r(i); r >= 1 is chosen so that white microfacets
 * lose no light at any angle. Returns the mean after one reflection.
 */
static double find_rest(const surface *work, const float *white,
                        double ratios[COARSE][COARSE][TURNS], double r[COSINES]) {
    enum { ROUNDS = 40 };
    double shares[COSINES][COSINES], left[COSINES], mean = 0, weights = 0;
    for (uint32_t row = 0; row < COSINES; ++row) {
        double counted[3], sum = 0;
        follow(work->alpha, &work->nodes[row], white, ratios, row, shares[row]);
        count_reflections(work->alpha, &work->nodes[row], counted);
        for (uint32_t b = 0; b < COSINES; ++b) sum += shares[row][b];
        left[row] = counted[2];
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
            for (uint32_t b = 0; b < COSINES; ++b) sum += shares[row][b] * r[b];
            r[row] = sum > 0 ? fmin(fmax(sqrt(r[row] * left[row] / sum), 1), 2) : 1;
        }
    return mean / weights;
}

/* Fills the words of all entries, without three and more reflections; `white` gets the second
 * reflection of white microfacets. */
static void fill_twice(const surface *work, float *table, float *white) {
    for (uint32_t row = 0; row < COSINES; ++row)
        for (uint32_t column = 0; column <= row; ++column)
            for (uint32_t entry = 0; entry < AZIMUTHS; ++entry) {
                const heading *a = &work->nodes[row], *b = &work->nodes[column];
                const double half = mcv_multiple_half(entry, a->cosine + b->cosine),
                             c = 2 * half * half - 1, s = sqrt(fmax(1 - c * c, 0));
                const double once = once_at(work->alpha, a, b, half);
                double sums[WORDS + 1] = {0};
                add_twice(work, a, b, c, s, sums);
                add_twice(work, b, a, c, s, sums);
                float *const at[2] = {entry_at(table, row, column, entry),
                                      entry_at(table, column, row, entry)};
                for (int side = 0; side < 2; ++side) {
                    for (int k = 0; k < WORDS; ++k) at[side][k] = (float)(sums[k] / once);
                    white[(at[side] - table) / WORDS] = (float)(sums[WORDS] / once);
                }
            }
}

double mcv_more_reflections(double reflectance, double left) {
    return reflectance * (1 - left) / (1 - reflectance * left);
}

bool mcv_multiple_reflection(double alpha, const double *n, const double *k, float *table) {
    surface *work = malloc(sizeof *work);
    float *white = malloc(sizeof *white * COSINES * COSINES * AZIMUTHS);
    double r[COSINES], more[3], ratios[COARSE][COARSE][TURNS];
    if (work && white) {
        work->alpha = alpha;
        work->channels = n ? 3 : 0;
        for (uint32_t c = 0; c < work->channels; ++c)
            for (uint32_t step = 0; step < STEPS + 2; ++step)
                work->reflectance[c][step] =
                    mcv_conductor_fresnel((float)n[c], (float)k[c], fminf((float)step / STEPS, 1));
        for (uint32_t row = 0; row < COSINES; ++row)
            fill_node(alpha, mcv_multiple_cosine(row, COSINES), &work->nodes[row]);
        fill_twice(work, table, white);
        fill_ratios(work, white, ratios);
        const double left = find_rest(work, white, ratios, r);
        for (uint32_t c = 0; c < work->channels; ++c)
            more[c] = mcv_more_reflections(mcv_conductor_mean(n[c], k[c]), left);
        for (uint32_t entry = 0; entry < COSINES * COSINES * AZIMUTHS; ++entry) {
            const uint32_t row = entry / AZIMUTHS / COSINES, column = entry / AZIMUTHS % COSINES;
            const double rest =
                r[row] * r[column] * ratio_at(ratios, row, column, entry % AZIMUTHS);
            float *at = table + (size_t)WORDS * entry;
            for (uint32_t c = 0; c < work->channels; ++c)
                at[c] = (float)((double)at[c] * (1 + rest * more[c]));
            at[WORDS - 1] = (float)((double)white[entry] * rest);
        }
    }
    const bool made = work && white;
    free(work);
    free(white);
    return made;
}
