/* SPDX-License-Identifier: Apache-2.0 */
#include "device/multiple_orders.h"

#include <math.h>
#include <stdbool.h>

#include "device/microsurface.h"

static const double pi = 3.14159265358979323846;

void mcv_facet_metal_fill(const double *n, const double *k, mcv_facet_metal *metal) {
    metal->channels = n ? 3 : 0;
    for (uint32_t c = 0; c < metal->channels; ++c)
        for (uint32_t step = 0; step < MCV_FACET_STEPS + 2; ++step)
            metal->reflectance[c][step] = mcv_conductor_fresnel(
                (float)n[c], (float)k[c], fminf((float)step / MCV_FACET_STEPS, 1));
}

static float reflectance(const float *steps, float c) {
    const float x = c * (float)MCV_FACET_STEPS;
    const uint32_t step = (uint32_t)x;
    return steps[step] + (x - (float)step) * (steps[step + 1] - steps[step]);
}

void mcv_add_two_reflections(const mcv_facet_metal *metal, double value, float c1, float c2,
                             double sums[MCV_MULTIPLE_WORDS + 1]) {
    sums[MCV_MULTIPLE_WORDS] += value;
    for (uint32_t k = 0; k < metal->channels; ++k)
        sums[k] += value * (double)(reflectance(metal->reflectance[k], c1) *
                                    reflectance(metal->reflectance[k], c2));
    if (metal->channels > 0) return;
    const double a = pow(1 - (double)c1, 5), b = pow(1 - (double)c2, 5);
    sums[0] += value * (1 - a) * (1 - b);
    sums[1] += value * (a + b - 2 * a * b);
    sums[2] += value * a * b;
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
    /* Down, then up: the limits for vanishing values are taken by a small step. */
    double x = o - w1, y = i - w2;
    if (fabs(x) < 1e-4) w1 = o - (x = 1e-4);
    if (fabs(y) < 1e-4) w2 = i - (y = 1e-4);
    return (1 / (1 + w1 + w2) - 1 / (1 + w2 + o) - 1 / (1 + w1 + i) + 1 / all) / (x * y);
}

/* Directions after the first and the second reflection, and D of the three microfacets. */
typedef struct trail {
    double w1[3], w2[3];
    double d1, d2, d3;
} trail;

static void opposite(const double a[3], double b[3]) {
    for (int k = 0; k < 3; ++k) b[k] = -a[k];
}

/* Where two microfacets are chosen among the visible ones. */
typedef struct facet_points {
    double left[2], turn[2][2];
} facet_points;

/* Exact, as fmod(x, 1) is, which takes longer. */
static double fraction(double x) { return x - floor(x); }

/* The point of this number of an additive recurrence. */
static facet_points points_of(int number) {
    static const double steps[4] = {0.85667488385450, 0.73389185662717, 0.62870672005510,
                                    0.53859725722362}; /* g^-k, g^5 = g + 1 */
    double u[4];
    for (int k = 0; k < 4; ++k) u[k] = fraction(0.5 + steps[k] * number);
    return (facet_points){
        {sqrt(u[0]), sqrt(u[2])},
        {{cos(2 * pi * u[1]), sin(2 * pi * u[1])}, {cos(2 * pi * u[3]), sin(2 * pi * u[3])}}};
}

/* which == 0: one microfacet chosen from each end; 1: both from o; 2: both from i. */
static trail choose_trail(const double alpha[2], const double o[3], const double i[3], int which,
                          const facet_points *at) {
    double m1[3] = {0}, m2[3] = {0}, cosine, h[3];
    trail t = {0};
    if (which < 2) {
        mcv_reflect_by_facet(alpha, o, at->left[0], at->turn[0], t.w1, &cosine, h);
        opposite(t.w1, m1);
    } else {
        mcv_reflect_by_facet(alpha, i, at->left[0], at->turn[0], m2, &cosine, h);
        opposite(m2, t.w2);
    }
    if (which == 0) mcv_reflect_by_facet(alpha, i, at->left[1], at->turn[1], m2, &cosine, h);
    if (which == 1) mcv_reflect_by_facet(alpha, m1, at->left[1], at->turn[1], t.w2, &cosine, h);
    if (which == 2) mcv_reflect_by_facet(alpha, t.w2, at->left[1], at->turn[1], m1, &cosine, h);
    if (which == 0) opposite(m2, t.w2);
    if (which == 1) opposite(t.w2, m2);
    if (which == 2) opposite(m1, t.w1);
    t.d1 = mcv_facet_between(alpha, o, t.w1);
    t.d2 = mcv_facet_between(alpha, m1, t.w2);
    t.d3 = mcv_facet_between(alpha, m2, i);
    return t;
}

double mcv_three_reflections(const double alpha[2], const double o[3], const double i[3],
                             int choices, int left_out) {
    const double from = mcv_smith_at(alpha, o), to = mcv_smith_at(alpha, i);
    double sum = 0;
    facet_points at;
    for (int choice = 0; choice < 3 * choices; ++choice) {
        double m1[3];
        if (choice % 3 == 0) at = points_of(choice / 3 + 1 + left_out);
        const trail t = choose_trail(alpha, o, i, choice % 3, &at);
        if (!(t.d1 > 0 && t.d2 > 0 && t.d3 > 0)) continue;
        const double z1 = fmax(fabs(t.w1[2]), 1e-12), z2 = fmax(fabs(t.w2[2]), 1e-12);
        const double value = t.d1 * t.d2 * t.d3 / (16 * z1 * z2) *
                             heights(from, mcv_smith_at(alpha, t.w1), t.w1[2] > 0,
                                     mcv_smith_at(alpha, t.w2), t.w2[2] > 0, to);
        const double p1 = t.d1 / (4 * o[2] * (1 + from)), p3 = t.d3 / (4 * i[2] * (1 + to)),
                     middle = t.d2 / 4;
        opposite(t.w1, m1);
        const double chances = p1 * p3 + p1 * middle / mcv_visible_area(alpha, m1) +
                               p3 * middle / mcv_visible_area(alpha, t.w2);
        if (chances > 0) sum += value / chances;
    }
    return (1 + from + to) * sum / choices;
}

double mcv_more_reflections(double reflectance, double left) {
    return reflectance * (1 - left) / (1 - reflectance * left);
}
