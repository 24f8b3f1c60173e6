/* SPDX-License-Identifier: Apache-2.0 */
/* Generated meshes and random numbers for the tests and benchmarks of the acceleration structure.
 */
#ifndef MCVISI_TESTS_MESH_H
#define MCVISI_TESTS_MESH_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct mesh {
    float *positions;
    uint32_t *indices;
    uint32_t vertex_count, triangle_count;
} mesh;

/* splitmix64 (Steele, Lea and Flood 2014): the state is any number. */
static inline uint64_t random_bits(uint64_t *state) {
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/* Uniform in [0, 1). */
static inline double random_unit(uint64_t *state) {
    return (double)(random_bits(state) >> 11) * 0x1p-53;
}

/* A uniform direction. */
static inline void random_direction(uint64_t *state, double d[3]) {
    const double z = 2.0 * random_unit(state) - 1.0, angle = 6.283185307179586 * random_unit(state),
                 r = sqrt(1.0 - z * z);
    d[0] = r * cos(angle);
    d[1] = r * sin(angle);
    d[2] = z;
}

static inline mesh mesh_new(uint32_t vertices, uint32_t triangles) {
    mesh m = {malloc((size_t)vertices * 12), malloc((size_t)triangles * 12), vertices, triangles};
    if (!m.positions || !m.indices) abort();
    return m;
}

static inline void mesh_free(mesh *m) {
    free(m->positions);
    free(m->indices);
}

/* Two triangles per cell of a grid of (n + 1)² vertices that begins at `vertex`; writes 6 n²
 * indices. */
static inline void mesh_grid(uint32_t *indices, uint32_t vertex, uint32_t n) {
    for (uint32_t j = 0; j < n; ++j) {
        for (uint32_t i = 0; i < n; ++i, indices += 6) {
            const uint32_t a = vertex + j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
            const uint32_t cell[6] = {a, b, d, a, d, c};
            for (int k = 0; k < 6; ++k) indices[k] = cell[k];
        }
    }
}

/*
 * A closed sphere of radius 1 with bumps of the given height: a cube of 6 n x n squares drawn
 * outwards, 12 n² triangles. The six sides have their own vertices; those on the seams have equal
 * positions, because a vertex is a function of its integers.
 */
static inline mesh mesh_sphere(uint32_t n, double bumps) {
    const uint32_t side = (n + 1) * (n + 1);
    mesh m = mesh_new(6 * side, 12 * n * n);
    float *p = m.positions;
    for (uint32_t face = 0; face < 6; ++face) {
        const int axis = (int)(face / 2), sign = face % 2 ? 1 : -1;
        for (uint32_t j = 0; j <= n; ++j) {
            for (uint32_t i = 0; i <= n; ++i, p += 3) {
                int64_t q[3];
                q[axis] = sign * (int64_t)n;
                q[(axis + 1) % 3] = 2 * (int64_t)(sign > 0 ? i : n - i) - n;
                q[(axis + 2) % 3] = 2 * (int64_t)j - n;
                double t[3];
                for (int k = 0; k < 3; ++k) t[k] = tan(0.7853981633974483 * (double)q[k] / n);
                const double length = sqrt((t[0] * t[0] + t[1] * t[1]) + t[2] * t[2]);
                const double x = t[0] / length, y = t[1] / length, z = t[2] / length;
                const double r =
                    1.0 + bumps * sin(9.0 * x) * sin(11.0 * y + 1.0) * sin(10.0 * z + 2.0);
                p[0] = (float)(r * x);
                p[1] = (float)(r * y);
                p[2] = (float)(r * z);
            }
        }
        mesh_grid(m.indices + 6 * (size_t)face * n * n, face * side, n);
    }
    return m;
}

/* A rough height field over [-1, 1]², 2 n² triangles. */
static inline mesh mesh_terrain(uint32_t n, double height, uint64_t seed) {
    mesh m = mesh_new((n + 1) * (n + 1), 2 * n * n);
    float *p = m.positions;
    for (uint32_t j = 0; j <= n; ++j) {
        for (uint32_t i = 0; i <= n; ++i, p += 3) {
            p[0] = (float)(2.0 * i / n - 1.0);
            p[1] = (float)(2.0 * j / n - 1.0);
            p[2] = (float)(height * (sin(5.0 * p[0]) * cos(7.0 * p[1]) + random_unit(&seed) / n));
        }
    }
    mesh_grid(m.indices, 0, n);
    return m;
}

/* Long thin triangles in random places, most about 1 x 1e-3, some without area at all. */
static inline mesh mesh_needles(uint32_t count, uint64_t seed) {
    mesh m = mesh_new(3 * count, count);
    for (uint32_t i = 0; i < count; ++i) {
        double along[3], aside[3];
        random_direction(&seed, along);
        random_direction(&seed, aside);
        const double width = i % 16 ? 1e-3 : 0.0;
        for (int k = 0; k < 3; ++k) {
            float *p = m.positions + 9 * (size_t)i + k;
            const double centre = 2.0 * random_unit(&seed) - 1.0;
            p[0] = (float)(centre - 0.5 * along[k]);
            p[3] = (float)(centre + 0.5 * along[k]);
            p[6] = (float)(centre + width * aside[k]);
        }
    }
    for (uint32_t i = 0; i < 3 * count; ++i) m.indices[i] = i;
    return m;
}

/* Two pyramids on one ring: closed, n triangles meet at either tip, 2 n triangles. */
static inline mesh mesh_bipyramid(uint32_t n) {
    mesh m = mesh_new(n + 2, 2 * n);
    for (uint32_t i = 0; i < n; ++i) {
        const double angle = 6.283185307179586 * i / n;
        m.positions[3 * i] = (float)cos(angle);
        m.positions[3 * i + 1] = (float)sin(angle);
        m.positions[3 * i + 2] = (float)(0.1 * sin(3.0 * angle));
        const uint32_t next = (i + 1) % n;
        const uint32_t two[6] = {i, next, n, next, i, n + 1};
        for (int k = 0; k < 6; ++k) m.indices[6 * (size_t)i + k] = two[k];
    }
    const float tips[6] = {0.1f, 0.05f, 0.7f, -0.02f, 0.1f, -0.9f};
    for (int k = 0; k < 6; ++k) m.positions[3 * n + k] = tips[k];
    return m;
}

/* n triangles in n / 8 planes, each plane holding the same triangle four times and four that
 * overlap it. */
static inline mesh mesh_duplicates(uint32_t n, uint64_t seed) {
    mesh m = mesh_new(3 * n, n);
    for (uint32_t i = 0; i < n; ++i) {
        const uint32_t plane = i / 8;
        const float z = (float)plane * 8.0f / (float)n - 0.5f;
        for (int corner = 0; corner < 3; ++corner) {
            const double angle =
                2.0943951023931953 * corner + (i % 8 < 4 ? 0.0 : 6.0 * random_unit(&seed));
            float *p = m.positions + 9 * (size_t)i + 3 * corner;
            p[0] = (float)cos(angle);
            p[1] = (float)sin(angle);
            p[2] = z + 0.25f * p[0];
        }
    }
    for (uint32_t i = 0; i < 3 * n; ++i) m.indices[i] = i;
    return m;
}

#endif
