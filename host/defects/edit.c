/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Meshes that get one defect after the other. The first one makes the mesh anew (replace.c), with
 * its vertices in the order in which triangles use them. Later ones append their facets and tell
 * which triangles are gone: their time is that of the defect, not of the mesh. Once all defects are
 * there, what is gone is left out; vertices and triangles are then in the same order as if each
 * defect had made the mesh anew.
 */
#include "defects/facets.h"

#include "scene/mesh.h"

#include <stdlib.h>
#include <string.h>

/* --- arrays that grow --- */

static bool grow(float **values, size_t width, size_t room) {
    if (!*values) return true;
    float *larger = realloc(*values, width * room * sizeof *larger);
    if (larger) *values = larger;
    return larger != NULL;
}

static bool make_room(mcv_mesh *m, mcv_known_mesh *known, const mcv_mesh *more) {
    const size_t vertices = (size_t)m->vertex_count + more->vertex_count,
                 triangles = (size_t)m->triangle_count + more->triangle_count;
    if (vertices > known->vertex_room) {
        const size_t room = vertices + vertices / 2;
        if (!grow(&m->positions, 3, room) || !grow(&m->normals, 3, room) ||
            !grow(&m->texcoords, 2, room) || !grow(&m->texcoords1, 2, room) ||
            !grow(&m->tangents, 4, room))
            return false;
        known->vertex_room = room;
    }
    if (triangles > known->triangle_room) {
        const size_t room = triangles + triangles / 2;
        uint32_t *indices = realloc(m->indices, 3 * room * sizeof *indices);
        if (indices) m->indices = indices;
        uint8_t *gone = realloc(known->gone, room);
        if (gone) known->gone = gone;
        if (!indices || !gone) return false;
        known->triangle_room = room;
    }
    return true;
}

static void copy_behind(float *to, const float *from, size_t width, size_t begin, size_t count) {
    if (to && from) memcpy(to + width * begin, from, width * count * sizeof *to);
}

static bool append(mcv_mesh *m, mcv_known_mesh *known, const mcv_mesh *more) {
    if (!make_room(m, known, more)) return false;
    const size_t begin = m->vertex_count, count = more->vertex_count;
    copy_behind(m->positions, more->positions, 3, begin, count);
    copy_behind(m->normals, more->normals, 3, begin, count);
    copy_behind(m->texcoords, more->texcoords, 2, begin, count);
    copy_behind(m->texcoords1, more->texcoords1, 2, begin, count);
    copy_behind(m->tangents, more->tangents, 4, begin, count);
    uint32_t *indices = m->indices + 3 * (size_t)m->triangle_count;
    for (size_t i = 0; i < 3 * (size_t)more->triangle_count; ++i)
        indices[i] = more->indices[i] + m->vertex_count;
    memset(known->gone + m->triangle_count, 0, more->triangle_count);
    m->vertex_count += more->vertex_count;
    m->triangle_count += more->triangle_count;
    return true;
}

/* --- edits --- */

static void forget(mcv_known_mesh *known) {
    free(known->boxes.items);
    free(known->gone);
    *known = (mcv_known_mesh){0};
}

/* From now on the mesh is appended to. */
static mcv_result begin(mcv_scene *scene, mcv_known_meshes *known, uint32_t number,
                        const mcv_json_path *place, mcv_error *error) {
    mcv_known_mesh *mesh = mcv_known_mesh_of(known, scene, number);
    if (!mesh) return mcv_fail_memory(place, error);
    forget(mesh);
    mesh->vertex_room = scene->meshes[number].vertex_count;
    mesh->triangle_room = scene->meshes[number].triangle_count;
    mesh->gone = calloc(mesh->triangle_room + 1, 1);
    return mesh->gone ? MCV_OK : mcv_fail_memory(place, error);
}

/* Leaves out what is gone. */
static mcv_result compact(mcv_scene *scene, mcv_known_meshes *known, uint32_t instance,
                          const mcv_json_path *place, mcv_error *error) {
    const uint32_t number = scene->instances[instance].mesh;
    const mcv_facets none = {NULL, 0, 0};
    mcv_mesh mesh;
    MCV_TRY(mcv_facets_mesh(&none, scene, instance, known->items[number].gone, false, false, &mesh,
                            place, error));
    mcv_mesh_free(scene->meshes + number);
    scene->meshes[number] = mesh;
    return begin(scene, known, number, place, error);
}

static mcv_result edit(const mcv_facets *facets, mcv_scene *scene, mcv_known_meshes *known,
                       uint32_t instance, const mcv_marks *marks, bool patch,
                       const mcv_json_path *place, mcv_error *error) {
    const uint32_t number = scene->instances[instance].mesh;
    mcv_known_mesh *mesh = known->items + number;
    mcv_mesh more;
    MCV_TRY(mcv_facets_mesh(facets, scene, instance, NULL, patch, false, &more, place, error));
    for (size_t i = 0; i < marks->count; ++i) mesh->gone[marks->items[i].triangle] = 1;
    mesh->gone_count += (uint32_t)marks->count;
    const bool memory = append(scene->meshes + number, mesh, &more);
    mcv_mesh_free(&more);
    if (!memory) return mcv_fail_memory(place, error);
    /* Without this, many defects in one place would keep all triangles that earlier ones made. */
    return mesh->gone_count > scene->meshes[number].triangle_count / 2
               ? compact(scene, known, instance, place, error)
               : MCV_OK;
}

mcv_result mcv_facets_edit(const mcv_facets *facets, mcv_scene *scene, mcv_known_meshes *known,
                           uint32_t instance, const mcv_marks *marks, const mcv_defect *defect,
                           const mcv_json_path *place, mcv_error *error) {
    const uint32_t number = scene->instances[instance].mesh;
    if (mcv_known_gone(known, number))
        return edit(facets, scene, known, instance, marks,
                    mcv_defect_kind_of(defect->type) == MCV_KIND_PATCH, place, error);
    uint8_t *bytes = calloc(scene->meshes[number].triangle_count + (size_t)1, 1);
    if (!bytes) return mcv_fail_memory(place, error);
    for (size_t i = 0; i < marks->count; ++i) bytes[marks->items[i].triangle] = 1;
    const mcv_result result =
        mcv_facets_replace(facets, scene, instance, bytes, defect, place, error);
    free(bytes);
    MCV_TRY(result);
    return begin(scene, known, scene->instances[instance].mesh, place, error);
}

mcv_result mcv_defects_finish(mcv_scene *scene, mcv_known_meshes *known, const mcv_json_path *place,
                              mcv_error *error) {
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        const uint32_t number = scene->instances[i].mesh;
        if (number < known->count && known->items[number].gone_count > 0)
            MCV_TRY(compact(scene, known, i, place, error));
    }
    return mcv_scene_number_triangles(scene, place, error);
}
