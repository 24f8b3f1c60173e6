/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering between the microfacets of an interface (multiple.h), by random walks. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device/albedo.h"
#include "device/microsurface.h"
#include "device/multiple.h"

static const double pi = 3.14159265358979323846;

enum {
    NODES = MCV_INTERFACE_COSINES,
    TURNS = MCV_MULTIPLE_AZIMUTHS,
    WORDS = MCV_MULTIPLE_WORDS,
    OUTSIDE = 0,
    INSIDE = 1
};

typedef struct node {
    double cosine, sine, lambda;
} node;

/* Values for each cosine of a direction on each side, and the angle between two azimuths. */
typedef double goals[2][NODES][TURNS];

typedef struct interface {
    double alpha, n[2], scale[2], offset[2]; /* scale, offset: of the coating (mcv_coat) */
    node nodes[NODES];
    float x[NODES][NODES][TURNS], y[NODES][NODES][TURNS]; /* of a row: directions of columns */
} interface;

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
static void connect(const interface *at, int start, uint32_t row, const walker *w, goals sums) {
    const int own = start ^ w->side;
    const double seen = mcv_visible_area((const double[2]){at->alpha, at->alpha}, w->back);
    const double forced = w->back[2] > 0 ? 1 - pow(w->below, mcv_smith(at->alpha, w->back[2])) : 1;
    const float x = (float)w->back[0], y = (float)w->back[1], z = (float)w->back[2];
    const float n1 = (float)at->n[own], n2 = (float)at->n[!own], eta = n1 / n2;
    const float scale = (float)at->scale[own], offset = (float)at->offset[own];
    const float inverse = (float)(1 / (at->alpha * at->alpha)), peak = (float)(inverse / pi);
    for (uint32_t column = 0; column < NODES; ++column) {
        const node *to = &at->nodes[column];
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
static void turn_by_facet(const interface *at, int start, walker *w, const double chances[3],
                          int reflects, bool first) {
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
static bool go_on(const interface *at, walker *w, bool first, double chance) {
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

/*
 * Light that walks from the direction of a row until it leaves (Heitz and others 2016): adds what
 * each meeting but the first sends to the goals. Half the walks reflect first, half refract.
 * Returns the share that goes on after one meeting.
 */
static double walk(const interface *at, int start, uint32_t row, goals sums) {
    enum { MEETINGS = 60, WALKS = 2 * LATTICE };
    const node *from = &at->nodes[row];
    double goes_on = 0;
    for (uint32_t number = 0; number < WALKS; ++number) {
        numbers n = {.point = number / 2, .power = 1, .state = number};
        double chances[3] = {0};
        walker w = {.back = {from->sine, 0, from->cosine},
                    .below = pow(next(&n), 1 / (1 + from->lambda))};
        w.begun = pow(w.below, from->lambda) / from->cosine;
        for (int k = 0; k < 2; ++k) chances[k] = next(&n);
        turn_by_facet(at, start, &w, chances, (int)(number & 1), true);
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

/* A place in a table: row or column of a cosine, entry of an azimuth, and how far it is to the
 * next. */
typedef struct place {
    uint32_t at;
    double share;
} place;

static place between(double x, uint32_t count) {
    const uint32_t at = (uint32_t)fmin(x, count - 2);
    return (place){at, x - at};
}

/*
 * Adds up what the entries of one side send from a row's direction towards each column, as the
 * device interpolates: reflection by the visible microfacets, transmission by the hemisphere.
 */
static void follow_near(const interface *at, const double *words, uint32_t row,
                        double columns[NODES]) {
    enum { RADII = 24, ANGLES = 24 };
    const node *from = &at->nodes[row];
    const double o[3] = {from->sine, 0, from->cosine};
    for (int f = 0; f < RADII * ANGLES; ++f) {
        const int ring = f % RADII, sector = f / RADII;
        const double left = (ring + 0.5) / RADII, angle = pi * (sector + 0.5) / ANGLES,
                     turn[2] = {cos(angle), sin(angle)};
        double w[3], h[3], c;
        mcv_reflect_by_facet((const double[2]){at->alpha, at->alpha}, o, left, turn, w, &c, h);
        if (!(w[2] > 0)) continue;
        const double z = fmin(w[2], 1), across = hypot(w[0], w[1]),
                     half = across > 0 ? sqrt(fmax(0.5 + 0.5 * w[0] / across, 0)) : 1;
        const double kept = 2 * left * (1 + from->lambda) /
                            (1 + from->lambda + mcv_smith(at->alpha, z)) / (RADII * ANGLES);
        const place column = between(mcv_multiple_place(z, NODES), NODES),
                    entry = between(mcv_multiple_entry(half, from->cosine + z), TURNS);
        for (uint32_t k = 0; k < 2; ++k) {
            const double *word = words + (row * NODES + column.at + k) * TURNS + entry.at;
            columns[column.at + k] += kept * (k ? column.share : 1 - column.share) *
                                      (word[0] + entry.share * (word[1] - word[0]));
        }
    }
}

static void follow_far(const interface *at, const double *words, uint32_t row,
                       double columns[NODES]) {
    enum { STEPS = 4 * (NODES - 1), ANGLES = 32 };
    const node *from = &at->nodes[row];
    double low = 0;
    for (int step = 0; step < STEPS; ++step) {
        const double next =
                         step < STEPS - 1 ? mcv_multiple_cosine((uint32_t)step + 1, STEPS + 1) : 1,
                     z = 0.5 * (low + next);
        const double weight = 2 * pi * (next - low) / ANGLES /
                              (from->cosine * (1 + from->lambda) * (1 + mcv_smith(at->alpha, z)));
        const place column = between(mcv_multiple_place(z, NODES), NODES);
        for (int turn = 0; turn < ANGLES; ++turn) {
            const double half = fabs(cos(0.5 * pi * (turn + 0.5) / ANGLES));
            const place entry = between(mcv_multiple_entry(half, from->cosine + z), TURNS);
            for (uint32_t k = 0; k < 2; ++k) {
                const double *word = words + (row * NODES + column.at + k) * TURNS + entry.at;
                columns[column.at + k] += weight * (k ? column.share : 1 - column.share) *
                                          (word[0] + entry.share * (word[1] - word[0]));
            }
        }
        low = next;
    }
}

/* Entries of both sides, near and far: [side][far]. */
typedef double entries[2][2][NODES][NODES][TURNS];

/*
 * Scales the entries by r(o) r(i) so that the light after several meetings equals the light that
 * does not leave at the first. The walks know this sum well; interpolation has errors. The factors
 * preserve reciprocity.
 */
static void complete(const interface *at, double goes_on[2][NODES], entries all) {
    enum { ROUNDS = 40 };
    double columns[2][NODES][2][NODES] = {{{{0}}}}, r[2][NODES];
    for (uint32_t k = 0; k < 2 * NODES; ++k) {
        const uint32_t side = k / NODES, row = k % NODES;
        follow_near(at, &all[side][0][0][0][0], row, columns[side][row][0]);
        follow_far(at, &all[side][1][0][0][0], row, columns[side][row][1]);
        r[side][row] = 1;
    }
    for (uint32_t k = 0; k < ROUNDS * 2 * NODES; ++k) {
        const uint32_t side = k / NODES % 2, row = k % NODES;
        double sum = 0;
        for (uint32_t column = 0; column < NODES; ++column)
            sum += columns[side][row][0][column] * r[side][column] +
                   columns[side][row][1][column] * r[!side][column];
        if (sum > 0)
            r[side][row] = fmin(fmax(sqrt(r[side][row] * goes_on[side][row] / sum), 0.5), 2);
    }
    for (uint32_t k = 0; k < 4 * NODES * NODES * TURNS; ++k) {
        const uint32_t side = k / (2 * NODES * NODES * TURNS),
                       far = k / (NODES * NODES * TURNS) % 2;
        (&all[0][0][0][0][0])[k] *=
            r[side][k / (NODES * TURNS) % NODES] * r[side ^ far][k / TURNS % NODES];
    }
}

/* The unit of an entry: see mcv_multiple_interface. */
static double unit_of(const interface *at, uint32_t far, uint32_t row, uint32_t column,
                      uint32_t turn) {
    const node *from = &at->nodes[row], *to = &at->nodes[column];
    if (far) return 1 / (from->cosine * (1 + from->lambda) * (1 + to->lambda));
    const double x = from->sine + (double)at->x[row][column][turn],
                 y = (double)at->y[row][column][turn], z = from->cosine + to->cosine;
    return mcv_facet_density(at->alpha, z * z / (x * x + y * y + z * z)) /
           (4 * from->cosine * (1 + from->lambda + to->lambda));
}

static void fill(const interface *at, goals sums[2][NODES], double goes_on[2][NODES], entries all) {
    for (uint32_t k = 0; k < 4 * NODES * NODES * TURNS; ++k) {
        const uint32_t side = k / (2 * NODES * NODES * TURNS),
                       far = k / (NODES * NODES * TURNS) % 2, turn = k % TURNS;
        const uint32_t row = k / (NODES * TURNS) % NODES, column = k / TURNS % NODES;
        double sum = sums[side][row][far][column][turn] + sums[side ^ far][column][far][row][turn];
        if (row == NODES - 1 ||
            column == NODES - 1) { /* at normal incidence azimuths have no meaning */
            sum = 0;
            for (uint32_t each = 0; each < TURNS; ++each)
                sum += (sums[side][row][far][column][each] +
                        sums[side ^ far][column][far][row][each]) /
                       TURNS;
        }
        const double n = at->n[side ^ far];
        all[side][far][row][column][turn] =
            n * n * at->nodes[column].cosine * sum / unit_of(at, far, row, column, turn);
    }
    complete(at, goes_on, all);
}

static void prepare(interface *at, double coating) {
    for (int side = 0; side < 2; ++side)
        mcv_coat(coating, at->n[side] / at->n[!side], 1, &at->scale[side], &at->offset[side]);
    for (uint32_t k = 0; k < NODES; ++k) {
        const double cosine = mcv_multiple_cosine(k, NODES);
        at->nodes[k] = (node){cosine, sqrt(1 - cosine * cosine), mcv_smith(at->alpha, cosine)};
    }
    for (uint32_t k = 0; k < NODES * NODES * TURNS; ++k) {
        const uint32_t row = k / (NODES * TURNS), column = k / TURNS % NODES, turn = k % TURNS;
        const double half =
                         mcv_multiple_half(turn, at->nodes[row].cosine + at->nodes[column].cosine),
                     c = 2 * half * half - 1;
        at->x[row][column][turn] = (float)(at->nodes[column].sine * c);
        at->y[row][column][turn] = (float)(at->nodes[column].sine * sqrt(fmax(1 - c * c, 0)));
    }
}

uint32_t mcv_interface_words(void) { return WORDS * NODES * NODES * TURNS; }

bool mcv_multiple_interface(double alpha, double n_outside, double n_inside, double coating,
                            float *table) {
    interface *at = malloc(sizeof *at);
    goals(*sums)[NODES] = calloc(2, sizeof *sums);
    double(*all)[2][NODES][NODES][TURNS] = malloc(sizeof(entries));
    const bool made = at && sums && all;
    if (made) {
        double goes_on[2][NODES];
        *at = (interface){.alpha = alpha, .n = {n_outside, n_inside}};
        prepare(at, coating);
        for (uint32_t k = 0; k < 2 * NODES; ++k)
            goes_on[k / NODES][k % NODES] =
                walk(at, (int)(k / NODES), k % NODES, sums[k / NODES][k % NODES]);
        fill(at, sums, goes_on, all);
        for (uint32_t k = 0; k < 4 * NODES * NODES * TURNS;
             ++k) /* words: near from both sides, then far */
            table[k % (NODES * NODES * TURNS) * WORDS + k / (2 * NODES * NODES * TURNS) +
                  2 * (k / (NODES * NODES * TURNS) % 2)] = (float)(&all[0][0][0][0][0])[k];
    }
    free(at);
    free(sums);
    free(all);
    return made;
}
