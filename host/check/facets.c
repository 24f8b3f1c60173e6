/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Facets and bends. No single angle tells a curve from an edge: a dome of facets of 2 degrees may
 * meet its plate under 20. So each facet is asked how much it bends at its other neighbours.
 */
#include "check/facets.h"

#include "check/findings.h"
#include "scene/geometry.h"
#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>

const double mcv_flat = 0.01 * M_PI / 180, mcv_least_edge = 5 * M_PI / 180;

/* The largest angle between neighbours of a curved surface, above which an edge is intended. */
static const double crease = 31 * M_PI / 180;
/* Facets of a curve differ by less: uneven ones of a cylinder by 2, strips of a fillet next to
 * those of a face by 2, too. */
static const double outlier = 3, similar = 4;
static const double degree = M_PI / 180;
static const double largest = 30; /* crease angle that is suggested [degrees] */

static uint32_t root_of(uint32_t *parents, uint32_t t) {
    while (parents[t] != t) t = parents[t] = parents[parents[t]];
    return t;
}

static double angle_between(const double a[3], const double b[3]) {
    double cross[3];
    mcv_cross3(a, b, cross);
    return atan2(sqrt(cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2]),
                 a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

/* The difference between the interpolated normals of the two triangles at the edge's ends. */
static double jump_of_normals(const mcv_facets *f, const mcv_shared_edge *edge) {
    double most = 0, normals[2][3][3];
    const uint32_t *indices = f->scene->meshes[f->scene->instances[f->instance].mesh].indices;
    for (int side = 0; side < 2; ++side)
        mcv_scene_vertex_normals(f->scene, f->instance, edge->triangles[side], normals[side]);
    for (int end = 0; end < 2; ++end) {
        const double *at[2] = {normals[0][0], normals[1][0]};
        for (int side = 0; side < 2; ++side)
            for (int k = 0; k < 3; ++k)
                if (indices[3 * (size_t)edge->triangles[side] + k] == edge->ends[side][end])
                    at[side] = normals[side][k];
        most = fmax(most, angle_between(at[0], at[1]));
    }
    return most;
}

/* The largest bend of a facet, with the neighbour there, and the largest to any other neighbour. */
typedef struct largest_bends {
    double first, second;
    uint32_t neighbour;
} largest_bends;

static void take_bend(largest_bends *of, uint32_t neighbour, double angle) {
    if (of->first == 0 || neighbour == of->neighbour) {
        of->first = fmax(of->first, angle);
        of->neighbour = neighbour;
    } else if (angle > of->first) {
        *of = (largest_bends){angle, of->first, neighbour};
    } else {
        of->second = fmax(of->second, angle);
    }
}

static mcv_bend_kind kind_of(const largest_bends *bends, const uint32_t facet[2], double angle) {
    bool alone = true, like_another = false;
    for (int side = 0; side < 2; ++side) {
        const largest_bends *of = bends + facet[side];
        const double other = of->neighbour == facet[1 - side] ? of->second : of->first;
        if (other == 0) continue;
        if (angle > outlier * other) return MCV_BEND_EDGE;
        alone = false;
        like_another = like_another || angle > other / similar;
    }
    return alone ? MCV_BEND_EDGE : like_another ? MCV_BEND_CURVED : MCV_BEND_SLIGHT;
}

static bool judge_bends(mcv_facets *f, uint32_t triangles) {
    largest_bends *bends = calloc((size_t)triangles + 1, sizeof *bends);
    for (int pass = 0; pass < 2 && bends; ++pass)
        for (size_t i = 0; i < f->bend_count; ++i) {
            mcv_bend *b = f->bends + i;
            const uint32_t facet[2] = {root_of(f->parents, b->triangles[0]),
                                       root_of(f->parents, b->triangles[1])};
            for (int side = 0; side < 2 && pass == 0; ++side)
                take_bend(bends + facet[side], facet[1 - side], b->angle);
            if (pass == 0) continue;
            b->kind = kind_of(bends, facet, b->angle);
            f->curved_count += b->kind == MCV_BEND_CURVED;
        }
    const bool memory = bends != NULL;
    free(bends);
    return memory;
}

void mcv_facets_free(mcv_facets *f) {
    free(f->normals);
    free(f->parents);
    free(f->bends);
    *f = (mcv_facets){0};
}

mcv_result mcv_facets_of(const mcv_scene *scene, uint32_t instance, mcv_facets *f,
                         mcv_error *error) {
    const mcv_mesh *mesh = scene->meshes + scene->instances[instance].mesh;
    const size_t triangles = mesh->triangle_count;
    mcv_shared_edge *edges;
    size_t count;
    *f = (mcv_facets){.scene = scene, .instance = instance};
    MCV_TRY(mcv_shared_edges(mesh, &edges, &count, error));
    f->normals = calloc(triangles + 1, sizeof *f->normals);
    f->parents = malloc(triangles * sizeof *f->parents + 1);
    f->bends = calloc(count + 1, sizeof *f->bends);
    bool memory = f->normals && f->parents && f->bends;
    for (uint32_t t = 0; t < triangles && memory; ++t) {
        double face[3];
        f->parents[t] = t;
        mcv_scene_face_normal(scene, instance, t, face);
        mcv_normalize3(face, f->normals[t]);
    }
    for (size_t i = 0; i < count && memory; ++i) {
        const uint32_t a = edges[i].triangles[0], b = edges[i].triangles[1];
        const double angle = angle_between(f->normals[a], f->normals[b]);
        if (angle <= mcv_flat)
            f->parents[root_of(f->parents, a)] = root_of(f->parents, b);
        else if (angle < crease)
            f->bends[f->bend_count++] = (mcv_bend){
                .triangles = {a, b},
                .ends = {edges[i].ends[0][0], edges[i].ends[0][1]},
                .angle = angle,
                .faceted = mesh->normals == NULL || jump_of_normals(f, edges + i) > angle / 2};
    }
    free(edges);
    memory = memory && judge_bends(f, mesh->triangle_count);
    if (memory) return MCV_OK;
    mcv_facets_free(f);
    return mcv_fail(error, MCV_FAILED, "%s: no memory for the facets of its meshes", scene->path);
}

mcv_bend_range mcv_facets_range(const mcv_facets *f) {
    mcv_bend_range range = {0, INFINITY};
    for (size_t i = 0; i < f->bend_count; ++i) {
        const mcv_bend *b = f->bends + i;
        if (b->kind == MCV_BEND_CURVED && f->curved_count >= MCV_LEAST_BENDS)
            range.curved = fmax(range.curved, b->angle);
        else if (b->kind != MCV_BEND_SLIGHT && b->angle >= mcv_least_edge)
            range.edge = fmin(range.edge, b->angle);
    }
    return range;
}

double mcv_crease_degrees(mcv_bend_range range) {
    const double curved = range.curved / degree, edge = range.edge / degree;
    const double between = curved > 0 ? sqrt(curved * edge) : edge / 2;
    if (!(edge > curved) || between >= largest) return largest;
    const double whole = floor(between);
    return whole > curved ? whole : 0.5 * (curved + edge);
}
