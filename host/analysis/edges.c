/* SPDX-License-Identifier: Apache-2.0 */
/* mcv_open_edges: is a body closed? */
#include "analysis/setup.h"

#include <stdlib.h>
#include <string.h>

/* Which vertex (of all the instances') stands where. */
typedef struct vertex {
    float position[3];
    uint32_t number;
} vertex;

/* An edge between two welded vertices; +1 if run from the lower to the higher number, else -1. */
typedef struct edge {
    uint32_t low, high;
    int32_t run;
} edge;

static int compare_vertices(const void *a, const void *b) {
    const vertex *p = a, *q = b;
    for (int k = 0; k < 3; ++k)
        if (p->position[k] != q->position[k]) return p->position[k] < q->position[k] ? -1 : 1;
    return 0;
}

static int compare_edges(const void *a, const void *b) {
    const edge *p = a, *q = b;
    if (p->low != q->low) return p->low < q->low ? -1 : 1;
    return p->high < q->high ? -1 : p->high > q->high;
}

/* Gives vertices at one position one number. */
static void weld(vertex *vertices, size_t count, uint32_t *welded) {
    uint32_t number = 0;
    qsort(vertices, count, sizeof *vertices, compare_vertices);
    for (size_t i = 0; i < count; ++i) {
        if (i > 0 && compare_vertices(vertices + i - 1, vertices + i) != 0) ++number;
        welded[vertices[i].number] = number;
    }
}

static uint32_t count_unpaired(edge *edges, size_t count) {
    uint32_t open = 0;
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t i = 0, next; i < count; i = next) {
        int32_t sum = 0;
        for (next = i; next < count && compare_edges(edges + i, edges + next) == 0; ++next) sum += edges[next].run;
        open += sum != 0;
    }
    return open;
}

mcv_result mcv_open_edges(const mcv_scene *scene, uint32_t first, uint32_t last, uint32_t *edges_out, mcv_error *error) {
    size_t vertex_count = 0, triangle_count = 0, v = 0, e = 0;
    for (uint32_t i = first; i < last; ++i) {
        vertex_count += scene->meshes[scene->instances[i].mesh].vertex_count;
        triangle_count += scene->meshes[scene->instances[i].mesh].triangle_count;
    }
    vertex *vertices = malloc(vertex_count * sizeof *vertices + 1);
    uint32_t *welded = malloc(vertex_count * sizeof *welded + 1);
    edge *edges = malloc(3 * triangle_count * sizeof *edges + 1);
    const bool memory = vertices && welded && edges;
    if (memory) {
        for (uint32_t i = first; i < last; ++i) {
            const mcv_mesh *mesh = scene->meshes + scene->instances[i].mesh;
            for (uint32_t k = 0; k < mesh->vertex_count; ++k, ++v) {
                vertices[v].number = (uint32_t)v;
                memcpy(vertices[v].position, mesh->positions + 3 * (size_t)k, sizeof vertices[v].position);
            }
        }
        weld(vertices, vertex_count, welded);
        uint32_t offset = 0;
        for (uint32_t i = first; i < last; ++i) {
            const mcv_mesh *mesh = scene->meshes + scene->instances[i].mesh;
            for (size_t k = 0; k < 3 * (size_t)mesh->triangle_count; ++k) {
                const uint32_t a = welded[offset + mesh->indices[k]];
                const uint32_t b = welded[offset + mesh->indices[k % 3 == 2 ? k - 2 : k + 1]];
                if (a == b) continue; /* of a degenerate triangle */
                edges[e++] = a < b ? (edge){a, b, 1} : (edge){b, a, -1};
            }
            offset += mesh->vertex_count;
        }
        *edges_out = count_unpaired(edges, e);
    }
    free(vertices);
    free(welded);
    free(edges);
    return memory ? MCV_OK : mcv_fail(error, MCV_FAILED, "%s: no memory for the edges of its meshes", scene->path);
}
