/* SPDX-License-Identifier: Apache-2.0 */
/* Multiple scattering between the microfacets of an interface (multiple.h): two meetings by
 * quadrature, more by random walks. */
#include <math.h>
#include <stdlib.h>

#include "core/parallel.h"
#include "device/albedo.h"
#include "device/microsurface.h"
#include "device/multiple.h"
#include "device/multiple_goals.h"
#include "device/multiple_two.h"
#include "device/multiple_walks.h"

static const double pi = 3.14159265358979323846;

/*
 * Light that meets three and more microfacets is spread more evenly: fewer cosines do for walks,
 * half of them where α is below `narrow`, as that light is narrower there.
 */
enum {
    NODES = MCV_GOAL_NODES,
    TURNS = MCV_GOAL_TURNS,
    WALK_NODES = 12,
    NARROW_WALK_NODES = NODES / 2,
    WORDS = MCV_MULTIPLE_WORDS
};

static const double narrow = 0.08;

typedef struct surface {
    mcv_facet_interface at;
    mcv_goals goals, walk_goals;
    mcv_goal_sums two[2][NODES], more[2 * NARROW_WALK_NODES]; /* by side and row */
    double goes_on[2][NODES];
} surface;

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
static void follow_near(const surface *s, const double *roots, uint32_t row,
                        double columns[NODES]) {
    enum { RADII = 24, ANGLES = 24 };
    const mcv_goal_node *from = &s->goals.node[row];
    const double alpha = s->at.alpha, o[3] = {from->sine, 0, from->cosine};
    for (int f = 0; f < RADII * ANGLES; ++f) {
        const int ring = f % RADII, sector = f / RADII;
        const double v = (ring + 0.5) / RADII, angle = pi * (sector + 0.5) / ANGLES,
                     turn[2] = {cos(angle), sin(angle)};
        double w[3], h[3], c;
        mcv_reflect_by_facet((const double[2]){alpha, alpha}, o, v * v, turn, w, &c, h);
        if (!(w[2] > 0)) continue;
        const double z = fmin(w[2], 1), across = hypot(w[0], w[1]),
                     half = across > 0 ? sqrt(fmax(0.5 + 0.5 * w[0] / across, 0)) : 1;
        const double kept = 4 * v * v * v * (1 + from->lambda) /
                            (1 + from->lambda + mcv_smith(alpha, z)) / (RADII * ANGLES);
        add_between(roots + (size_t)row * NODES * TURNS,
                    between(mcv_multiple_place(z, NODES), NODES),
                    between(mcv_goal_entry(half, from->cosine + z), TURNS), kept, columns);
    }
}

static void follow_far(const surface *s, const double *roots, uint32_t row, double columns[NODES]) {
    enum { STEPS = 4 * (NODES - 1), ANGLES = 32 };
    const mcv_goal_node *from = &s->goals.node[row];
    double low = 0;
    for (int step = 0; step < STEPS; ++step) {
        const double next =
                         step < STEPS - 1 ? mcv_multiple_cosine((uint32_t)step + 1, STEPS + 1) : 1,
                     z = 0.5 * (low + next);
        const double weight = 2 * pi * (next - low) / ANGLES /
                              (from->cosine * (1 + from->lambda) * (1 + mcv_smith(s->at.alpha, z)));
        const place column = between(mcv_multiple_place(z, NODES), NODES);
        for (int turn = 0; turn < ANGLES; ++turn) {
            const double half = fabs(cos(0.5 * pi * (turn + 0.5) / ANGLES));
            add_between(roots + (size_t)row * NODES * TURNS, column,
                        between(mcv_goal_entry(half, from->cosine + z), TURNS), weight, columns);
        }
        low = next;
    }
}

/* Entries of both sides, near and far: [side][far]; their roots. */
typedef double entries[2][2][NODES][NODES][TURNS];

/*
 * Scales the entries by r(o) r(i) so that the light after several meetings equals the light that
 * does not leave at the first. The first meeting tells this sum well; interpolation has errors. The
 * factors preserve reciprocity. Where a share g of the light goes on, r is 1 ± g at most: of little
 * light the entries are better known than their sum.
 */
static void complete(const surface *s, entries all) {
    enum { ROUNDS = 40 };
    double columns[2][NODES][2][NODES] = {{{{0}}}}, r[2][NODES];
    for (uint32_t k = 0; k < 2 * NODES; ++k) {
        const uint32_t side = k / NODES, row = k % NODES;
        follow_near(s, &all[side][0][0][0][0], row, columns[side][row][0]);
        follow_far(s, &all[side][1][0][0][0], row, columns[side][row][1]);
        r[side][row] = 1;
    }
    for (uint32_t k = 0; k < ROUNDS * 2 * NODES; ++k) {
        const uint32_t side = k / NODES % 2, row = k % NODES;
        double sum = 0;
        for (uint32_t column = 0; column < NODES; ++column)
            sum += columns[side][row][0][column] * r[side][column] +
                   columns[side][row][1][column] * r[!side][column];
        const double g = s->goes_on[side][row], spread = fmin(g, 0.5);
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
static double unit_of(double alpha, const mcv_goals *goals, uint32_t far, uint32_t row,
                      uint32_t column, uint32_t turn) {
    const mcv_goal_node *from = &goals->node[row], *to = &goals->node[column];
    if (far) return 1 / (from->cosine * (1 + from->lambda) * (1 + to->lambda));
    const double x = from->sine + (double)goals->x[row][column][turn],
                 y = (double)goals->y[row][column][turn], z = from->cosine + to->cosine;
    return mcv_facet_density(alpha, z * z / (x * x + y * y + z * z)) /
           (4 * from->cosine * (1 + from->lambda + to->lambda));
}

/* What was found from both ends of a pair: of all turns, or at normal incidence, where azimuths
 * have no meaning, the mean. */
static double both_ends(const mcv_goals *goals, uint32_t row, uint32_t column, uint32_t turn,
                        const double *one, const double *other) {
    if (row < goals->nodes - 1 && column < goals->nodes - 1) return one[turn] + other[turn];
    double sum = 0;
    for (uint32_t each = 0; each < TURNS; ++each) sum += (one[each] + other[each]) / TURNS;
    return sum;
}

/* The entries of what was found from both ends; sums are by side and row. */
static void fill(const mcv_facet_interface *at, const mcv_goals *goals, const mcv_goal_sums *sums,
                 entries all) {
    const uint32_t nodes = goals->nodes;
    for (uint32_t way = 0; way < 4; ++way)
        for (uint32_t row = 0; row < nodes; ++row)
            for (uint32_t column = 0; column < nodes; ++column)
                for (uint32_t turn = 0; turn < TURNS; ++turn) {
                    const uint32_t side = way / 2, far = way % 2;
                    const double n = at->n[side ^ far],
                                 sum = both_ends(goals, row, column, turn,
                                                 sums[side * nodes + row][far][column],
                                                 sums[(side ^ far) * nodes + column][far][row]);
                    all[side][far][row][column][turn] =
                        sqrt(sqrt(n * n * goals->node[column].cosine * sum /
                                  unit_of(at->alpha, goals, far, row, column, turn)));
                }
}

/* Adds what walks know at fewer cosines, between which roots are interpolated. */
static void add_more(uint32_t nodes, const entries more, entries all) {
    for (uint32_t k = 0; k < 4 * NODES * NODES * TURNS; ++k) {
        const uint32_t side = k / (2 * NODES * NODES * TURNS),
                       far = k / (NODES * NODES * TURNS) % 2, row = k / (NODES * TURNS) % NODES,
                       column = k / TURNS % NODES, turn = k % TURNS;
        const double scale = (double)(nodes - 1) / (NODES - 1);
        const place a = between(row * scale, nodes), b = between(column * scale, nodes);
        double root = 0;
        for (uint32_t corner = 0; corner < 4; ++corner) {
            const uint32_t down = corner & 1, right = corner >> 1;
            root += (down ? a.share : 1 - a.share) * (right ? b.share : 1 - b.share) *
                    more[side][far][a.at + down][b.at + right][turn];
        }
        double *entry = &all[side][far][row][column][turn];
        *entry = sqrt(sqrt(pow(*entry, 4) + pow(root, 4)));
    }
}

/*
 * Lines between nodes lie aside of what bends by 1/12 of its second difference on average,
 * triangles by 1/24 of those along their three sides. Nodes take this off, so that errors have no
 * mean.
 */
static void take_off_bends(const double *all, double *straight) {
    static const int steps[4] = {NODES * TURNS, TURNS, NODES * TURNS + TURNS, 1};
    static const double shares[4] = {1 / 24.0, 1 / 24.0, 1 / 24.0, 1 / 12.0};
    for (int k = 0; k < 4 * NODES * NODES * TURNS; ++k) {
        const int row = k / (NODES * TURNS) % NODES, column = k / TURNS % NODES, turn = k % TURNS;
        const bool down = row > 0 && row < NODES - 1;
        const bool right = column > 0 && column < NODES - 1;
        const bool inside[4] = {down, right, down && right, turn > 0 && turn < TURNS - 1};
        straight[k] = all[k];
        for (int axis = 0; axis < 4; ++axis)
            if (inside[axis])
                straight[k] -=
                    shares[axis] * (all[k - steps[axis]] - 2 * all[k] + all[k + steps[axis]]);
        straight[k] = fmax(straight[k], 0);
    }
}

uint32_t mcv_interface_words(void) { return WORDS * NODES * NODES * TURNS; }

/* Two meetings from the directions of a row, on both sides: work for one thread. */
static void meet_row(void *user, size_t row) {
    surface *s = user;
    mcv_heights heights;
    mcv_heights_fill(&s->goals, (uint32_t)row, heights);
    for (int side = 0; side < 2; ++side)
        s->goes_on[side][row] =
            mcv_meet_twice(&s->at, &s->goals, side, (uint32_t)row, heights, s->two[side][row]);
}

static void walk_row(void *user, size_t k) {
    surface *s = user;
    const uint32_t nodes = s->walk_goals.nodes;
    mcv_walk(&s->at, &s->walk_goals, k >= nodes, (uint32_t)k % nodes, s->more[k]);
}

static void prepare(surface *s, double alpha, double n_outside, double n_inside, double coating) {
    s->at.alpha = alpha;
    s->at.n[0] = n_outside;
    s->at.n[1] = n_inside;
    for (int side = 0; side < 2; ++side)
        mcv_coat(coating, s->at.n[side] / s->at.n[!side], 1, &s->at.scale[side],
                 &s->at.offset[side]);
    mcv_goals_fill(alpha, NODES, &s->goals);
    mcv_goals_fill(alpha, alpha < narrow ? NARROW_WALK_NODES : WALK_NODES, &s->walk_goals);
}

bool mcv_multiple_interface(double alpha, double n_outside, double n_inside, double coating,
                            float *table) {
    surface *s = calloc(1, sizeof *s);
    double(*all)[2][NODES][NODES][TURNS] = calloc(2, sizeof(entries));
    const bool made = s && all;
    if (made) {
        prepare(s, alpha, n_outside, n_inside, coating);
        mcv_in_parallel(NODES, meet_row, s);
        mcv_in_parallel((size_t)2 * s->walk_goals.nodes, walk_row, s);
        fill(&s->at, &s->goals, &s->two[0][0], all);
        fill(&s->at, &s->walk_goals, s->more, all + 2);
        add_more(s->walk_goals.nodes, all + 2, all);
        take_off_bends(&all[0][0][0][0][0], &all[2][0][0][0][0]);
        complete(s, all + 2);
        for (uint32_t k = 0; k < 4 * NODES * NODES * TURNS;
             ++k) /* words: near from both sides, then far */
            table[k % (NODES * NODES * TURNS) * WORDS + k / (2 * NODES * NODES * TURNS) +
                  2 * (k / (NODES * NODES * TURNS) % 2)] = (float)(&all[2][0][0][0][0])[k];
    }
    free(s);
    free(all);
    return made;
}
