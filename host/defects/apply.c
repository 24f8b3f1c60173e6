/* SPDX-License-Identifier: Apache-2.0 */
/* Defects in meshes: refines around them and moves vertices and normals (mcvisi/defects.h). */
#include "defects/facets.h"

#include "scene/geometry.h"
#include "scene/memory.h"
#include "scene/mesh.h"
#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>

bool mcv_marks_add(mcv_marks *marks, uint32_t instance, uint32_t triangle) {
    if (marks->count == marks->room) {
        const size_t room = marks->room ? 2 * marks->room : 256;
        mcv_mark *larger = realloc(marks->items, room * sizeof *larger);
        if (!larger) return false;
        marks->items = larger;
        marks->room = room;
    }
    marks->items[marks->count++] = (mcv_mark){instance, triangle};
    return true;
}

/* While a defect refines: the triangles that were found, in their order, and all that are refined.
 */
typedef struct refining {
    const mcv_ground *ground;
    const mcv_mark *found, *found_end;
    mcv_marks *marks;
    mcv_facets *facets;
} refining;

static mcv_result refine_triangle(refining *r, uint32_t instance, uint32_t triangle, bool found,
                                  const mcv_json_path *place, mcv_error *error) {
    const mcv_ground *ground = r->ground;
    bool marked = found;
    if (!found && mcv_ground_spares(ground, instance, triangle)) return MCV_OK;
    mcv_facet facet = mcv_facet_take(ground->scene, instance, triangle);
    facet.inside = found;
    for (int k = 0; k < 3 && !marked; ++k)
        marked =
            mcv_ground_splits(ground, instance, &facet.corners[k], &facet.corners[(k + 1) % 3]);
    if (!marked) return MCV_OK;
    if (!mcv_marks_add(r->marks, instance, triangle)) return mcv_fail_memory(place, error);
    return mcv_facets_refine(r->facets, ground, &facet, place, error);
}

/* Whether the triangle is the next one that was found. */
static bool take_found(refining *r, uint32_t instance, uint32_t triangle) {
    const bool found =
        r->found < r->found_end && r->found->instance == instance && r->found->triangle == triangle;
    r->found += found;
    return found;
}

static mcv_result refine_instance(refining *r, uint32_t instance, const mcv_json_path *place,
                                  mcv_error *error) {
    const mcv_ground *ground = r->ground;
    const uint32_t mesh = ground->scene->instances[instance].mesh,
                   count = ground->scene->meshes[mesh].triangle_count;
    const mcv_mesh_boxes *boxes = mcv_known_boxes(ground->known, ground->scene, mesh);
    const uint8_t *gone = mcv_known_gone(ground->known, mesh);
    if (!boxes) return mcv_fail_memory(place, error);
    const bool all_spared = mcv_ground_spares_box(ground, instance, &boxes->all);
    for (uint32_t first = 0; first < count; first += MCV_BOX_TRIANGLES) {
        const uint32_t end = count - first < MCV_BOX_TRIANGLES ? count : first + MCV_BOX_TRIANGLES;
        const bool has_found =
            r->found < r->found_end && r->found->instance == instance && r->found->triangle < end;
        if (!has_found && all_spared) {
            if (r->found == r->found_end || r->found->instance != instance) return MCV_OK;
            continue;
        }
        const bool spared =
            all_spared ||
            mcv_ground_spares_box(ground, instance, boxes->items + first / MCV_BOX_TRIANGLES);
        for (uint32_t t = first; t < end && (has_found || !spared); ++t) {
            const bool found = take_found(r, instance, t);
            if ((gone && gone[t]) || (spared && !found)) continue;
            MCV_TRY(refine_triangle(r, instance, t, found, place, error));
        }
    }
    return MCV_OK;
}

/* Refines what must be: what was found, and what lies beside. `marks` get all of that. */
static mcv_result refine(const mcv_ground *ground, const mcv_marks *found, mcv_marks *marks,
                         mcv_facets *facets, const mcv_json_path *place, mcv_error *error) {
    refining r = {.ground = ground, .marks = marks, .facets = facets};
    r.found = found->items;
    r.found_end = found->count ? found->items + found->count : found->items;
    for (uint32_t i = ground->defect->instances[0]; i < ground->defect->instances[1]; ++i)
        MCV_TRY(refine_instance(&r, i, place, error));
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
                          const mcv_marks *marked) {
    const uint64_t triangle = MCV_TRIANGLE_BYTES + 3 * sizeof(uint32_t) + sizeof(mcv_corner);
    const uint32_t number = scene->instances[instance].mesh;
    const mcv_mesh *old = scene->meshes + number;
    const uint64_t removed = marked->count;
    uint64_t added = 0, users = 0;
    for (size_t f = 0; f < facets->count; ++f) added += facets->items[f].instance == instance;
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        users += scene->instances[i].mesh == number;
    return (added > removed ? triangle * (added - removed) : 0) +
           (users > 1 ? mcv_mesh_bytes(old) : 0) +
           (old->normals ? 0 : 3 * sizeof(float[6]) * (old->triangle_count - removed));
}

static mcv_result replace_one(mcv_scene *scene, mcv_known_meshes *known, uint32_t instance,
                              const mcv_defect *defect, const mcv_facets *facets,
                              const mcv_marks *marked, const mcv_json_path *place,
                              mcv_error *error) {
    const uint32_t mesh = scene->instances[instance].mesh;
    const uint32_t gone = mesh < known->count ? known->items[mesh].gone_count : 0,
                   left = scene->meshes[mesh].triangle_count - gone;
    if (scene->instances[instance].emitter != MCV_NONE)
        return mcv_fail_at(place, error,
                           "node \"%s\" emits light: defects are for surfaces that do not",
                           scene->instances[instance].name);
    MCV_TRY(mcv_memory_take(&scene->memory, &scene->memory.geometry,
                            growth_of(scene, instance, facets, marked), place, error));
    if (mcv_defect_kind_of(defect->type) == MCV_KIND_PATCH)
        MCV_TRY(mcv_facets_add_patch(facets, scene, instance, marked->count == left, defect, place,
                                     error));
    return mcv_facets_edit(facets, scene, known, instance, marked, defect, place, error);
}

/* From the last instance on: a patch moves the numbers of those behind it. */
static mcv_result replace_all(mcv_scene *scene, mcv_known_meshes *known, const mcv_defect *defect,
                              const mcv_facets *facets, const mcv_marks *marks,
                              const mcv_json_path *place, mcv_error *error) {
    for (size_t end = marks->count; end > 0;) {
        const uint32_t instance = marks->items[end - 1].instance;
        size_t begin = end;
        while (begin > 0 && marks->items[begin - 1].instance == instance) --begin;
        const mcv_marks own = {.items = marks->items + begin, .count = end - begin};
        MCV_TRY(replace_one(scene, known, instance, defect, facets, &own, place, error));
        end = begin;
    }
    return mcv_scene_number_triangles(scene, place, error);
}

mcv_result mcv_defect_fits(const mcv_scene *scene, mcv_known_meshes *known,
                           const mcv_defect *defect, const mcv_json_path *place, mcv_error *error) {
    mcv_ground ground = mcv_ground_of(scene, known, defect);
    return mcv_ground_find(&ground, NULL, place, error);
}

mcv_result mcv_defect_apply_known(mcv_scene *scene, mcv_known_meshes *known,
                                  const mcv_defect *defect, const mcv_json_path *place,
                                  mcv_error *error) {
    if (mcv_defect_is_inside(defect->type)) return mcv_defect_embed(scene, defect, error);
    mcv_ground ground = mcv_ground_of(scene, known, defect);
    mcv_facets facets = {NULL, 0, 0};
    mcv_marks found = {NULL, 0, 0}, marks = {NULL, 0, 0};
    mcv_result result = mcv_ground_find(&ground, &found, place, error);
    if (result == MCV_OK) result = refine(&ground, &found, &marks, &facets, place, error);
    if (result == MCV_OK) result = change(&ground, &facets, place, error);
    if (result == MCV_OK) result = replace_all(scene, known, defect, &facets, &marks, place, error);
    free(found.items);
    free(marks.items);
    free(facets.items);
    return result;
}

mcv_result mcv_defect_apply(mcv_scene *scene, const mcv_defect *defect, const mcv_json_path *place,
                            mcv_error *error) {
    mcv_known_meshes known = {0};
    mcv_result result = mcv_defect_apply_known(scene, &known, defect, place, error);
    if (result == MCV_OK) result = mcv_defects_finish(scene, &known, place, error);
    mcv_known_meshes_free(&known);
    return result;
}
