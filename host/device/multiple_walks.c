/* SPDX-License-Identifier: Apache-2.0 */
#include "device/multiple_walks.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "device/microsurface.h"

static const double pi = 3.14159265358979323846;

enum { NODES = MCV_WALK_NODES, TURNS = MCV_WALK_TURNS };

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

/* Reflectance of an interface for light from index n1 at a cosine; eta = n1/n2. */
static inline float reflectance(float eta, float scale, float offset, float c) {
    const float squared = 1 - eta * eta * (1 - c * c), c2 = sqrtf(squared > 0 ? squared : 0);
    const float s = (eta * c - c2) / (eta * c + c2), p = (c - eta * c2) / (c + eta * c2);
    const float r = scale * 0.5F * (s * s + p * p) + offset;
    return squared > 0 ? (r > 0 ? r : 0) : 1;
}

/*
 * A microfacet that sends light of one side towards all goals, and the walks that could have come
 * the other way: adds the BSDF over n² of the goal's side. Each path is found from either end, by
 * walks whose meetings but the first and the last have the same density; the balance heuristic
 * joins them.
 */
static void connect(const mcv_walk_interface *at, int start, uint32_t row, const walker *w,
                    mcv_walk_goals sums) {
    const int own = start ^ w->side;
    const double seen = mcv_visible_area((const double[2]){at->alpha, at->alpha}, w->back);
    const double forced = w->back[2] > 0 ? 1 - pow(w->below, mcv_smith(at->alpha, w->back[2])) : 1;
    const float x = (float)w->back[0], y = (float)w->back[1], z = (float)w->back[2];
    const float n1 = (float)at->n[own], n2 = (float)at->n[!own], eta = n1 / n2;
    const float scale = (float)at->scale[own], offset = (float)at->offset[own];
    const float inverse = (float)(1 / (at->alpha * at->alpha)), peak = (float)(inverse / pi);
    for (uint32_t column = 0; column < NODES; ++column) {
        const mcv_walk_node *to = &at->nodes[column];
        const float *gx = at->x[row][column], *gy = at->y[row][column];
        for (int passes = 0; passes < 2; ++passes) {
            const double escapes = pow(passes ? 1 - w->below : w->below, to->lambda) / to->cosine;
            const float value = (float)(2 * w->weight * escapes / seen);
            const float there =
                (float)fmin(escapes * w->first_seen / (forced * w->begun * seen), 1e30);
            const float a = passes ? n1 : 1, b = passes ? n2 : 1,
                        k = passes ? 0.5F : 0.125F / (n1 * n1);
            const float g_z = (float)(passes ? -to->cosine : to->cosine), h_z = a * z + b * g_z;
            float sent[TURNS];
            for (int turn = 0; turn < TURNS; ++turn) {
                const float h_x = a * x + b * gx[turn], h_y = a * y + b * gy[turn];
                const float across = h_x * h_x + h_y * h_y, squared = across + h_z * h_z;
                const float length = sqrtf(squared) * (h_z < 0 ? -1.0F : 1.0F);
                const float c = (x * h_x + y * h_y + z * h_z) / length;
                const float behind = -(gx[turn] * h_x + gy[turn] * h_y + g_z * h_z) / length;
                const float t = across * inverse + h_z * h_z,
                            d = peak * squared * squared / (t * t);
                const float share = reflectance(eta, scale, offset, c < 1 ? c : 1);
                const float lobe = passes ? d * c * behind / squared : d;
                const int meets = passes ? (c > 0) & (behind > 0) : (h_z > 0) & (c > 0);
                const float chance = k * lobe;
                sent[turn] =
                    meets ? value * (passes ? 1 - share : share) * chance / (1 + chance * there)
                          : 0;
            }
            for (int turn = 0; turn < TURNS; ++turn)
                sums[w->side ^ passes][column][turn] += (double)sent[turn];
        }
    }
}

/*
 * Light meets a microfacet and is reflected or refracted. `chances` choose the microfacet and,
 * unless `reflects` is given as 1 or 0, the event.
 */
static void turn_by_facet(const mcv_walk_interface *at, int start, walker *w,
                          const double chances[3], int reflects, bool first) {
    const int own = start ^ w->side;
    const double angle = 2 * pi * chances[1], turn[2] = {cos(angle), sin(angle)},
                 eta = at->n[own] / at->n[!own];
    double o[3], c, h[3];
    memcpy(o, w->back, sizeof o);
    mcv_reflect_by_facet((const double[2]){at->alpha, at->alpha}, o, sqrt(chances[0]), turn,
                         w->back, &c, h);
    const double share =
        (double)reflectance((float)eta, (float)at->scale[own], (float)at->offset[own], (float)c);
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
 * A walk's numbers in (0, 1): of a lattice of rank 1 with Korobov's generator, which was searched
 * for the least P2 in 12 dimensions; those beyond its dimensions at random.
 */
enum { LATTICE = 1021, GENERATOR = 58, DIMENSIONS = 15 };

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
static bool go_on(const mcv_walk_interface *at, walker *w, bool first, double chance) {
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

double mcv_walk(const mcv_walk_interface *at, int start, uint32_t row, mcv_walk_goals sums) {
    enum { MEETINGS = 60, WALKS = 2 * LATTICE };
    const mcv_walk_node *from = &at->nodes[row];
    double goes_on = 0;
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
        w.weight *= taken_back;
        if (!(w.weight > 0)) continue;
        const double leaving[3] = {-w.back[0], -w.back[1], -w.back[2]};
        w.first_seen = mcv_visible_area((const double[2]){at->alpha, at->alpha}, leaving);
        for (int meeting = 1; meeting < MEETINGS && go_on(at, &w, meeting == 1, next(&n));
             ++meeting) {
            if (meeting == 1) goes_on += w.weight / WALKS;
            connect(at, start, row, &w, sums);
            for (int k = 0; k < 3; ++k) chances[k] = next(&n);
            turn_by_facet(at, start, &w, chances, 0, false);
        }
    }
    for (int k = 0; k < 2 * NODES * TURNS; ++k) (&sums[0][0][0])[k] /= WALKS;
    return goes_on;
}
