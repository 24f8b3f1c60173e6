/* SPDX-License-Identifier: Apache-2.0 */
#include "analysis/surface_noise.h"

#include "analysis/noise.h"

#include <math.h>

const char *const mcv_surface_channels[4] = {"X", "Y", "Z", "number"};

/* A pixel on the lattice: corners 00, 10, 01, 11 (column, row) in cells along two axes of the node.
 * Two triangles, 00, 10, 11 and 00, 01, 11, are mapped to it. Pixels side by side share their
 * edges, so that a place lies in one of them. */
typedef struct quad {
    double at[4][2];
    double map[2][2][2]; /* of each triangle: from the lattice to places in the pixel */
    double low[2], high[2];
    uint32_t axis; /* nearest to the surface's normal: the two others are the lattice's */
    uint32_t number;
} quad;

static bool corners(const mcv_surface_noise *s, uint32_t column, uint32_t row, double at[4][3],
                    uint32_t *number) {
    const mcv_image *image = s->places;
    const size_t plane = (size_t)image->width * image->height;
    for (uint32_t k = 0; k < 4; ++k) {
        const size_t i = (size_t)(row + k / 2) * image->width + column + k % 2;
        const float seen = image->pixels[3 * plane + i];
        if (!(seen >= 1 && seen <= 1e9F)) return false;
        if (k > 0 && (uint32_t)seen != *number) return false;
        *number = (uint32_t)seen;
        for (int c = 0; c < 3; ++c) {
            at[k][c] = (double)image->pixels[(size_t)c * plane + i] / s->edge;
            if (!(fabs(at[k][c]) < 1e9)) return false;
        }
    }
    return true;
}

/* The inverses; infinite where a triangle has no area, and no place lies in it. */
static void turn_back(quad *q) {
    for (int half = 0; half < 2; ++half) {
        const double *corner = q->at[1 + half];
        double a[2], b[2];
        for (int c = 0; c < 2; ++c) {
            const double first = corner[c] - q->at[0][c], second = q->at[3][c] - corner[c];
            a[c] = half ? second : first;
            b[c] = half ? first : second;
        }
        const double det = a[0] * b[1] - a[1] * b[0];
        q->map[half][0][0] = b[1] / det, q->map[half][0][1] = -b[0] / det;
        q->map[half][1][0] = -a[1] / det, q->map[half][1][1] = a[0] / det;
    }
}

static bool lay(const mcv_surface_noise *s, uint32_t column, uint32_t row, quad *q) {
    double at[4][3], normal[3];
    if (!corners(s, column, row, at, &q->number)) return false;
    for (int c = 0; c < 3; ++c) {
        const int d = (c + 1) % 3, e = (c + 2) % 3;
        normal[c] = fabs((at[3][d] - at[0][d]) * (at[2][e] - at[1][e]) -
                         (at[3][e] - at[0][e]) * (at[2][d] - at[1][d]));
    }
    q->axis =
        normal[0] > normal[1] ? (normal[0] > normal[2] ? 0 : 2) : (normal[1] > normal[2] ? 1 : 2);
    for (int c = 0; c < 2; ++c) {
        q->low[c] = INFINITY, q->high[c] = -INFINITY;
        for (int k = 0; k < 4; ++k) {
            q->at[k][c] = at[k][(q->axis + 1 + (uint32_t)c) % 3];
            q->low[c] = fmin(q->low[c], q->at[k][c]);
            q->high[c] = fmax(q->high[c], q->at[k][c]);
        }
    }
    turn_back(q);
    return true;
}

/* Where in the pixel a place of the lattice lies. */
static bool find(const quad *q, const double place[2], double in[2]) {
    const double x = place[0] - q->at[0][0], y = place[1] - q->at[0][1];
    for (int half = 0; half < 2; ++half) {
        for (int c = 0; c < 2; ++c) in[c] = q->map[half][c][0] * x + q->map[half][c][1] * y;
        if (in[0] >= 0 && in[0] < 1 && in[1] >= 0 && in[1] < 1 && (in[0] < in[1]) == half)
            return true;
    }
    return false;
}

/* The number of a cell: Box and Muller 1958. */
static void draw(const quad *q, uint32_t seed, uint32_t pattern, const int64_t cell[2],
                 double value[2]) {
    const uint64_t key = ((uint64_t)cell[0] & 0xFFFFFF) << 40 |
                         ((uint64_t)cell[1] & 0xFFFFFF) << 16 | (q->number & 0x3FFF) << 2 | q->axis;
    mcv_noise noise = mcv_noise_begin(seed, pattern, key);
    noise.key[1] = 3; /* apart from numbers of the film */
    const double radius = sqrt(-2 * log(mcv_noise_uniform(&noise))),
                 angle = 2 * M_PI * mcv_noise_uniform(&noise);
    value[0] = radius * cos(angle);
    value[1] = radius * sin(angle);
}

void mcv_surface_noise_add(const mcv_surface_noise *surface, uint32_t seed, uint32_t pattern,
                           uint32_t column, uint32_t row, const mcv_surface_sums *sums) {
    enum { CELLS = 64 };
    const double offset = 0.381966; /* edges of pixels on round lengths meet no cell's middle */
    const uint32_t side = sums->q;
    quad q;
    if (!lay(surface, column, row, &q)) return;
    if (!((1 + q.high[0] - q.low[0]) * (1 + q.high[1] - q.low[1]) <= (double)CELLS * side * side))
        return;
    int64_t cell[2];
    for (cell[1] = (int64_t)ceil(q.low[1] - offset); (double)cell[1] + offset < q.high[1];
         ++cell[1])
        for (cell[0] = (int64_t)ceil(q.low[0] - offset); (double)cell[0] + offset < q.high[0];
             ++cell[0]) {
            const double place[2] = {(double)cell[0] + offset, (double)cell[1] + offset};
            double in[2], value[2];
            if (!find(&q, place, in)) continue;
            const size_t i = (size_t)(in[0] * side), j = (size_t)(in[1] * side);
            draw(&q, seed, pattern, cell, value);
            sums->values[2 * (j * sums->stride + i)] += value[0];
            sums->values[2 * (j * sums->stride + i) + 1] += value[1];
            ++sums->counts[j * sums->count_stride + i];
        }
}
