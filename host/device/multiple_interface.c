/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering between the microfacets of an interface (multiple.h), by random walks. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/parallel.h"
#include "device/albedo.h"
#include "device/microsurface.h"
#include "device/multiple.h"
#include "device/multiple_walks.h"

static const double pi = 3.14159265358979323846;

enum { NODES = MCV_WALK_NODES, TURNS = MCV_WALK_TURNS, WORDS = MCV_MULTIPLE_WORDS };

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

/* The entry of the angle between two azimuths, by |cos φ/2| and the sum of the cosines. */
static double entry_of(double half, double sum) {
    return (TURNS - 1) * (double)mcv_interface_turn((float)half,
                                                    (float)sqrt(fmax(1 - half * half, 0)),
                                                    (float)sum + MCV_MULTIPLE_LEAST);
}

/* The |cos φ/2| of an entry, by bisection. */
static double half_of(uint32_t entry, double sum) {
    double low = 0, high = 1;
    for (int round = 0; round < 24 && entry < TURNS - 1; ++round) {
        const double half = 0.5 * (low + high);
        *(entry_of(half, sum) < entry ? &low : &high) = half;
    }
    return high;
}

/* What the roots of a row send towards a place, as the device interpolates, by columns. */
static void add_between(const double *roots, place column, place entry, double weight,
                        double columns[NODES]) {
    double parts[2];
    for (uint32_t k = 0; k < 2; ++k) {
        const double *root = roots + (column.at + k) * TURNS + entry.at;
        parts[k] =
            (k ? column.share : 1 - column.share) * (root[0] + entry.share * (root[1] - root[0]));
    }
    const double sum = parts[0] + parts[1];
    for (uint32_t k = 0; k < 2; ++k) columns[column.at + k] += weight * sum * sum * sum * parts[k];
}

/*
 * Adds up what the entries of one side send from a row's direction towards each column: reflection
 * by the visible microfacets, transmission by the hemisphere. Light that meets several microfacets
 * goes far from the mirror's direction; left = v² puts points there.
 */
static void follow_near(const mcv_walk_interface *at, const double *roots, uint32_t row,
                        double columns[NODES]) {
    enum { RADII = 24, ANGLES = 24 };
    const mcv_walk_node *from = &at->nodes[row];
    const double o[3] = {from->sine, 0, from->cosine};
    for (int f = 0; f < RADII * ANGLES; ++f) {
        const int ring = f % RADII, sector = f / RADII;
        const double v = (ring + 0.5) / RADII, angle = pi * (sector + 0.5) / ANGLES,
                     turn[2] = {cos(angle), sin(angle)};
        double w[3], h[3], c;
        mcv_reflect_by_facet((const double[2]){at->alpha, at->alpha}, o, v * v, turn, w, &c, h);
        if (!(w[2] > 0)) continue;
        const double z = fmin(w[2], 1), across = hypot(w[0], w[1]),
                     half = across > 0 ? sqrt(fmax(0.5 + 0.5 * w[0] / across, 0)) : 1;
        const double kept = 4 * v * v * v * (1 + from->lambda) /
                            (1 + from->lambda + mcv_smith(at->alpha, z)) / (RADII * ANGLES);
        add_between(roots + (size_t)row * NODES * TURNS,
                    between(mcv_multiple_place(z, NODES), NODES),
                    between(entry_of(half, from->cosine + z), TURNS), kept, columns);
    }
}

static void follow_far(const mcv_walk_interface *at, const double *roots, uint32_t row,
                       double columns[NODES]) {
    enum { STEPS = 4 * (NODES - 1), ANGLES = 32 };
    const mcv_walk_node *from = &at->nodes[row];
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
            add_between(roots + (size_t)row * NODES * TURNS, column,
                        between(entry_of(half, from->cosine + z), TURNS), weight, columns);
        }
        low = next;
    }
}

/* Entries of both sides, near and far: [side][far]; their roots. */
typedef double entries[2][2][NODES][NODES][TURNS];

/*
 * Scales the entries by r(o) r(i) so that the light after several meetings equals the light that
 * does not leave at the first. The walks know this sum well; interpolation has errors. The factors
 * preserve reciprocity. Where a share g of the light goes on, r is 1 ± g at most: of little light
 * the entries are better known than their sum.
 */
static void complete(const mcv_walk_interface *at, double goes_on[2][NODES], entries all) {
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
        const double g = goes_on[side][row], spread = fmin(g, 0.5);
        if (sum > 0)
            r[side][row] = fmin(fmax(sqrt(r[side][row] * g / sum), 1 - spread), 1 + spread);
    }
    for (uint32_t k = 0; k < 4 * NODES * NODES * TURNS; ++k) {
        const uint32_t side = k / (2 * NODES * NODES * TURNS),
                       far = k / (NODES * NODES * TURNS) % 2;
        (&all[0][0][0][0][0])[k] *=
            sqrt(sqrt(r[side][k / (NODES * TURNS) % NODES] * r[side ^ far][k / TURNS % NODES]));
    }
}

/* The unit of an entry: see mcv_multiple_interface. */
static double unit_of(const mcv_walk_interface *at, uint32_t far, uint32_t row, uint32_t column,
                      uint32_t turn) {
    const mcv_walk_node *from = &at->nodes[row], *to = &at->nodes[column];
    if (far) return 1 / (from->cosine * (1 + from->lambda) * (1 + to->lambda));
    const double x = from->sine + (double)at->x[row][column][turn],
                 y = (double)at->y[row][column][turn], z = from->cosine + to->cosine;
    return mcv_facet_density(at->alpha, z * z / (x * x + y * y + z * z)) /
           (4 * from->cosine * (1 + from->lambda + to->lambda));
}

static void fill(const mcv_walk_interface *at, mcv_walk_goals sums[2][NODES],
                 double goes_on[2][NODES], entries all) {
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
        all[side][far][row][column][turn] = sqrt(
            sqrt(n * n * at->nodes[column].cosine * sum / unit_of(at, far, row, column, turn)));
    }
    complete(at, goes_on, all);
}

static void prepare(mcv_walk_interface *at, double coating) {
    for (int side = 0; side < 2; ++side)
        mcv_coat(coating, at->n[side] / at->n[!side], 1, &at->scale[side], &at->offset[side]);
    for (uint32_t k = 0; k < NODES; ++k) {
        const double cosine = mcv_multiple_cosine(k, NODES);
        at->nodes[k] =
            (mcv_walk_node){cosine, sqrt(1 - cosine * cosine), mcv_smith(at->alpha, cosine)};
    }
    for (uint32_t k = 0; k < NODES * NODES * TURNS; ++k) {
        const uint32_t row = k / (NODES * TURNS), column = k / TURNS % NODES, turn = k % TURNS;
        const double half = half_of(turn, at->nodes[row].cosine + at->nodes[column].cosine),
                     c = 2 * half * half - 1;
        at->x[row][column][turn] = (float)(at->nodes[column].sine * c);
        at->y[row][column][turn] = (float)(at->nodes[column].sine * sqrt(fmax(1 - c * c, 0)));
    }
}

uint32_t mcv_interface_words(void) { return WORDS * NODES * NODES * TURNS; }

/* What the walks of all rows of both sides send, and the shares that go on. */
typedef struct walks {
    mcv_walk_interface at;
    mcv_walk_goals sums[2][NODES];
    double goes_on[2][NODES];
} walks;

static void walk_row(void *user, size_t k) {
    walks *all = user;
    const size_t side = k / NODES, row = k % NODES;
    all->goes_on[side][row] = mcv_walk(&all->at, (int)side, (uint32_t)row, all->sums[side][row]);
}

bool mcv_multiple_interface(double alpha, double n_outside, double n_inside, double coating,
                            float *table) {
    walks *walked = calloc(1, sizeof *walked);
    double(*all)[2][NODES][NODES][TURNS] = malloc(sizeof(entries));
    const bool made = walked && all;
    if (made) {
        walked->at.alpha = alpha;
        walked->at.n[0] = n_outside;
        walked->at.n[1] = n_inside;
        prepare(&walked->at, coating);
        mcv_in_parallel((size_t)2 * NODES, walk_row, walked);
        fill(&walked->at, walked->sums, walked->goes_on, all);
        for (uint32_t k = 0; k < 4 * NODES * NODES * TURNS;
             ++k) /* words: near from both sides, then far */
            table[k % (NODES * NODES * TURNS) * WORDS + k / (2 * NODES * NODES * TURNS) +
                  2 * (k / (NODES * NODES * TURNS) % 2)] = (float)(&all[0][0][0][0][0])[k];
    }
    free(walked);
    free(all);
    return made;
}
