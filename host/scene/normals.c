/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Vertex normals by crease angle. Corners of triangles at exactly the same position are one vertex.
 * Around it, triangles that share an edge are joined if their normals differ by at most the crease
 * angle. Triangles that are joined, directly or through others, share one normal. A surface thus
 * stays continuous where it is smooth, and sharp at a crease.
 *
 * The normal is the sum of the triangles' normals, weighed by sin α/(|a| |b|) with the edges a and
 * b at the vertex and the angle α between them (N. Max, Weights for computing vertex normals from
 * facet normals, Journal of Graphics Tools 4, 1 (1999)). On spheres and cylinders it is exact for
 * any triangulation. Weights by angle or by area are exact only for regular ones.
 */
#include "scene/mesh.h"

#include "scene/transform.h"

#include <float.h>
#include <stdlib.h>

/* A corner with its sort keys. `before` and `after` are the positions of the triangle's other
 * corners. */
typedef struct corner {
    const float *at;
    uint32_t place, before, after;
    uint32_t joined; /* to this corner of the mesh, or itself */
} corner;

static int compare_positions(const void *a, const void *b) {
    const float *p = ((const corner *)a)->at, *q = ((const corner *)b)->at;
    for (int i = 0; i < 3; ++i)
        if (p[i] != q[i]) return p[i] < q[i] ? -1 : 1;
    return 0;
}

/* By position; equal positions in the order of the mesh. */
static int compare_corners(const void *a, const void *b) {
    const corner *p = a, *q = b;
    const int by_position = compare_positions(a, b);
    return by_position ? by_position : p->at < q->at ? -1 : p->at > q->at;
}

/* A mesh of separate triangles. */
typedef struct creasing {
    const float *positions;
    float *normals; /* of the faces, at each corner; 0 for degenerate triangles */
    corner *corners;
    uint32_t *order; /* of the corners, by vertex */
    uint32_t count;
    double least_cosine;
} creasing;

static const float *normal_at(const creasing *c, uint32_t i) { return c->normals + 3 * (size_t)i; }

static bool has_direction(const creasing *c, uint32_t i) {
    const float *n = normal_at(c, i);
    return n[0] != 0 || n[1] != 0 || n[2] != 0;
}

static double cosine(const creasing *c, uint32_t a, uint32_t b) {
    const float *n = normal_at(c, a), *m = normal_at(c, b);
    return (double)n[0] * m[0] + (double)n[1] * m[1] + (double)n[2] * m[2];
}

/*
 * The face's unit normal. A triangle lower than 64 rounding errors of its coordinates, as CAD
 * programs leave between planes, is degenerate: its normal would be wrong by a degree or more.
 */
static void face_normal(const float *corners, float normal[3]) {
    double edge[3][3], longest = 0, largest = 0, across[3], unit[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        double squared = 0;
        for (int i = 0; i < 3; ++i) {
            edge[k][i] = (double)corners[3 * ((k + 1) % 3) + i] - corners[3 * k + i];
            squared += edge[k][i] * edge[k][i];
            largest = fmax(largest, fabs((double)corners[3 * k + i]));
        }
        longest = fmax(longest, sqrt(squared));
    }
    mcv_cross3(edge[0], edge[1], across);
    const double area = sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2]);
    if (area > 64 * (double)FLT_EPSILON * largest * longest) mcv_normalize3(across, unit);
    for (int i = 0; i < 3; ++i) normal[i] = (float)unit[i];
}

/* sin α/(|a| |b|) of the edges a and b at a corner and the angle α between them. */
static double weight_at(const creasing *c, uint32_t i) {
    const uint32_t first = i - i % 3;
    double edge[2][3], across[3], squared[2] = {0, 0};
    for (uint32_t k = 0; k < 2; ++k)
        for (int axis = 0; axis < 3; ++axis) {
            edge[k][axis] = (double)c->positions[3 * (size_t)(first + (i + 1 + k) % 3) + axis] -
                            c->positions[3 * (size_t)i + axis];
            squared[k] += edge[k][axis] * edge[k][axis];
        }
    mcv_cross3(edge[0], edge[1], across);
    const double area = sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2]);
    return has_direction(c, i) ? area / squared[0] / squared[1] : 0;
}

/* Numbers the positions of corners, and lists the corners in this order. */
static void find_places(creasing *c) {
    corner *sorted = c->corners;
    for (uint32_t i = 0; i < c->count; ++i)
        sorted[i] = (corner){.at = c->positions + 3 * (size_t)i};
    qsort(sorted, c->count, sizeof *sorted, compare_corners);
    uint32_t place = 0;
    for (uint32_t k = 0; k < c->count; ++k) {
        if (k > 0 && compare_positions(sorted + k - 1, sorted + k) != 0) ++place;
        sorted[k].place = place;
        c->order[k] = (uint32_t)((sorted[k].at - c->positions) / 3);
    }
}

/* Transfers the numbers from the sorted corners to those of the mesh. */
static mcv_result number_corners(creasing *c, const mcv_json_path *place, mcv_error *error) {
    corner *numbered = malloc(((size_t)c->count + 1) * sizeof *numbered);
    if (!numbered) return mcv_fail_memory(place, error);
    for (uint32_t k = 0; k < c->count; ++k) numbered[c->order[k]] = c->corners[k];
    for (uint32_t i = 0; i < c->count; ++i) {
        const uint32_t first = i - i % 3;
        numbered[i].after = numbered[first + (i + 1) % 3].place;
        numbered[i].before = numbered[first + (i + 2) % 3].place;
        numbered[i].joined = i;
    }
    free(c->corners);
    c->corners = numbered;
    return MCV_OK;
}

static uint32_t root_of(creasing *c, uint32_t i) {
    while (c->corners[i].joined != i) {
        c->corners[i].joined = c->corners[c->corners[i].joined].joined;
        i = c->corners[i].joined;
    }
    return i;
}

static void join(creasing *c, uint32_t a, uint32_t b) {
    if (!has_direction(c, a) || !has_direction(c, b) || cosine(c, a, b) < c->least_cosine) return;
    c->corners[root_of(c, a)].joined = root_of(c, b);
}

static int compare_before(const void *a, const void *b, void *user) {
    const creasing *c = user;
    const uint32_t i = *(const uint32_t *)a, k = *(const uint32_t *)b;
    const uint32_t p = c->corners[i].before, q = c->corners[k].before;
    return p != q ? (p < q ? -1 : 1) : i < k ? -1 : i > k;
}

/* The first of n corners at one vertex, sorted by `before`, whose triangle comes to the vertex from
 * this position; n if there is none. */
static uint32_t first_from(const creasing *c, const uint32_t *around, uint32_t n, uint32_t from) {
    uint32_t low = 0, high = n;
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (c->corners[around[middle]].before < from)
            low = middle + 1;
        else
            high = middle;
    }
    return low < n && c->corners[around[low]].before == from ? low : n;
}

/* Joins the corners around one vertex across the edge to `after`, along which the neighbour comes
 * to the vertex. */
static void join_around(creasing *c, uint32_t *around, uint32_t n) {
    qsort_r(around, n, sizeof *around, compare_before, c);
    for (uint32_t k = 0; k < n; ++k) {
        const uint32_t from = c->corners[around[k]].after;
        for (uint32_t i = first_from(c, around, n, from);
             i < n && c->corners[around[i]].before == from; ++i)
            join(c, around[k], around[i]);
    }
    /* Degenerate triangles are skipped: their two neighbours count as adjacent. */
    for (uint32_t k = 0; k < n; ++k) {
        const corner *flat = c->corners + around[k];
        if (has_direction(c, around[k])) continue;
        const uint32_t one = first_from(c, around, n, flat->after);
        for (uint32_t i = 0; i < n && one < n; ++i)
            if (c->corners[around[i]].after == flat->before) join(c, around[one], around[i]);
    }
}

/* Each corner's normal is the sum over the corners joined to it. For a degenerate triangle it is
 * the sum over the whole vertex. */
static void sum_around(creasing *c, const uint32_t *around, uint32_t n, double (*sums)[3],
                       float *normals) {
    double all[3] = {0, 0, 0};
    for (uint32_t k = 0; k < n; ++k) memset(sums[around[k]], 0, sizeof *sums);
    for (uint32_t k = 0; k < n; ++k) {
        const uint32_t root = root_of(c, around[k]);
        const double weight = weight_at(c, around[k]);
        for (int i = 0; i < 3; ++i) {
            sums[root][i] += weight * normal_at(c, around[k])[i];
            all[i] += weight * normal_at(c, around[k])[i];
        }
    }
    for (uint32_t k = 0; k < n; ++k) {
        double unit[3] = {0, 0, 1};
        const double *sum = has_direction(c, around[k]) ? sums[root_of(c, around[k])] : all;
        mcv_normalize3(sum, unit);
        for (int i = 0; i < 3; ++i) normals[3 * (size_t)around[k] + i] = (float)unit[i];
    }
}

static mcv_result crease(creasing *c, double (*sums)[3], float *normals, const mcv_json_path *place,
                         mcv_error *error) {
    find_places(c);
    MCV_TRY(number_corners(c, place, error));
    for (uint32_t first = 0, last; first < c->count; first = last) {
        for (last = first; last < c->count &&
                           c->corners[c->order[last]].place == c->corners[c->order[first]].place;)
            ++last;
        join_around(c, c->order + first, last - first);
        sum_around(c, c->order + first, last - first, sums, normals);
    }
    return MCV_OK;
}

mcv_result mcv_mesh_make_normals(mcv_mesh *mesh, double crease_angle, const mcv_json_path *place,
                                 mcv_error *error) {
    MCV_TRY(mcv_mesh_separate(mesh, place, error));
    const size_t count = 3 * (size_t)mesh->triangle_count;
    creasing c = {.positions = mesh->positions,
                  .normals = calloc(count + 1, 3 * sizeof *c.normals),
                  .corners = calloc(count + 1, sizeof *c.corners),
                  .order = calloc(count + 1, sizeof *c.order),
                  .count = (uint32_t)count,
                  .least_cosine =
                      cos(crease_angle) -
                      1e-6}; /* faces at the angle itself are joined, whatever the rounding */
    double(*sums)[3] = calloc(count + 1, sizeof *sums);
    float *normals = calloc(count + 1, 3 * sizeof *normals);
    mcv_result result = MCV_OK;
    if (c.normals && c.corners && c.order && sums && normals) {
        for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
            float *faces = c.normals + 9 * (size_t)t;
            face_normal(mesh->positions + 9 * (size_t)t, faces);
            for (int i = 3; i < 9; ++i) faces[i] = faces[i - 3];
        }
        result = crease(&c, sums, normals, place, error);
    } else {
        result = mcv_fail_memory(place, error);
    }
    if (result == MCV_OK)
        mesh->normals = normals;
    else
        free(normals);
    free(sums);
    free(c.normals);
    free(c.corners);
    free(c.order);
    return result;
}
