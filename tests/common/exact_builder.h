/* SPDX-License-Identifier: Apache-2.0 */
/* For tests: scenes of exact surfaces, and single rays through them by the device and by the
 * reference renderer. */
#ifndef MCVISI_TESTS_EXACT_BUILDER_H
#define MCVISI_TESTS_EXACT_BUILDER_H

#include "scene_builder.h"
#include "truths.h"

#include "mcvisi/surfaces/solid.h"
#include "reference/reference.h"
#include "render/render.h"
#include "scene/params.h"
#include "scene/solid.h"

static const mcv_transform unmoved = {{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}};

static inline mcv_scene *new_scene(void) {
    mcv_scene *scene = mcv_scene_new("test");
    assert_non_null(scene);
    return scene;
}

static inline void add_solid(mcv_scene *scene, const mcv_solid *solid, uint32_t body,
                             uint32_t rim) {
    BUILD(mcv_scene_add_solid(scene, solid, "lens", body, rim, &builder_error));
}

static inline mcv_solid element(double radius, mcv_cap first, mcv_cap second) {
    return (mcv_solid){
        .side = MCV_SIDE_CYLINDER, .radius = radius, .caps = {first, second}, .to_world = unmoved};
}

static inline mcv_solid sphere(double radius) {
    return (mcv_solid){.side = MCV_SIDE_SPHERE, .radius = radius, .to_world = unmoved};
}

/* The device in single precision, the reference renderer, the device in mixed precision; the first
 * two count as false and true. */
enum { BY_DEVICE, BY_REFERENCE, BY_MIXED, RAY_TRACERS };

enum { DEPTH = 40 };
typedef struct traced {
    mcv_vertex *vertices;
    size_t count;
} traced;

static inline traced follow_deep(const mcv_scene *scene, int by, uint32_t depth,
                                 const mcv_trace_ray *rays, size_t n) {
    mcv_render_options options = mcv_render_defaults();
    traced t;
    options.depth = depth;
    if (by == BY_MIXED) options.precision = MCV_PRECISION_MIXED;
    if (by == BY_REFERENCE)
        BUILD(mcv_reference_trace(scene, rays, n, &options, &t.vertices, &t.count, &builder_error));
    else
        BUILD(mcv_trace(scene, rays, n, &options, &t.vertices, &t.count, &builder_error));
    return t;
}

static inline traced follow(const mcv_scene *scene, int by, const mcv_trace_ray *rays, size_t n) {
    return follow_deep(scene, by, DEPTH, rays, n);
}

/* Of one ray: its vertices; the last one before it is gone is out[returned - 1]. */
static inline size_t trace_one(const mcv_scene *scene, int by, mcv_trace_ray ray,
                               mcv_vertex out[DEPTH + 1]) {
    const traced t = follow(scene, by, &ray, 1);
    size_t n = 0;
    memset(out, 0, (DEPTH + 1) * sizeof *out);
    for (size_t i = 0; i < t.count; ++i)
        if (t.vertices[i].event != MCV_EVENT_MISS) out[n++] = t.vertices[i];
    free(t.vertices);
    return n;
}

/* Where the ray that leaves a vertex in the xz plane crosses the axis. */
static inline double crossing(const mcv_vertex *v) {
    return v->position[2] - v->position[0] * v->direction[2] / v->direction[0];
}

static inline const char *name_of(int by) {
    return by == BY_MIXED ? "mixed" : by == BY_REFERENCE ? "reference" : "device";
}

static inline void expect_near(const char *what, int by, double got, double expected,
                               double tolerance) {
    note_truth(what, name_of(by), fabs(got - expected), tolerance);
    if (!(fabs(got - expected) <= tolerance))
        fail_msg("%s, %s: %.12g, not %.12g: off by %.3g, allowed are %.3g", what, name_of(by), got,
                 expected, got - expected, tolerance);
}

static inline mcv_trace_ray along_z(double x, double y, double z) {
    return (mcv_trace_ray){{x, y, z}, {0, 0, 1}};
}

static inline double uniform(uint64_t *state) {
    *state = *state * 6364136223846793005ull + 1442695040888963407ull;
    return (double)(*state >> 11) * 0x1p-53;
}

/* A slab of a turned and moved frame, n x n squares in each face, from z = low to high. */
static inline void add_slab(mcv_scene *scene, int n, double low, double high, uint32_t material) {
    enum { MOST = 8 };
    float positions[2 * (MOST + 1) * (MOST + 1) * 3];
    uint32_t indices[6 * (2 * MOST * MOST + 4 * MOST)], count = 0;
    const uint32_t row = (uint32_t)n + 1, face = row * row;
    for (uint32_t v = 0; v < 2 * face; ++v) {
        positions[3 * v] = (float)(0.02 * (v % row) / n - 0.01);
        positions[3 * v + 1] = (float)(0.02 * (v / row % row) / n - 0.01);
        positions[3 * v + 2] = (float)(v < face ? low : high);
    }
#define QUAD(a, b, c, d) \
    memcpy(indices + count, (uint32_t[6]){(a), (b), (c), (a), (c), (d)}, 6 * sizeof *indices), \
        count += 6
    for (uint32_t y = 0; y + 1 < row; ++y)
        for (uint32_t x = 0; x + 1 < row; ++x) {
            const uint32_t a = y * row + x, t = a + face;
            QUAD(a, a + row, a + row + 1, a + 1);
            QUAD(t, t + 1, t + row + 1, t + row);
        }
    for (uint32_t k = 0; k + 1 < row; ++k) {
        const uint32_t front = k, back = face - row + k, left = k * row, right = k * row + row - 1;
        QUAD(front, front + 1, front + 1 + face, front + face);
        QUAD(back + 1, back, back + face, back + 1 + face);
        QUAD(left + row, left, left + face, left + row + face);
        QUAD(right, right + row, right + row + face, right + face);
    }
#undef QUAD
    const double c = 0.8, s = 0.6;
    const mcv_transform turned = {{c, 0, s, 0, 1, 0, -s, 0, c, 0.1, -0.05, 0.02}};
    add_instance(scene,
                 &(mcv_mesh){.vertex_count = 2 * face,
                             .triangle_count = count / 3,
                             .positions = positions,
                             .indices = indices},
                 material, turned);
}

#endif
