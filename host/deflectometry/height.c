/* SPDX-License-Identifier: Apache-2.0 */
#include "deflectometry/height.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The least squares problem of a map: a graph whose nodes are pixels. */
typedef struct graph {
    const mcv_slope_map *map;
    size_t count;
    double *z, *rhs, *direction, *product, *scaled, *work;
    double *factor; /* 1 over the diagonal of the incomplete factor */
} graph;

/* The pixel to the right (0) or below (1), if both are valid; else the pixel itself. */
static size_t next_of(const mcv_slope_map *m, size_t i, int way) {
    const size_t column = i % m->width, row = i / m->width;
    const bool inside = way == 0 ? column + 1 < m->width : row + 1 < m->height;
    const size_t j = way == 0 ? i + 1 : i + m->width;
    return inside && m->valid[i] && m->valid[j] ? j : i;
}

/* The pixel to the left (0) or above (1), if both are valid; else the pixel itself. */
static size_t last_of(const mcv_slope_map *m, size_t i, int way) {
    const size_t step = way == 0 ? 1 : m->width;
    if (way == 0 ? i % m->width == 0 : i < m->width) return i;
    return next_of(m, i - step, way) == i ? i - step : i;
}

static double change_of(const mcv_slope_map *m, size_t i, size_t j) {
    return 0.5 *
           ((m->p[i] + m->p[j]) * (m->x[j] - m->x[i]) + (m->q[i] + m->q[j]) * (m->y[j] - m->y[i]));
}

static double dot(const graph *g, const double *a, const double *b) {
    double sum = 0;
    for (size_t i = 0; i < g->count; ++i) sum += a[i] * b[i];
    return sum;
}

/* out = (the graph's Laplace matrix) in */
static void multiply(const graph *g, const double *in, double *out) {
    memset(out, 0, g->count * sizeof *out);
    for (size_t i = 0; i < g->count; ++i)
        for (int way = 0; way < 2; ++way) {
            const size_t j = next_of(g->map, i, way);
            out[i] += in[i] - in[j];
            out[j] += in[j] - in[i];
        }
}

/* The diagonal is scaled up by 1e-3, so that no pivot vanishes: the matrix is singular. */
static void factorise(graph *g) {
    const double scale = 1 + 1e-3;
    for (size_t i = 0; i < g->count; ++i) {
        double pivot = 0;
        for (int way = 0; way < 2; ++way) {
            const size_t before = last_of(g->map, i, way);
            pivot += (next_of(g->map, i, way) != i) + (before != i);
        }
        pivot *= scale;
        for (int way = 0; way < 2; ++way) {
            const size_t before = last_of(g->map, i, way);
            if (before == i) continue;
            /* The fill-in that is dropped, (before, other neighbour), moves to the diagonal. */
            const bool dropped = next_of(g->map, before, 1 - way) != before;
            pivot -= (1 + (dropped ? 1 : 0)) * g->factor[before];
        }
        g->factor[i] = pivot > 0 ? 1 / pivot : 1;
    }
}

/* out = (L D Lᵀ)⁻¹ in with unit lower L of the entries -factor. */
static void precondition(const graph *g, const double *in, double *out) {
    for (size_t i = 0; i < g->count; ++i) {
        double sum = in[i];
        for (int way = 0; way < 2; ++way) {
            const size_t before = last_of(g->map, i, way);
            if (before != i) sum += g->work[before];
        }
        g->work[i] = sum * g->factor[i];
    }
    for (size_t i = g->count; i-- > 0;) {
        double sum = g->work[i];
        for (int way = 0; way < 2; ++way) {
            const size_t after = next_of(g->map, i, way);
            if (after != i) sum += g->factor[i] * out[after];
        }
        out[i] = sum;
    }
}

/* Until the residual is 1e-12 of the right side: heights of 0.1 nm in a map of 0.1 m. */
static void solve(graph *g) {
    const double goal = 1e-24 * dot(g, g->rhs, g->rhs);
    multiply(g, g->z, g->product);
    for (size_t i = 0; i < g->count; ++i) g->rhs[i] -= g->product[i]; /* now the residual */
    precondition(g, g->rhs, g->scaled);
    memcpy(g->direction, g->scaled, g->count * sizeof *g->scaled);
    double size = dot(g, g->rhs, g->scaled);
    for (size_t k = 0; k < 10 * g->count && dot(g, g->rhs, g->rhs) > goal; ++k) {
        multiply(g, g->direction, g->product);
        const double along = dot(g, g->direction, g->product);
        if (!(along > 0)) break;
        const double step = size / along;
        for (size_t i = 0; i < g->count; ++i) {
            g->z[i] += step * g->direction[i];
            g->rhs[i] -= step * g->product[i];
        }
        precondition(g, g->rhs, g->scaled);
        const double next = dot(g, g->rhs, g->scaled), turn = next / size;
        for (size_t i = 0; i < g->count; ++i)
            g->direction[i] = g->scaled[i] + turn * g->direction[i];
        size = next;
    }
}

/* Takes the mean from each connected part. `parts` and `stack` have room for all pixels. */
static void centre_parts(const graph *g, size_t *members, bool *seen) {
    for (size_t first = 0; first < g->count; ++first) {
        size_t count = 0;
        double sum = 0;
        if (seen[first] || !g->map->valid[first]) continue;
        members[count++] = first;
        seen[first] = true;
        for (size_t at = 0; at < count; ++at) {
            const size_t i = members[at];
            const size_t around[4] = {next_of(g->map, i, 0), next_of(g->map, i, 1),
                                      last_of(g->map, i, 0), last_of(g->map, i, 1)};
            sum += g->z[i];
            for (int k = 0; k < 4; ++k)
                if (!seen[around[k]]) {
                    seen[around[k]] = true;
                    members[count++] = around[k];
                }
        }
        for (size_t at = 0; at < count; ++at) g->z[members[at]] -= sum / (double)count;
    }
}

static double residual_of(const graph *g) {
    double sum = 0, edges = 0;
    for (size_t i = 0; i < g->count; ++i)
        for (int way = 0; way < 2; ++way) {
            const size_t j = next_of(g->map, i, way);
            if (j == i) continue;
            sum += pow(g->z[j] - g->z[i] - change_of(g->map, i, j), 2);
            ++edges;
        }
    return edges > 0 ? sqrt(sum / edges) : 0;
}

mcv_result mcv_heights_integrate(const mcv_slope_map *map, double *heights, double *residual,
                                 mcv_error *error) {
    enum { ARRAYS = 6 };
    const size_t count = (size_t)map->width * map->height;
    double *room = calloc(ARRAYS * count + 1, sizeof *room);
    size_t *members = malloc((count + 1) * sizeof *members);
    bool *seen = calloc(count + 1, sizeof *seen);
    mcv_result result = MCV_OK;
    if (room && members && seen) {
        graph g = {map,
                   count,
                   heights,
                   room,
                   room + count,
                   room + 2 * count,
                   room + 3 * count,
                   room + 4 * count,
                   room + 5 * count};
        for (size_t i = 0; i < count; ++i) {
            if (!map->valid[i]) heights[i] = 0;
            for (int way = 0; way < 2; ++way) {
                const size_t j = next_of(map, i, way);
                if (j == i) continue;
                g.rhs[i] -= change_of(map, i, j);
                g.rhs[j] += change_of(map, i, j);
            }
        }
        factorise(&g);
        solve(&g);
        centre_parts(&g, members, seen);
        if (residual) *residual = residual_of(&g);
    } else {
        result = mcv_fail(error, MCV_FAILED, "no memory for heights of %zu pixels", count);
    }
    free(room);
    free(members);
    free(seen);
    return result;
}
