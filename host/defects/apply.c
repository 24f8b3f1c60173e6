/* SPDX-License-Identifier: Apache-2.0 */
/* Defects in meshes: refines around them and moves vertices and normals (mcvisi/defects.h). */
#include "defects/facets.h"

#include "scene/geometry.h"
#include "scene/transform.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* As many as one defect may take. */
enum { MOST_FACETS = 4000000 };

/* --- corners --- */

/* A vector of the world in the instance's frame: by the inverse of its matrix m. */
static void to_frame(const double m[9], const double vector[3], double local[3]) {
    double cofactors[3][3];
    mcv_cross3(m + 3, m + 6, cofactors[0]);
    mcv_cross3(m + 6, m, cofactors[1]);
    mcv_cross3(m, m + 3, cofactors[2]);
    const double determinant =
        m[0] * cofactors[0][0] + m[1] * cofactors[0][1] + m[2] * cofactors[0][2];
    for (int i = 0; i < 3; ++i)
        local[i] = (cofactors[0][i] * vector[0] + cofactors[1][i] * vector[1] +
                    cofactors[2][i] * vector[2]) /
                   determinant;
}

/* n - grad h (n . n0), from the frame to the world and back: normals go back by the transposed
 * matrix. */
static void tilt_normal(const mcv_ground *ground, const mcv_transform *t, const double gradient[3],
                        float normal[3]) {
    const double *up = ground->defect->axes[2];
    double world[3], local[3];
    mcv_transform_normal(t, (const double[3]){normal[0], normal[1], normal[2]}, world);
    const double share = world[0] * up[0] + world[1] * up[1] + world[2] * up[2];
    for (int i = 0; i < 3; ++i) world[i] -= share * gradient[i];
    for (int i = 0; i < 3; ++i)
        local[i] = t->m[i] * world[0] + t->m[3 + i] * world[1] + t->m[6 + i] * world[2];
    if (!mcv_normalize3(local, local)) return;
    for (int i = 0; i < 3; ++i) normal[i] = (float)local[i];
}

/* t + n0 (grad h . t) */
static void tilt_tangent(const mcv_ground *ground, const mcv_transform *t, const double gradient[3],
                         float tangent[3]) {
    double world[3], local[3];
    mcv_transform_vector(t, (const double[3]){tangent[0], tangent[1], tangent[2]}, world);
    const double rise = world[0] * gradient[0] + world[1] * gradient[1] + world[2] * gradient[2];
    for (int i = 0; i < 3; ++i) world[i] += rise * ground->defect->axes[2][i];
    to_frame(t->m, world, local);
    if (!mcv_normalize3(local, local)) return;
    for (int i = 0; i < 3; ++i) tangent[i] = (float)local[i];
}

static void move_corner(const mcv_ground *ground, uint32_t instance, mcv_corner *corner) {
    const mcv_transform *t = &ground->scene->instances[instance].to_world;
    const mcv_defect *d = ground->defect;
    double at[3], slope[2], gradient[3], up[3], local[3];
    mcv_ground_point(ground, instance, corner->position, at);
    const double h = mcv_defect_height(d, at[0], at[1], slope);
    if (h == 0 && slope[0] == 0 && slope[1] == 0) return;
    for (int i = 0; i < 3; ++i) {
        gradient[i] = slope[0] * d->axes[0][i] + slope[1] * d->axes[1][i];
        up[i] = h * d->axes[2][i];
    }
    to_frame(t->m, up, local);
    for (int i = 0; i < 3; ++i)
        corner->position[i] = (float)((double)corner->position[i] + local[i]);
    tilt_normal(ground, t, gradient, corner->normal);
    tilt_tangent(ground, t, gradient, corner->tangent);
}

/* --- the meshes --- */

/* Refines what must be: what `marks` says, and what lies beside, which is marked then, too. */
static mcv_result refine(const mcv_ground *ground, uint8_t *const *marks, mcv_facets *facets,
                         const mcv_json_path *place, mcv_error *error) {
    const mcv_scene *scene = ground->scene;
    const uint32_t first = ground->defect->instances[0];
    for (uint32_t i = first; i < ground->defect->instances[1]; ++i) {
        const uint32_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
        for (uint32_t t = 0; t < count; ++t) {
            mcv_facet facet = mcv_facet_take(scene, i, t);
            uint8_t *marked = &marks[i - first][t];
            facet.inside = *marked;
            for (int k = 0; k < 3 && !*marked; ++k)
                *marked =
                    mcv_ground_splits(ground, i, &facet.corners[k], &facet.corners[(k + 1) % 3]);
            if (*marked)
                MCV_TRY(mcv_facets_refine(facets, ground, &facet, MOST_FACETS, place, error));
        }
    }
    for (size_t f = 0; f < facets->count; ++f)
        for (int k = 0; k < 3 && facets->items[f].inside; ++k)
            move_corner(ground, facets->items[f].instance, &facets->items[f].corners[k]);
    return MCV_OK;
}

static mcv_result replace_all(mcv_scene *scene, const mcv_defect *defect, const mcv_facets *facets,
                              uint8_t *const *marks, const mcv_json_path *place, mcv_error *error) {
    for (uint32_t i = defect->instances[0]; i < defect->instances[1]; ++i) {
        const uint8_t *marked = marks[i - defect->instances[0]];
        const uint32_t count = scene->meshes[scene->instances[i].mesh].triangle_count;
        if (!memchr(marked, 1, count)) continue;
        if (scene->instances[i].emitter != MCV_NONE)
            return mcv_fail_at(place, error,
                               "node \"%s\" emits light: defects are for surfaces that do not",
                               scene->instances[i].name);
        MCV_TRY(mcv_facets_replace(facets, scene, i, marked, place, error));
    }
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        scene->instances[i].first_triangle = (uint32_t)triangles;
        triangles += scene->meshes[scene->instances[i].mesh].triangle_count;
        if (triangles > INT32_MAX)
            return mcv_fail_at(place, error, "with it the scene has more than %d triangles",
                               INT32_MAX);
    }
    scene->triangle_count = (uint32_t)triangles;
    return MCV_OK;
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
    free(marks[0]);
    free((void *)marks);
}

mcv_result mcv_defect_fits(const mcv_scene *scene, const mcv_defect *defect,
                           const mcv_json_path *place, mcv_error *error) {
    mcv_ground ground = {
        .scene = scene, .defect = defect, .footprint = mcv_defect_footprint(defect)};
    uint8_t **marks = new_marks(scene, defect->instances);
    if (!marks) return mcv_fail_memory(place, error);
    const mcv_result result = mcv_ground_find(&ground, marks, place, error);
    free_marks(marks);
    return result;
}

mcv_result mcv_defect_apply(mcv_scene *scene, const mcv_defect *defect, const mcv_json_path *place,
                            mcv_error *error) {
    if (mcv_defect_is_inside(defect->type)) return mcv_defect_embed(scene, defect, error);
    mcv_ground ground = {
        .scene = scene, .defect = defect, .footprint = mcv_defect_footprint(defect)};
    mcv_facets facets = {NULL, 0, 0};
    uint8_t **marks = new_marks(scene, defect->instances);
    if (!marks) return mcv_fail_memory(place, error);
    mcv_result result = mcv_ground_find(&ground, marks, place, error);
    if (result == MCV_OK) result = refine(&ground, marks, &facets, place, error);
    if (result == MCV_OK) result = replace_all(scene, defect, &facets, marks, place, error);
    free_marks(marks);
    free(facets.items);
    return result;
}
