/* SPDX-License-Identifier: Apache-2.0 */
/* Defects in meshes: refines around them and moves vertices and normals (mcvisi/defects.h). */
#include "defects/facets.h"

#include "scene/geometry.h"
#include "scene/memory.h"
#include "scene/mesh.h"
#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Refines what must be: what `marks` says, and what lies beside, which is marked then, too. */
static mcv_result refine(const mcv_ground *ground, uint8_t *const *marks, mcv_facets *facets,
                         const mcv_json_path *place, mcv_error *error) {
    const mcv_scene *scene = ground->scene;
    const uint32_t first = ground->defect->instances[0];
    for (uint32_t i = first; i < ground->defect->instances[1]; ++i) {
        const uint32_t mesh = scene->instances[i].mesh, count = scene->meshes[mesh].triangle_count;
        const mcv_mesh_boxes *boxes = mcv_known_boxes(ground->known, scene, mesh);
        if (!boxes) return mcv_fail_memory(place, error);
        bool spared = false;
        for (uint32_t t = 0; t < count; ++t) {
            uint8_t *marked = &marks[i - first][t];
            if (t % MCV_BOX_TRIANGLES == 0)
                spared = mcv_ground_spares_box(ground, i, boxes->items + t / MCV_BOX_TRIANGLES);
            if (!*marked && (spared || mcv_ground_spares(ground, i, t))) continue;
            mcv_facet facet = mcv_facet_take(scene, i, t);
            facet.inside = *marked;
            for (int k = 0; k < 3 && !*marked; ++k)
                *marked =
                    mcv_ground_splits(ground, i, &facet.corners[k], &facet.corners[(k + 1) % 3]);
            if (*marked) MCV_TRY(mcv_facets_refine(facets, ground, &facet, place, error));
        }
    }
    return MCV_OK;
}

/* A patch stays where it is. */
static mcv_result change(const mcv_ground *ground, mcv_facets *facets, const mcv_json_path *place,
                         mcv_error *error) {
    const mcv_defect_kind kind = mcv_defect_kind_of(ground->defect->type);
    if (kind != MCV_KIND_RELIEF) MCV_TRY(mcv_facets_cut(facets, ground, place, error));
    for (size_t f = 0; f < facets->count && kind != MCV_KIND_PATCH; ++f) {
        mcv_facet *one = facets->items + f;
        for (int k = 0; k < 3 && (kind == MCV_KIND_RELIEF ? one->inside : one->within); ++k)
            mcv_facet_move(ground, one, k);
    }
    return MCV_OK;
}

/*
 * The bytes by which the scene grows as facets replace the marked triangles of an instance. A mesh
 * that other instances have, too, is copied. Vertices of a flat mesh are no longer shared, and get
 * normals.
 */
static uint64_t growth_of(const mcv_scene *scene, uint32_t instance, const mcv_facets *facets,
                          const uint8_t *marked) {
    const uint64_t triangle = MCV_TRIANGLE_BYTES + 3 * sizeof(uint32_t) + sizeof(mcv_corner);
    const uint32_t number = scene->instances[instance].mesh;
    const mcv_mesh *old = scene->meshes + number;
    uint64_t removed = 0, added = 0, users = 0;
    for (uint32_t t = 0; t < old->triangle_count; ++t) removed += marked[t];
    for (size_t f = 0; f < facets->count; ++f) added += facets->items[f].instance == instance;
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        users += scene->instances[i].mesh == number;
    return (added > removed ? triangle * (added - removed) : 0) +
           (users > 1 ? mcv_mesh_bytes(old) : 0) +
           (old->normals ? 0 : 3 * sizeof(float[6]) * (old->triangle_count - removed));
}

static mcv_result replace_one(mcv_scene *scene, uint32_t instance, const mcv_defect *defect,
                              const mcv_facets *facets, const uint8_t *marked,
                              const mcv_json_path *place, mcv_error *error) {
    if (!memchr(marked, 1, scene->meshes[scene->instances[instance].mesh].triangle_count))
        return MCV_OK;
    if (scene->instances[instance].emitter != MCV_NONE)
        return mcv_fail_at(place, error,
                           "node \"%s\" emits light: defects are for surfaces that do not",
                           scene->instances[instance].name);
    MCV_TRY(mcv_memory_take(&scene->memory, &scene->memory.geometry,
                            growth_of(scene, instance, facets, marked), place, error));
    if (mcv_defect_kind_of(defect->type) == MCV_KIND_PATCH)
        MCV_TRY(mcv_facets_add_patch(facets, scene, instance, marked, defect, place, error));
    return mcv_facets_replace(facets, scene, instance, marked, defect, place, error);
}

/* From the last instance on: a patch moves the numbers of those behind it. */
static mcv_result replace_all(mcv_scene *scene, const mcv_defect *defect, const mcv_facets *facets,
                              uint8_t *const *marks, const mcv_json_path *place, mcv_error *error) {
    for (uint32_t i = defect->instances[1]; i-- > defect->instances[0];)
        MCV_TRY(
            replace_one(scene, i, defect, facets, marks[i - defect->instances[0]], place, error));
    return mcv_scene_number_triangles(scene, place, error);
}

/* A byte for each triangle of the defect's instances; NULL without memory. */
static uint8_t **new_marks(const mcv_scene *scene, const uint32_t instances[2]) {
    size_t triangles = 0;
    const uint32_t count = instances[1] - instances[0];
    for (uint32_t i = instances[0]; i < instances[1]; ++i)
        triangles += scene->meshes[scene->instances[i].mesh].triangle_count;
    uint8_t **marks = malloc(((size_t)count + 1) * sizeof *marks);
    uint8_t *bytes = calloc(triangles + 1, 1);
    if (!marks || !bytes) {
        free((void *)marks);
        free(bytes);
        return NULL;
    }
    marks[0] = bytes;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t mesh = scene->instances[instances[0] + i].mesh;
        marks[i + 1] = marks[i] + scene->meshes[mesh].triangle_count;
    }
    return marks;
}

static void free_marks(uint8_t **marks) {
    if (marks) free(marks[0]);
    free((void *)marks);
}

mcv_result mcv_defect_fits(const mcv_scene *scene, mcv_known_meshes *known,
                           const mcv_defect *defect, const mcv_json_path *place, mcv_error *error) {
    mcv_ground ground = mcv_ground_of(scene, known, defect);
    return mcv_ground_find(&ground, NULL, place, error);
}

mcv_result mcv_defect_apply(mcv_scene *scene, const mcv_defect *defect, const mcv_json_path *place,
                            mcv_error *error) {
    if (mcv_defect_is_inside(defect->type)) return mcv_defect_embed(scene, defect, error);
    mcv_known_meshes known = {0};
    mcv_ground ground = mcv_ground_of(scene, &known, defect);
    mcv_facets facets = {NULL, 0, 0};
    uint8_t **marks = new_marks(scene, defect->instances);
    mcv_result result =
        marks ? mcv_ground_find(&ground, marks, place, error) : mcv_fail_memory(place, error);
    if (result == MCV_OK) result = refine(&ground, marks, &facets, place, error);
    if (result == MCV_OK) result = change(&ground, &facets, place, error);
    if (result == MCV_OK) result = replace_all(scene, defect, &facets, marks, place, error);
    mcv_known_meshes_free(&known);
    free_marks(marks);
    free(facets.items);
    return result;
}
