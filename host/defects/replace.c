/* SPDX-License-Identifier: Apache-2.0 */
/* Facets back into the indexed mesh of an instance (facets.h). */
#include "defects/facets.h"

#include "core/basics.h"
#include "scene/mesh.h"
#include "scene/transform.h"

#include <stdlib.h>
#include <string.h>

/* Of a flat triangle. */
static void face_normal(const float a[3], const float b[3], const float c[3], float normal[3]) {
    double edge[2][3], n[3], unit[3] = {0, 0, 1};
    for (int i = 0; i < 3; ++i) {
        edge[0][i] = (double)b[i] - a[i];
        edge[1][i] = (double)c[i] - a[i];
    }
    mcv_cross3(edge[0], edge[1], n);
    mcv_normalize3(n, unit);
    for (int i = 0; i < 3; ++i) normal[i] = (float)unit[i];
}

static void copy_or_zero(float *to, const float *from, size_t count) {
    if (from)
        memcpy(to, from, count * sizeof *to);
    else
        memset(to, 0, count * sizeof *to);
}

static void take_corner(const mcv_mesh *m, size_t v, mcv_corner *c) {
    memcpy(c->position, m->positions + 3 * v, sizeof c->position);
    copy_or_zero(c->normal, m->normals ? m->normals + 3 * v : NULL, 3);
    copy_or_zero(c->texcoord, m->texcoords ? m->texcoords + 2 * v : NULL, 2);
    copy_or_zero(c->texcoord1, m->texcoords1 ? m->texcoords1 + 2 * v : NULL, 2);
    copy_or_zero(c->tangent, m->tangents ? m->tangents + 4 * v : NULL, 4);
}

mcv_facet mcv_facet_take(const mcv_scene *scene, uint32_t instance, uint32_t triangle) {
    const mcv_mesh *m = scene->meshes + scene->instances[instance].mesh;
    mcv_facet facet = {.instance = instance};
    for (size_t k = 0; k < 3; ++k)
        take_corner(m, m->indices[3 * (size_t)triangle + k], facet.corners + k);
    if (m->normals) return facet;
    for (int k = 0; k < 3; ++k)
        face_normal(facet.corners[0].position, facet.corners[1].position, facet.corners[2].position,
                    facet.corners[k].normal);
    return facet;
}

/* A mesh that grows, with a table of its vertices by their bytes. */
typedef struct building {
    mcv_mesh mesh;
    uint32_t *table; /* of vertices + 1; 0: free */
    size_t mask;
    mcv_corner *corners; /* of all vertices */
} building;

static bool begin(building *b, const mcv_mesh *old, size_t triangles) {
    size_t size = 64;
    while (size < 6 * triangles) size *= 2;
    *b = (building){.mask = size - 1};
    b->table = calloc(size, sizeof *b->table);
    b->corners = malloc((3 * triangles + 1) * sizeof *b->corners);
    b->mesh.indices = malloc((3 * triangles + 1) * sizeof *b->mesh.indices);
    b->mesh.name = strdup(old->name ? old->name : "");
    return b->table && b->corners && b->mesh.indices && b->mesh.name;
}

static void end(building *b) {
    free(b->table);
    free(b->corners);
    mcv_mesh_free(&b->mesh);
}

/* The number of a vertex with exactly these bytes. Adding 0 makes -0 0. */
static uint32_t vertex_of(building *b, const mcv_corner *corner) {
    float words[sizeof *corner / sizeof(float)];
    memcpy(words, corner, sizeof words);
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) words[i] += 0.0f;
    size_t slot = (size_t)mcv_hash_bytes(MCV_HASH_BEGIN, words, sizeof words) & b->mask;
    for (; b->table[slot]; slot = (slot + 1) & b->mask)
        if (memcmp(b->corners + b->table[slot] - 1, words, sizeof words) == 0)
            return b->table[slot] - 1;
    memcpy(b->corners + b->mesh.vertex_count, words, sizeof words);
    b->table[slot] = ++b->mesh.vertex_count;
    return b->mesh.vertex_count - 1;
}

/* Triangles that have shrunk to nothing in float32 are left out. */
static void add_facet(building *b, const mcv_facet *facet) {
    const mcv_corner *c = facet->corners;
    for (int k = 0; k < 3; ++k)
        if (memcmp(c[k].position, c[(k + 1) % 3].position, sizeof c[k].position) == 0) return;
    for (int k = 0; k < 3; ++k)
        b->mesh.indices[3 * (size_t)b->mesh.triangle_count + (size_t)k] = vertex_of(b, c + k);
    ++b->mesh.triangle_count;
}

/* The corners as the arrays of a mesh like the old one. */
static bool spread(building *b, const mcv_mesh *old) {
    mcv_mesh *m = &b->mesh;
    const size_t n = m->vertex_count + (size_t)1;
    m->positions = malloc(n * 3 * sizeof(float));
    m->normals = malloc(n * 3 * sizeof(float));
    m->texcoords = old->texcoords ? malloc(n * 2 * sizeof(float)) : NULL;
    m->texcoords1 = old->texcoords1 ? malloc(n * 2 * sizeof(float)) : NULL;
    m->tangents = old->tangents ? malloc(n * 4 * sizeof(float)) : NULL;
    if (!m->positions || !m->normals || (old->texcoords && !m->texcoords) ||
        (old->texcoords1 && !m->texcoords1) || (old->tangents && !m->tangents))
        return false;
    for (size_t v = 0; v < m->vertex_count; ++v) {
        const mcv_corner *c = b->corners + v;
        memcpy(m->positions + 3 * v, c->position, sizeof c->position);
        memcpy(m->normals + 3 * v, c->normal, sizeof c->normal);
        if (m->texcoords) memcpy(m->texcoords + 2 * v, c->texcoord, sizeof c->texcoord);
        if (m->texcoords1) memcpy(m->texcoords1 + 2 * v, c->texcoord1, sizeof c->texcoord1);
        if (m->tangents) memcpy(m->tangents + 4 * v, c->tangent, sizeof c->tangent);
    }
    return true;
}

/* The mesh changes owners. It takes the old one's place unless other instances use that. */
static mcv_result put(mcv_scene *scene, uint32_t instance, mcv_mesh *mesh, mcv_error *error) {
    const uint32_t number = scene->instances[instance].mesh;
    uint32_t users = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        users += scene->instances[i].mesh == number;
    if (users > 1) {
        MCV_TRY(mcv_scene_take_mesh(scene, mesh, error));
        scene->instances[instance].mesh = scene->mesh_count - 1;
    } else {
        mcv_mesh_free(scene->meshes + number);
        scene->meshes[number] = *mesh;
    }
    *mesh = (mcv_mesh){0};
    return MCV_OK;
}

/* Is it a facet of the mesh that is made? */
typedef struct choice {
    uint32_t instance;
    bool patch, of_patch;
} choice;

static bool chosen(const choice *which, const mcv_facet *facet) {
    return facet->instance == which->instance &&
           (!which->patch || facet->within == which->of_patch);
}

static size_t count_facets(const mcv_facets *facets, const choice *which) {
    size_t count = 0;
    for (size_t f = 0; f < facets->count; ++f) count += chosen(which, facets->items + f);
    return count;
}

/* Triangles that are not marked. Of a mesh with normals they keep their vertices: only the facets
 * need to be looked up, and a large mesh with a small defect is made in the time of a copy. */
static bool keep(building *b, const mcv_scene *scene, uint32_t instance, const uint8_t *marks,
                 uint32_t count) {
    const mcv_mesh *old = scene->meshes + scene->instances[instance].mesh;
    uint32_t *numbers = calloc(old->vertex_count + (size_t)1, sizeof *numbers); /* new + 1 */
    for (uint32_t t = 0; t < count && numbers; ++t) {
        if (marks[t]) continue;
        if (!old->normals) {
            const mcv_facet kept = mcv_facet_take(scene, instance, t);
            add_facet(b, &kept);
            continue;
        }
        for (size_t k = 0; k < 3; ++k) {
            const size_t vertex = old->indices[3 * (size_t)t + k];
            uint32_t *number = numbers + vertex;
            if (!*number) {
                take_corner(old, vertex, b->corners + b->mesh.vertex_count);
                *number = ++b->mesh.vertex_count;
            }
            b->mesh.indices[3 * (size_t)b->mesh.triangle_count + k] = *number - 1;
        }
        ++b->mesh.triangle_count;
    }
    free(numbers);
    return numbers != NULL;
}

mcv_result mcv_facets_mesh(const mcv_facets *facets, const mcv_scene *scene, uint32_t instance,
                           const uint8_t *marks, bool patch, bool of_patch, mcv_mesh *mesh,
                           const mcv_json_path *place, mcv_error *error) {
    const mcv_mesh *old = scene->meshes + scene->instances[instance].mesh;
    const choice which = {instance, patch, of_patch};
    const uint32_t kept_count = marks ? old->triangle_count : 0;
    building b;
    *mesh = (mcv_mesh){0};
    if (!begin(&b, old, kept_count + count_facets(facets, &which))) {
        end(&b);
        return mcv_fail_memory(place, error);
    }
    const bool memory_for_kept = keep(&b, scene, instance, marks, kept_count);
    for (size_t f = 0; f < facets->count; ++f)
        if (chosen(&which, facets->items + f)) add_facet(&b, facets->items + f);
    const bool memory = memory_for_kept && spread(&b, old);
    if (memory) {
        *mesh = b.mesh;
        b.mesh = (mcv_mesh){0};
    }
    end(&b);
    return memory ? MCV_OK : mcv_fail_memory(place, error);
}

mcv_result mcv_facets_replace(const mcv_facets *facets, mcv_scene *scene, uint32_t instance,
                              const uint8_t *marks, const mcv_defect *defect,
                              const mcv_json_path *place, mcv_error *error) {
    mcv_mesh mesh;
    MCV_TRY(mcv_facets_mesh(facets, scene, instance, marks,
                            mcv_defect_kind_of(defect->type) == MCV_KIND_PATCH, false, &mesh, place,
                            error));
    const mcv_result result = put(scene, instance, &mesh, error);
    mcv_mesh_free(&mesh);
    return result;
}
