/* SPDX-License-Identifier: Apache-2.0 */
#include "device/multiple_two.h"

#include <math.h>
#include <stdbool.h>

#include "device/microsurface.h"

static const double pi = 3.14159265358979323846;

/* Rows are filled by several threads; lgamma would share its sign. */
static double beta(double x, double y) {
    int sign;
    return exp(lgamma_r(x, &sign) + lgamma_r(y, &sign) - lgamma_r(x + y, &sign));
}

/*
 * ∫∫ y^l x^-(1+l) A(y) B(x) dy dx over 0 < y < x < 1: heights of two microfacets, as shares of the
 * surface below them, that see each other. A(y) is y^a, or (1-y)^a where that end passes; B(x) is
 * x^b or (1-x)^b.
 */
static double mean_height(bool a_passes, double a, bool b_passes, double b, double l) {
    enum { POINTS = 8 };
    static const double at[POINTS] = {0.01985507175123188, 0.1016667612931866, 0.2372337950418355,
                                      0.4082826787521751,  0.5917173212478249, 0.7627662049581645,
                                      0.8983332387068134,  0.9801449282487681},
                        weight[POINTS] = {0.05061426814518813, 0.1111905172266872,
                                          0.1568533229389437,  0.181341891689181,
                                          0.181341891689181,   0.1568533229389437,
                                          0.1111905172266872,  0.05061426814518813};
    if (!a_passes && !b_passes) return 1 / ((1 + a + l) * (1 + a + b));
    if (!a_passes) return beta(1 + a, 1 + b) / (1 + a + l);
    if (!b_passes) { /* the limit for b = l is taken by a small step */
        const double step = fabs(b - l) < 1e-4 ? 1e-4 : b - l;
        return (beta(1 + b - step, 1 + a) - beta(1 + b, 1 + a)) / step;
    }
    double sum = 0; /* Gauss and Legendre's, over x and y/x, in which the powers are even */
    for (int i = 0; i < POINTS; ++i) {
        const double x = 1 - pow(at[i], 1 / (1 + b));
        for (int j = 0; j < POINTS; ++j)
            sum += weight[i] * weight[j] * pow(1 - x * pow(at[j], 1 / (1 + l)), a);
    }
    return sum / ((1 + b) * (1 + l));
}

void mcv_heights_fill(const mcv_goals *goals, uint32_t row, mcv_heights heights) {
    for (uint32_t k = 0; k < 8 * goals->nodes * MCV_HEIGHT_STEPS; ++k) {
        const uint32_t step = k % MCV_HEIGHT_STEPS, column = k / MCV_HEIGHT_STEPS % goals->nodes,
                       way = k / (MCV_HEIGHT_STEPS * goals->nodes);
        const bool first = way & 1, up = way & 2, second = way & 4;
        const double x = fmin((double)step / (MCV_HEIGHT_STEPS - 1), 0.9999), l = x / (1 - x),
                     a = goals->node[row].lambda, b = goals->node[column].lambda;
        heights[first][up][second][column][step] =
            (float)((1 + l) * (up ? mean_height(first, a, second, b, l)
                                  : mean_height(second, b, first, a, l)));
    }
}

/* Light after its first microfacet: the weight of what is left, that microfacet's lobe, Λ. */
typedef struct first_meeting {
    mcv_facet_light light;
    double weight, lobe, lambda;
} first_meeting;

/* The visible microfacet of a choice; false: it sends nothing there. */
static bool meet_first(const mcv_facet_interface *at, const mcv_goal_node *from, int start,
                       bool passes, double left, double angle, first_meeting *m) {
    const double alphas[2] = {at->alpha, at->alpha}, o[3] = {from->sine, 0, from->cosine},
                 turn[2] = {cos(angle), sin(angle)}, eta = at->n[start] / at->n[!start];
    double w[3], c, h[3];
    mcv_reflect_by_facet(alphas, o, left, turn, w, &c, h);
    const double share = (double)mcv_facet_reflects(at, start, (float)c),
                 density = mcv_facet_density(at->alpha, h[2] * h[2]);
    m->light.side = passes;
    m->weight = passes ? 1 - share : share;
    if (passes) {
        const double behind = sqrt(fmax(1 - eta * eta * (1 - c * c), 0)),
                     length = at->n[start] * c - at->n[!start] * behind;
        for (int k = 0; k < 3; ++k)
            m->light.back[k] = (eta * o[k] - (eta * c - behind) * h[k]) * (k == 2 ? -1 : 1);
        m->lobe = 0.5 * density * c * behind / (length * length);
    } else {
        for (int k = 0; k < 3; ++k) m->light.back[k] = -w[k];
        m->lobe = density / (8 * at->n[start] * at->n[start]);
    }
    m->lambda = mcv_smith(at->alpha, fmax(fabs(m->light.back[2]), 1e-12));
    return m->weight > 0 && m->lobe > 0;
}

/* The share of the light that leaves after its first microfacet. */
static double leaves_at_once(double from, const first_meeting *m) {
    if (m->light.back[2] > 0) return 0;
    return (1 + from) *
           (m->light.side ? beta(1 + from, 1 + m->lambda) : 1 / (1 + from + m->lambda));
}

/* What the second microfacet does, for all goals: means over the heights. */
static void weigh(const mcv_goals *goals, uint32_t row, mcv_heights table, first_meeting *m) {
    const mcv_goal_node *from = &goals->node[row];
    const double seen = from->cosine * (1 + from->lambda),
                 x = fmin(m->lambda / (1 + m->lambda), 0.9999) * (MCV_HEIGHT_STEPS - 1),
                 scale = 2 * m->weight * (1 + from->lambda) /
                         ((1 + m->lambda) * fmax(fabs(m->light.back[2]), 1e-12));
    const uint32_t step = (uint32_t)fmin(x, MCV_HEIGHT_STEPS - 2);
    for (uint32_t column = 0; column < goals->nodes; ++column)
        for (int passes = 0; passes < 2; ++passes) {
            const mcv_goal_node *to = &goals->node[column];
            const float *mean = table[m->light.side][m->light.back[2] < 0][passes][column] + step;
            m->light.here[passes][column] =
                (float)(scale / to->cosine *
                        ((double)mean[0] + (x - step) * (double)(mean[1] - mean[0])));
            m->light.there[passes][column] =
                (float)fmin(seen / (to->cosine * (1 + to->lambda) * m->lobe), 1e30);
        }
}

double mcv_meet_twice(const mcv_facet_interface *at, const mcv_goals *goals, int start,
                      uint32_t row, mcv_heights heights, mcv_goal_sums sums) {
    enum { FACETS = 233 }; /* visible ones, on a Fibonacci lattice */
    double goes_on = 0;
    for (int choice = 0; choice < 2 * FACETS; ++choice) {
        const int number = choice / 2;
        const double left = (number + 0.5) / FACETS,
                     angle = 2 * pi * fmod(0.31 + 0.6180339887498949 * number, 1);
        first_meeting m = {.weight = 0};
        if (!meet_first(at, &goals->node[row], start, choice % 2, left, angle, &m)) continue;
        m.weight *= 2 * left / FACETS;
        goes_on += m.weight * (1 - leaves_at_once(goals->node[row].lambda, &m));
        weigh(goals, row, heights, &m);
        mcv_facet_send(at, goals, start, row, &m.light, sums);
    }
    return goes_on;
}
