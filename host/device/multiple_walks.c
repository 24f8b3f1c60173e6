/* SPDX-License-Identifier: Apache-2.0 */
#include "device/multiple_walks.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "device/microsurface.h"

static const double pi = 3.14159265358979323846;

/* Light on its random walk, in a frame in which its current medium lies above. */
typedef struct walker {
    double back[3]; /* direction it comes from */
    double below;   /* the share of the surface below it */
    double weight;  /* remaining weight */
    double begun,
        first_seen; /* density of the first meeting; area that is visible from the second */
    int side;       /* 0: the side where it started */
} walker;

/* splitmix64, as a number in (0, 1). */
static double unit(uint64_t *state) {
    uint64_t x = *state += 0x9e3779b97f4a7c15U;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9U;
    x = (x ^ x >> 27) * 0x94d049bb133111ebU;
    return ((double)((x ^ x >> 31) >> 11) + 0.5) * 0x1p-53;
}

/*
 * What the microfacet at which light is sends to the goals. Each path is found from either end, by
 * walks whose meetings but the first and the last have the same density.
 */
static void send(const mcv_facet_interface *at, const mcv_goals *goals, int start, uint32_t row,
                 const walker *w, mcv_goal_sums sums) {
    mcv_facet_light light = {.back = {w->back[0], w->back[1], w->back[2]}, .side = w->side};
    const double seen = mcv_visible_area((const double[2]){at->alpha, at->alpha}, w->back);
    const double forced = w->back[2] > 0 ? 1 - pow(w->below, mcv_smith(at->alpha, w->back[2])) : 1;
    for (uint32_t column = 0; column < goals->nodes; ++column)
        for (int passes = 0; passes < 2; ++passes) {
            const mcv_goal_node *to = &goals->node[column];
            const double escapes = pow(passes ? 1 - w->below : w->below, to->lambda) / to->cosine;
            light.here[passes][column] = (float)(2 * w->weight * escapes / seen);
            light.there[passes][column] =
                (float)fmin(escapes * w->first_seen / (forced * w->begun * seen), 1e30);
        }
    mcv_facet_send(at, goals, start, row, &light, sums);
}

/*
 * Light meets a microfacet and is reflected or refracted. `chances` choose the microfacet and,
 * unless `reflects` is given as 1 or 0, the event.
 */
static void turn_by_facet(const mcv_facet_interface *at, int start, walker *w,
                          const double chances[3], int reflects, bool first) {
    const int own = start ^ w->side;
    const double angle = 2 * pi * chances[1], turn[2] = {cos(angle), sin(angle)},
                 eta = at->n[own] / at->n[!own];
    double o[3], c, h[3];
    memcpy(o, w->back, sizeof o);
    mcv_reflect_by_facet((const double[2]){at->alpha, at->alpha}, o, sqrt(chances[0]), turn,
                         w->back, &c, h);
    const double share = (double)mcv_facet_reflects(at, own, (float)c);
    const double density = mcv_facet_density(at->alpha, h[2] * h[2]);
    if (!first) reflects = chances[2] < share;
    if (first) w->weight = 2 * (reflects ? share : 1 - share);
    if (reflects) {
        for (int k = 0; k < 3; ++k) w->back[k] = -w->back[k];
        if (first) w->begun *= density / (8 * at->n[own] * at->n[own]);
    } else {
        const double behind = sqrt(fmax(1 - eta * eta * (1 - c * c), 0)),
                     length = at->n[own] * c - at->n[!own] * behind;
        for (int k = 0; k < 3; ++k)
            w->back[k] = (eta * o[k] - (eta * c - behind) * h[k]) * (k == 2 ? -1 : 1);
        w->below = 1 - w->below;
        w->side = !w->side;
        if (first) w->begun *= 0.5 * density * c * behind / (length * length);
    }
}

/*
 * A walk's numbers in (0, 1): of a lattice of rank 1. Of 1500 generators of Korobov's kind, its has
 * the least P2 in 12 dimensions of weight 0.2; numbers beyond its dimensions are random.
 */
enum { LATTICE = 12281, GENERATOR = 5145, DIMENSIONS = 15 };

typedef struct numbers {
    uint32_t point, power;
    int used;
    uint64_t state;
} numbers;

static double next(numbers *n) {
    if (n->used++ >= DIMENSIONS) return unit(&n->state);
    n->power = n->power * GENERATOR % LATTICE;
    return fmod((n->point * n->power % LATTICE + 0.5) / LATTICE + 0.38 * n->used, 1);
}

/*
 * Moves light to the next microfacet; the first time with certainty, because light that leaves
 * before is counted elsewhere. False: it leaves.
 */
static bool go_on(const mcv_facet_interface *at, walker *w, bool first, double chance) {
    const double l = mcv_smith(at->alpha, fmax(fabs(w->back[2]), 1e-12));
    const bool up = w->back[2] < 0;
    if (first && up) {
        const double leaves = pow(w->below, l);
        w->weight *= 1 - leaves;
        w->begun /= 1 - leaves;
        chance = leaves + (1 - leaves) * chance;
    }
    const double left = up ? pow(chance, 1 / fmax(l, 1e-12)) : pow(chance, -1 / (1 + l));
    if (up && w->below >= left && !first) return false;
    w->below = fmin(w->below / left, 1);
    return w->weight > 0 && w->begun > 0;
}

void mcv_walk(const mcv_facet_interface *at, const mcv_goals *goals, int start, uint32_t row,
              mcv_goal_sums sums) {
    enum { MEETINGS = 60, WALKS = 2 * LATTICE };
    const mcv_goal_node *from = &goals->node[row];
    for (uint32_t number = 0; number < WALKS; ++number) {
        numbers n = {.point = number / 2, .power = 1, .state = number};
        double chances[3] = {0};
        walker w = {.back = {from->sine, 0, from->cosine},
                    .below = pow(next(&n), 1 / (1 + from->lambda))};
        w.begun = pow(w.below, from->lambda) / from->cosine;
        for (int k = 0; k < 2; ++k) chances[k] = next(&n);
        /* Steep microfacets send light where single scattering brings little. */
        const double steep = chances[0], taken_back = 3 * steep * steep;
        chances[0] = steep * steep * steep;
        turn_by_facet(at, start, &w, chances, (int)(number & 1), true);
        w.weight *= taken_back / WALKS;
        if (!(w.weight > 0)) continue;
        const double leaving[3] = {-w.back[0], -w.back[1], -w.back[2]};
        w.first_seen = mcv_visible_area((const double[2]){at->alpha, at->alpha}, leaving);
        for (int meeting = 2; meeting < MEETINGS && go_on(at, &w, meeting == 2, next(&n));
             ++meeting) {
            if (meeting > 2) send(at, goals, start, row, &w, sums);
            for (int k = 0; k < 3; ++k) chances[k] = next(&n);
            turn_by_facet(at, start, &w, chances, 0, false);
        }
    }
}
