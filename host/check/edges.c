/* SPDX-License-Identifier: Apache-2.0 */
/* The edges of meshes: which bodies are closed, and which triangles are neighbours. */
#include "check/findings.h"

#include <stdlib.h>
#include <string.h>

/* A vertex of one of the instances, with its position. */
typedef struct vertex {
    float position[3];
    uint32_t number;
} vertex;

/* An edge between two welded vertices: +1 if it runs from the lower to the higher index, else
 * -1. */
typedef struct edge {
    uint32_t low, high;
    int32_t run;
    uint32_t corner; /* index of its first corner, 3 per triangle; it runs to the triangle's next
                        corner */
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

/* All edges of the meshes of instances, or of one mesh, sorted; *count of them. NULL without
 * memory. */
static edge *sorted_edges(const mcv_mesh *const *meshes, uint32_t mesh_count, size_t *count) {
    size_t vertex_count = 0, triangle_count = 0, v = 0, e = 0;
    for (uint32_t i = 0; i < mesh_count; ++i) {
        vertex_count += meshes[i]->vertex_count;
        triangle_count += meshes[i]->triangle_count;
    }
    vertex *vertices = malloc(vertex_count * sizeof *vertices + 1);
    uint32_t *welded = malloc(vertex_count * sizeof *welded + 1);
    edge *edges = malloc(3 * triangle_count * sizeof *edges + 1);
    const bool memory = vertices && welded && edges;
    for (uint32_t i = 0; i < mesh_count && memory; ++i)
        for (uint32_t k = 0; k < meshes[i]->vertex_count; ++k, ++v) {
            vertices[v].number = (uint32_t)v;
            memcpy(vertices[v].position, meshes[i]->positions + 3 * (size_t)k,
                   sizeof vertices[v].position);
        }
    if (memory) weld(vertices, vertex_count, welded);
    uint32_t offset = 0, corner = 0;
    for (uint32_t i = 0; i < mesh_count && memory; ++i) {
        for (size_t k = 0; k < 3 * (size_t)meshes[i]->triangle_count; ++k, ++corner) {
            const uint32_t a = welded[offset + meshes[i]->indices[k]];
            const uint32_t b = welded[offset + meshes[i]->indices[k % 3 == 2 ? k - 2 : k + 1]];
            if (a == b) continue; /* of a degenerate triangle */
            edges[e++] = a < b ? (edge){a, b, 1, corner} : (edge){b, a, -1, corner};
        }
        offset += meshes[i]->vertex_count;
    }
    if (memory) qsort(edges, e, sizeof *edges, compare_edges);
    free(vertices);
    free(welded);
    if (!memory) free(edges);
    *count = e;
    return memory ? edges : NULL;
}

static uint32_t count_unpaired(const edge *edges, size_t count) {
    uint32_t open = 0;
    for (size_t i = 0, next; i < count; i = next) {
        int32_t sum = 0;
        for (next = i; next < count && compare_edges(edges + i, edges + next) == 0; ++next)
            sum += edges[next].run;
        open += sum != 0;
    }
    return open;
}

mcv_result mcv_open_edges(const mcv_scene *scene, uint32_t first, uint32_t last,
                          uint32_t *edges_out, mcv_error *error) {
    size_t count = 0;
    const mcv_mesh **meshes = malloc((last - first) * sizeof *meshes + 1);
    for (uint32_t i = first; meshes && i < last; ++i)
        meshes[i - first] = scene->meshes + scene->instances[i].mesh;
    edge *edges = meshes ? sorted_edges(meshes, last - first, &count) : NULL;
    if (edges) *edges_out = count_unpaired(edges, count);
    free(meshes);
    free(edges);
    return edges ? MCV_OK
                 : mcv_fail(error, MCV_FAILED, "%s: no memory for the edges of its meshes",
                            scene->path);
}

mcv_result mcv_shared_edges(const mcv_mesh *mesh, mcv_shared_edge **edges, size_t *count,
                            mcv_error *error) {
    size_t all_count = 0, found = 0;
    edge *all = sorted_edges(&mesh, 1, &all_count);
    *edges = all ? malloc(all_count / 2 * sizeof **edges + 1) : NULL;
    for (size_t i = 0, next; *edges && i < all_count; i = next) {
        for (next = i; next < all_count && compare_edges(all + i, all + next) == 0;) ++next;
        if (next - i != 2 || all[i].run + all[i + 1].run != 0) continue;
        mcv_shared_edge *to = *edges + found++;
        for (int side = 0; side < 2; ++side) {
            const uint32_t at = all[i + (size_t)side].corner,
                           following = at % 3 == 2 ? at - 2 : at + 1;
            to->triangles[side] = at / 3;
            to->ends[side][side] = mesh->indices[at];
            to->ends[side][1 - side] = mesh->indices[following];
        }
    }
    free(all);
    *count = found;
    return *edges
               ? MCV_OK
               : mcv_fail(error, MCV_FAILED, "no memory for the edges of mesh \"%s\"", mesh->name);
}
