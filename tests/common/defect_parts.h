/* SPDX-License-Identifier: Apache-2.0 */
/* Closed parts that get defects, and what is measured of them. Include it first. */
#ifndef MCVISI_TESTS_COMMON_DEFECT_PARTS_H
#define MCVISI_TESTS_COMMON_DEFECT_PARTS_H

#include "scene_builder.h"

#include "defects/defects.h"
#include "mesh.h"
#include "scene/geometry.h"
#include "scene/mesh.h"

/* --- parts --- */

/* A cube of edge 1 about the origin, 4 vertices with their own normals on each side; `cells` x
 * `cells` squares each, so that 1 has triangles far larger than a defect. */
static inline mesh make_cube(uint32_t cells, float *normals) {
    const uint32_t side = (cells + 1) * (cells + 1);
    mesh m = mesh_new(6 * side, 12 * cells * cells);
    float *p = m.positions, *n = normals;
    for (uint32_t face = 0; face < 6; ++face) {
        const int axis = (int)(face / 2), sign = face % 2 ? 1 : -1;
        for (uint32_t j = 0; j <= cells; ++j)
            for (uint32_t i = 0; i <= cells; ++i, p += 3, n += 3) {
                const uint32_t a = sign > 0 ? i : cells - i;
                p[axis] = 0.5f * (float)sign;
                p[(axis + 1) % 3] = (float)a / (float)cells - 0.5f;
                p[(axis + 2) % 3] = (float)j / (float)cells - 0.5f;
                for (int k = 0; k < 3; ++k) n[k] = k == axis ? (float)sign : 0;
            }
        mesh_grid(m.indices + 6 * (size_t)face * cells * cells, face * side, cells);
    }
    return m;
}

typedef enum part { CUBE, FLAT_CUBE, BALL, PART_COUNT } part;

/* A scene of one part, named "part", in this frame. The ball has a radius of 1. */
static inline mcv_scene *scene_of(part which, const mcv_transform *to_world) {
    mcv_scene *scene = mcv_scene_new("(test)");
    float *normals = malloc(sizeof(float) * 3 * 6 * 65 * 65);
    assert_non_null(normals);
    mesh m = which == BALL ? mesh_sphere(64, 0) : make_cube(which == CUBE ? 3 : 1, normals);
    const mcv_mesh own = {.vertex_count = m.vertex_count,
                          .triangle_count = m.triangle_count,
                          .positions = m.positions,
                          .normals = which == FLAT_CUBE ? NULL
                                     : which == BALL    ? m.positions
                                                        : normals,
                          .indices = m.indices};
    add_instance(scene, &own, add_diffuse(scene, 0.5), *to_world);
    BUILD(mcv_scene_add_frame(scene, "part", false, to_world, &builder_error));
    scene->frames[0].instances[1] = scene->instance_count;
    mesh_free(&m);
    free(normals);
    return scene;
}

/* --- what is measured --- */

typedef struct directed {
    double ends[6];
} directed;

static inline int compare_directed(const void *a, const void *b) {
    const directed *p = a, *q = b;
    for (int i = 0; i < 6; ++i)
        if (p->ends[i] != q->ends[i]) return p->ends[i] < q->ends[i] ? -1 : 1;
    return 0;
}

/* Each edge, by the positions of its ends, must be run through once in either direction. */
static inline void expect_closed(const mcv_scene *scene, const char *what) {
    directed *edges = malloc(3 * sizeof *edges * scene->triangle_count);
    size_t count = 0;
    assert_non_null(edges);
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        for (uint32_t t = 0; t < scene->meshes[scene->instances[i].mesh].triangle_count; ++t) {
            double c[3][3];
            mcv_scene_corners(scene, i, t, c);
            for (int k = 0; k < 3; ++k, ++count) {
                memcpy(edges[count].ends, c[k], sizeof c[k]);
                memcpy(edges[count].ends + 3, c[(k + 1) % 3], sizeof c[k]);
            }
        }
    assert_int_equal(count, 3 * scene->triangle_count);
    qsort(edges, count, sizeof *edges, compare_directed);
    for (size_t i = 0; i < count; ++i) {
        directed back;
        memcpy(back.ends, edges[i].ends + 3, 3 * sizeof(double));
        memcpy(back.ends + 3, edges[i].ends, 3 * sizeof(double));
        if (i > 0 && compare_directed(edges + i - 1, edges + i) == 0)
            fail_msg("%s: an edge occurs twice in one direction", what);
        if (!bsearch(&back, edges, count, sizeof *edges, compare_directed))
            fail_msg("%s: an edge at (%g, %g, %g) is open", what, back.ends[0], back.ends[1],
                     back.ends[2]);
    }
    free(edges);
}

static inline double volume_of(const mcv_scene *scene) {
    double sum = 0;
    for (uint32_t i = 0; i < scene->instance_count; ++i)
        for (uint32_t t = 0; t < scene->meshes[scene->instances[i].mesh].triangle_count; ++t) {
            double c[3][3], cross[3];
            mcv_scene_corners(scene, i, t, c);
            mcv_cross3(c[0], c[1], cross);
            sum += cross[0] * c[2][0] + cross[1] * c[2][1] + cross[2] * c[2][2];
        }
    return sum / 6;
}

/* --- what is done --- */

/* By mirror images, turns and scales; the scene's metres are those of the defect. */
static inline mcv_transform frame_of(int which) {
    const double unit[3] = {1, 1, 1}, mirrored[3] = {1, -1, 1}, shift[3] = {0.3, -2, 1};
    const double turned[4] = {0.5, -0.1, 0.7, 0.5}, none[4] = {0, 0, 0, 1};
    double q[4];
    for (int i = 0; i < 4; ++i) q[i] = turned[i]; /* of length 1 */
    return mcv_transform_from_trs(which ? shift : (const double[3]){0, 0, 0}, which ? q : none,
                                  which == 2 ? mirrored : unit);
}

static inline void apply(mcv_scene *scene, const mcv_defect_site *site, mcv_defect *d) {
    const mcv_json_path place = mcv_place_file("(test)");
    mcv_error error;
    if (mcv_defect_locate(scene, site, d, &place, &error) != MCV_OK) fail_msg("%s", error.text);
    if (mcv_defect_apply(scene, d, &place, &error) != MCV_OK) fail_msg("%s", error.text);
}

#endif
