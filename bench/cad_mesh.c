/* SPDX-License-Identifier: Apache-2.0 */
#include "cad_mesh.h"

enum { FILLET = 6 /* steps of a quarter of a circle */ };
static const double turn = 6.283185307179586;

/* A part's own frame: an origin and three unit axes. */
typedef struct frame {
    double origin[3], axes[3][3];
} frame;

typedef struct maker {
    mesh *made; /* NULL: only counts */
    uint32_t triangle_count, segments;
    bool even;
} maker;

static frame upright(double x, double y, double z) {
    return (frame){{x, y, z}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
}

/* About a tilted axis, so that the boxes of long triangles are large. */
static frame tilted(double x, double y, double z, uint64_t *seed) {
    frame f = upright(x, y, z);
    double length = 0, across = 0;
    random_direction(seed, f.axes[2]);
    for (int k = 0; k < 3; ++k) {
        f.axes[0][k] = f.axes[2][(k + 1) % 3];
        across += f.axes[0][k] * f.axes[2][k];
    }
    for (int k = 0; k < 3; ++k) f.axes[0][k] -= across * f.axes[2][k];
    for (int k = 0; k < 3; ++k) length += f.axes[0][k] * f.axes[0][k];
    for (int k = 0; k < 3; ++k) f.axes[0][k] /= sqrt(length);
    for (int k = 0; k < 3; ++k)
        f.axes[1][k] = f.axes[2][(k + 1) % 3] * f.axes[0][(k + 2) % 3] -
                       f.axes[2][(k + 2) % 3] * f.axes[0][(k + 1) % 3];
    return f;
}

static void add(maker *m, const frame *f, const double corners[3][3]) {
    const uint32_t first = 3 * m->triangle_count++;
    if (!m->made) return;
    for (uint32_t corner = 0; corner < 3; ++corner) {
        m->made->indices[first + corner] = first + corner;
        for (int k = 0; k < 3; ++k)
            m->made->positions[3 * (size_t)(first + corner) + (size_t)k] =
                (float)(f->origin[k] + corners[corner][0] * f->axes[0][k] +
                        corners[corner][1] * f->axes[1][k] + corners[corner][2] * f->axes[2][k]);
    }
}

/* A point of a circle about the axis. */
static void around(const maker *m, double radius, double height, uint32_t i, double p[3]) {
    const double angle = turn * (i % m->segments) / m->segments;
    p[0] = radius * cos(angle);
    p[1] = radius * sin(angle);
    p[2] = height;
}

/* A surface of revolution between two circles, in one strip or, even, in squares. */
static void add_strip(maker *m, const frame *f, double radius0, double height0, double radius1,
                      double height1) {
    const double length = sqrt((radius1 - radius0) * (radius1 - radius0) +
                               (height1 - height0) * (height1 - height0)),
                 chord = turn * fmax(radius0, radius1) / m->segments;
    const uint32_t steps = m->even && length > chord ? (uint32_t)(length / chord) : 1;
    for (uint32_t step = 0; step < steps; ++step) {
        const double s = (double)step / steps, t = (step + 1.0) / steps;
        for (uint32_t i = 0; i < m->segments; ++i) {
            double p[4][3];
            for (uint32_t k = 0; k < 4; ++k) {
                const double at = k < 2 ? s : t;
                around(m, radius0 + at * (radius1 - radius0), height0 + at * (height1 - height0),
                       i + (k & 1), p[k]);
            }
            double two[2][3][3];
            const int corners[6] = {0, 1, 3, 0, 3, 2};
            for (int k = 0; k < 18; ++k) two[k / 9][k / 3 % 3][k % 3] = p[corners[k / 3]][k % 3];
            add(m, f, two[0]);
            add(m, f, two[1]);
        }
    }
}

/* A disc: a fan from one vertex of its rim. */
static void add_disc(maker *m, const frame *f, double radius, double height) {
    if (m->even) {
        add_strip(m, f, 1e-3 * radius, height, radius, height);
        return;
    }
    for (uint32_t i = 1; i + 1 < m->segments; ++i) {
        double p[3][3];
        around(m, radius, height, 0, p[0]);
        around(m, radius, height, i, p[1]);
        around(m, radius, height, i + 1, p[2]);
        add(m, f, p);
    }
}

/* A square of half width `half` with a round hole: fans from its corners. */
static void add_face(maker *m, const frame *f, double radius, double half, double height) {
    const uint32_t quarter = m->segments / 4;
    if (m->even) {
        add_strip(m, f, radius, height, half, height);
        return;
    }
    for (uint32_t side = 0; side < 4; ++side) {
        const double angle = turn * (side + 0.5) / 4;
        const double r = half * 1.4142135623730951;
        const double corner[3] = {r * cos(angle), r * sin(angle), height},
                     next[3] = {r * cos(angle + turn / 4), r * sin(angle + turn / 4), height};
        double p[3][3];
        for (uint32_t i = 0; i < quarter; ++i) {
            for (int k = 0; k < 3; ++k) p[0][k] = corner[k];
            around(m, radius, height, side * quarter + i, p[1]);
            around(m, radius, height, side * quarter + i + 1, p[2]);
            add(m, f, p);
        }
        for (int k = 0; k < 3; ++k) p[1][k] = next[k];
        around(m, radius, height, (side + 1) * quarter, p[2]);
        add(m, f, p);
    }
}

/* A quarter of a torus from (radius, height) outwards and up by `size`. */
static void add_fillet(maker *m, const frame *f, double radius, double height, double size,
                       double up) {
    const uint32_t steps = m->even ? m->segments / 16 + 1 : FILLET;
    for (uint32_t i = 0; i < steps; ++i) {
        const double a = 0.25 * turn * i / steps, b = 0.25 * turn * (i + 1) / steps;
        add_strip(m, f, radius + size * (1 - cos(a)), height + up * size * sin(a),
                  radius + size * (1 - cos(b)), height + up * size * sin(b));
    }
}

static void add_part(maker *m, uint32_t bores) {
    const uint32_t shafts = bores * bores / 3, rings = bores * bores / 9;
    const double size = sqrt(6.0 / bores); /* of what lies about */
    uint64_t seed = 7;
    const frame base = upright(0, 0, 0);
    const double half = 1.0 / bores, bore = 0.55 * half, chamfer = 0.06 * half;
    const double ground[2][3][3] = {{{-4, -4, -1}, {4, -4, -1}, {4, 4, -1}},
                                    {{-4, -4, -1}, {4, 4, -1}, {-4, 4, -1}}};
    add(m, &base, ground[0]);
    add(m, &base, ground[1]);
    for (uint32_t i = 0; i < bores * bores; ++i) {
        const uint32_t row = i / bores, column = i % bores;
        const frame cell = upright(half * (2 * column + 1) - 1, half * (2 * row + 1) - 1, 0);
        add_face(m, &cell, bore + chamfer, half, -0.2);
        add_strip(m, &cell, bore + chamfer, -0.2, bore, -0.2 - chamfer);
        add_strip(m, &cell, bore, -0.2 - chamfer, bore, -0.6);
        add_face(m, &cell, bore, half, -0.6);
    }
    for (uint32_t i = 0; i < shafts; ++i) {
        const frame shaft = tilted(1.4 * random_unit(&seed) - 0.7, 1.4 * random_unit(&seed) - 0.7,
                                   0.3 * random_unit(&seed), &seed);
        const double radius = size * (0.04 + 0.08 * random_unit(&seed)), fillet = 0.4 * radius,
                     end_of_shaft = 0.5 * size, length = 0.55 * size;
        add_strip(m, &shaft, radius, -end_of_shaft, radius, end_of_shaft);
        for (int end = -1; end <= 1; end += 2) {
            add_fillet(m, &shaft, radius, end_of_shaft * end, fillet, end);
            add_strip(m, &shaft, radius + fillet, end * (end_of_shaft + fillet), radius + fillet,
                      end * (length + fillet));
            add_disc(m, &shaft, radius + fillet, end * (length + fillet));
        }
    }
    for (uint32_t i = 0; i < rings; ++i) {
        const frame ring = tilted(1.2 * random_unit(&seed) - 0.6, 1.2 * random_unit(&seed) - 0.6,
                                  0.4 * random_unit(&seed), &seed);
        const uint32_t steps = m->segments / 4;
        const double large = 0.25 * size, small = 0.05 * size;
        for (uint32_t k = 0; k < steps; ++k) {
            const double a = turn * k / steps, b = turn * (k + 1) / steps;
            add_strip(m, &ring, large + small * cos(a), small * sin(a), large + small * cos(b),
                      small * sin(b));
        }
    }
}

mesh cad_mesh(uint32_t segments, uint32_t bores, bool even) {
    maker m = {.segments = segments, .even = even};
    add_part(&m, bores);
    mesh made = mesh_new(3 * m.triangle_count, m.triangle_count);
    m.made = &made;
    m.triangle_count = 0;
    add_part(&m, bores);
    return made;
}
