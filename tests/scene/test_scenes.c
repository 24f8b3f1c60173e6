/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The shipped scenes are what their descriptions say: closed lenses of the right volume and
 * normals, the panel and the camera where the report's experiment has them, the CAD part in the
 * frame of its camera.
 */
#include "test.h"

#include <stdio.h>
#include <stdlib.h>

#include "scene/scene.h"
#include "loader/load.h"

#define PI 3.14159265358979323846

static const double radius = 0.310;
static const double thickness = 0.006;
static const double semi_diameter = 0.014;
static const double centre = -0.301022;
static const double dent_depth = 2.5e-6;
static const double dent_sigma = 0.5e-3;

static mcv_scene *load(const char *name) {
    char path[512];
    mcv_error error = {""};
    mcv_scene *scene;
    snprintf(path, sizeof path, "%s/scenes/%s", MCV_SOURCE_DIR, name);
    if (mcv_scene_load(path, (mcv_overrides){NULL, 0}, &scene, &error) != MCV_OK)
        fail_msg("%s", error.text);
    return scene;
}

static uint32_t instance_named(const mcv_scene *scene, const char *name) {
    for (uint32_t i = 0; i < scene->instance_count; ++i) {
        if (strcmp(scene->instances[i].name, name) == 0) return i;
    }
    fail_msg("%s: no instance '%s'", scene->path, name);
    return MCV_NONE;
}

static const mcv_mesh *mesh_of(const mcv_scene *scene, uint32_t instance) {
    return &scene->meshes[scene->instances[instance].mesh];
}

/* A directed edge by its ends' positions. */
typedef struct edge {
    double ends[2][3];
} edge;

static int compare_edges(const void *a, const void *b) {
    const double *p = &((const edge *)a)->ends[0][0];
    const double *q = &((const edge *)b)->ends[0][0];
    for (int i = 0; i < 6; ++i) {
        if (p[i] != q[i]) return p[i] < q[i] ? -1 : 1;
    }
    return 0;
}

/* The enclosed volume; fails if an edge does not run exactly once in each direction. */
static double closed_volume(const mcv_scene *scene, uint32_t instance) {
    const uint32_t triangles = mesh_of(scene, instance)->triangle_count;
    const size_t edge_count = 3 * (size_t)triangles;
    edge *edges = malloc(edge_count * sizeof *edges);
    double volume = 0;
    assert_non_null(edges);
    for (uint32_t t = 0; t < triangles; ++t) {
        double p[3][3];
        mcv_scene_corners(scene, instance, t, p);
        for (int i = 0; i < 3; ++i) {
            memcpy(edges[3 * t + (uint32_t)i].ends[0], p[i], sizeof p[i]);
            memcpy(edges[3 * t + (uint32_t)i].ends[1], p[(i + 1) % 3], sizeof p[i]);
        }
        for (int i = 0; i < 3; ++i) p[i][2] -= centre; /* near the origin nothing cancels */
        volume += (p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
                   p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
                   p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0])) /
                  6;
    }
    qsort(edges, edge_count, sizeof *edges, compare_edges);
    for (size_t i = 0; i < edge_count; ++i) {
        edge opposite = {{{0}}};
        memcpy(opposite.ends[0], edges[i].ends[1], sizeof opposite.ends[0]);
        memcpy(opposite.ends[1], edges[i].ends[0], sizeof opposite.ends[1]);
        if (i && compare_edges(&edges[i - 1], &edges[i]) == 0)
            fail_msg("%s: an edge runs twice in the same direction", scene->path);
        if (!bsearch(&opposite, edges, edge_count, sizeof *edges, compare_edges))
            fail_msg("%s: the edge from (%g, %g, %g) is open", scene->path, edges[i].ends[0][0],
                     edges[i].ends[0][1], edges[i].ends[0][2]);
    }
    free(edges);
    return volume;
}

/* The larger difference of two unit vectors' components, kept over the calls. */
static void widen(double *worst, const double a[3], const double b[3]) {
    for (int i = 0; i < 3; ++i) *worst = fmax(*worst, fabs(a[i] - b[i]));
}

/*
 * Vertices lie on the surfaces and carry their normals. A position is rounded to float32 in the
 * lens's frame: each coordinate is at most 0.014 there, so it is off by at most 2^-31 (half an ulp
 * below 2^-6), and so is the surface's height computed from it (slopes are below 0.05); adding
 * `centre` in double adds nothing that counts: 2^-30. A normal's components are off by half an ulp
 * below 1, 2^-25, before the loader makes it unit again, and by the position's error times the
 * curvature (10/m on the dent): 2^-27; in all, with the length's share, below 2^-23.
 */
static void check_lens(const mcv_scene *scene, bool dented) {
    const uint32_t lens = instance_named(scene, "lens");
    double worst_position = 0;
    double worst_normal = 0;
    uint32_t faces[3] = {0, 0, 0};
    for (uint32_t t = 0; t < mesh_of(scene, lens)->triangle_count; ++t) {
        double p[3][3];
        double n[3][3];
        mcv_scene_corners(scene, lens, t, p);
        mcv_scene_vertex_normals(scene, lens, t, n);
        for (int i = 0; i < 3; ++i) {
            const double x = p[i][0];
            const double y = p[i][1];
            const double z = p[i][2] - centre;
            const double r = hypot(x, y);
            double expected[3] = {x / semi_diameter, y / semi_diameter, 0};
            double off = r - semi_diameter;
            const int face = n[i][2] > 0.5 ? 0 : n[i][2] < -0.5 ? 1 : 2;
            ++faces[face];
            if (face < 2) {
                const double side = face == 0 ? 1 : -1;
                const double gauss =
                    face == 0 && dented ? dent_depth * exp(-0.5 * r * r / (dent_sigma * dent_sigma))
                                        : 0;
                const double root = sqrt(radius * radius - r * r);
                const double slope_over_r =
                    -1 / root +
                    gauss / (dent_sigma * dent_sigma); /* of the height, by x: slope_over_r x */
                const double length = sqrt(1 + slope_over_r * slope_over_r * r * r);
                off = side * z - (thickness / 2 - radius + root - gauss);
                expected[0] = -slope_over_r * x / length;
                expected[1] = -slope_over_r * y / length;
                expected[2] = side / length;
            }
            worst_position = fmax(worst_position, fabs(off));
            widen(&worst_normal, n[i], expected);
        }
    }
    assert_true(faces[0] && faces[1] && faces[2]);
    if (worst_position > 0x1p-30)
        fail_msg("%s: a vertex lies %g m off the lens", scene->path, worst_position);
    if (worst_normal > 0x1p-23) fail_msg("%s: a normal is off by %g", scene->path, worst_normal);
}

/* The mount is closed against the lens: each of its inner corners is a corner of the lens, bit for
 * bit. */
static void check_mount(const mcv_scene *scene) {
    const uint32_t lens = instance_named(scene, "lens");
    const uint32_t mount = instance_named(scene, "mount");
    double worst = 0;
    uint32_t inner = 0;
    assert_int_equal(scene->materials[scene->instances[mount].material].type,
                     MCV_MATERIAL_ABSORBER);
    for (uint32_t t = 0; t < mesh_of(scene, mount)->triangle_count; ++t) {
        double p[3][3];
        mcv_scene_corners(scene, mount, t, p);
        for (int i = 0; i < 3; ++i) {
            if (hypot(p[i][0], p[i][1]) > 0.02) continue;
            double nearest = HUGE_VAL;
            const mcv_mesh *mesh = mesh_of(scene, lens);
            for (uint32_t k = 0; k < mesh->vertex_count; ++k) {
                const float *v = mesh->positions + 3 * (size_t)k;
                nearest =
                    fmin(nearest, fmax(fabs(v[0] - p[i][0]),
                                       fmax(fabs(v[1] - p[i][1]), fabs(v[2] + centre - p[i][2]))));
            }
            worst = fmax(worst, nearest);
            ++inner;
        }
    }
    assert_true(inner > 0);
    if (worst != 0) fail_msg("%s: the mount is %g m away from the lens", scene->path, worst);
}

static void check_panel_and_camera(const mcv_scene *scene) {
    assert_int_equal(scene->sensor_count, 1);
    assert_int_equal(scene->sensors[0].type, MCV_SENSOR_LIGHT_FIELD);
    const mcv_light_field_params *camera = &scene->sensors[0].as.light_field;
    /* A decimal with its unit is read with an error of an ulp or two. */
    assert_true(fabs(camera->focalLength - 0.05) < 1e-16 &&
                fabs(camera->imageDistance - 0.06) < 1e-16);
    assert_true(fabs(camera->lensDiameter - 0.02) < 1e-16 &&
                fabs(camera->pixelSize[0] - 4e-6) < 1e-20);
    const mcv_transform identity = mcv_transform_identity();
    for (int i = 0; i < 12; ++i) assert_true(scene->sensors[0].to_world.m[i] == identity.m[i]);

    assert_int_equal(scene->emitter_count, 1);
    const mcv_emitter *panel = &scene->emitters[0];
    assert_int_equal(panel->type, MCV_EMITTER_PARALLEL);
    assert_true(fabs(panel->as.parallel.halfAngle - PI / 360) < 1e-17 && panel->radiance[0] == 1);
    /* Corners are stored as float32 (0.03 m: 2^-30 off), the area is that off twice, relative to
     * the side. */
    if (fabs(panel->area - 0.0036) > 2 * 0.06 * 0x1p-29)
        fail_msg("%s: the panel's area is %.17g", scene->path, panel->area);
    for (uint32_t t = 0; t < 2; ++t) {
        double p[3][3];
        double n[3][3];
        mcv_scene_corners(scene, panel->instance, t, p);
        mcv_scene_vertex_normals(scene, panel->instance, t, n);
        for (int i = 0; i < 3; ++i) {
            assert_true(fabs(p[i][2] + 0.384022) < 1e-16);
            if (n[i][2] < 1 - 1e-15)
                fail_msg("%s: the panel faces (%g, %g, %g)", scene->path, n[i][0], n[i][1],
                         n[i][2]);
        }
    }
}

static void test_report(void **state) {
    (void)state;
    static const char *const names[] = {"report-clean.glb", "report-bubble.glb", "report-dent.glb"};
    /*
     * A lens of two caps and a cylinder. The mesh is inscribed: its section is a 288-gon, smaller
     * than the circle by 1 - sin(a)/a, a = 2π/288; facets of edge at most 0.31 mm lie at most
     * h²/(6R) below each cap. The dent takes 2π σ² A.
     */
    const double cap = semi_diameter * semi_diameter /
                       (radius + sqrt(radius * radius - semi_diameter * semi_diameter));
    const double whole = PI * semi_diameter * semi_diameter * (thickness - 2 * cap) +
                         2 * PI * cap * cap * (3 * radius - cap) / 3;
    const double angle = 2 * PI / 288;
    const double below = whole * (1 - sin(angle) / angle) +
                         2 * PI * semi_diameter * semi_diameter * 0.31e-3 * 0.31e-3 / (6 * radius);
    for (int i = 0; i < 3; ++i) {
        mcv_scene *scene = load(names[i]);
        const bool dented = i == 2;
        const double exact = whole - (dented ? 2 * PI * dent_sigma * dent_sigma * dent_depth : 0);
        const double volume = closed_volume(scene, instance_named(scene, "lens"));
        if (volume > exact || volume < exact - below)
            fail_msg("%s: the lens's volume is %.9g, not in [%.9g, %.9g]", names[i], volume,
                     exact - below, exact);
        check_lens(scene, dented);
        check_mount(scene);
        check_panel_and_camera(scene);
        if (i == 1) {
            /* A ball of 0.5 mm, edges at most 21 µm: facets at most h²/(6R) below, on its surface.
             */
            const double ball = 4 * PI / 3 * 0.5e-3 * 0.5e-3 * 0.5e-3;
            const double bubble = closed_volume(scene, instance_named(scene, "bubble"));
            if (bubble > ball ||
                bubble < ball - 4 * PI * 0.5e-3 * 0.5e-3 * 21e-6 * 21e-6 / (6 * 0.5e-3))
                fail_msg("the bubble's volume is %.9g, not just below %.9g", bubble, ball);
        }
        mcv_scene_free(scene);
    }
}

/* The whole part lies in the camera's field, fills it to at least 85 % in one direction, and in
 * depth stays clear of camera and lights. */
static void test_part(void **state) {
    (void)state;
    static const char *const names[] = {"part-backlight.gltf", "part-arealight.gltf"};
    for (int i = 0; i < 2; ++i) {
        mcv_scene *scene = load(names[i]);
        assert_int_equal(scene->sensor_count, 1);
        const mcv_sensor *camera = &scene->sensors[0];
        const double *m = camera->to_world.m;
        assert_int_equal(camera->type, MCV_SENSOR_TELECENTRIC);
        double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
        double high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
        for (uint32_t k = 0; k < scene->instance_count; ++k) {
            if (scene->instances[k].emitter != MCV_NONE) continue;
            for (uint32_t t = 0; t < mesh_of(scene, k)->triangle_count; ++t) {
                double p[3][3];
                mcv_scene_corners(scene, k, t, p);
                for (int axis = 0; axis < 9; ++axis) {
                    const double *q = p[axis / 3];
                    const int a = axis % 3;
                    const double v = m[a] * (q[0] - m[9]) + m[3 + a] * (q[1] - m[10]) +
                                     m[6 + a] * (q[2] - m[11]);
                    low[a] = fmin(low[a], v);
                    high[a] = fmax(high[a], v);
                }
            }
        }
        for (int a = 0; a < 2; ++a) {
            const double half = 0.5 * camera->as.telecentric.resolution[a] *
                                camera->as.telecentric.pixelSize[a] /
                                camera->as.telecentric.magnification;
            if (low[a] < -half || high[a] > half)
                fail_msg("%s: the part spans [%g, %g] m, the field only ±%g m", names[i], low[a],
                         high[a], half);
            if (a == 0 && high[a] - low[a] < 0.85 * 2 * half)
                fail_msg("%s: the part is %g m wide in a field of %g m", names[i], high[a] - low[a],
                         2 * half);
        }
        if (high[2] > -0.1 || low[2] < -0.2)
            fail_msg("%s: the part lies at depths %g to %g m", names[i], -high[2], -low[2]);
        mcv_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_report), cmocka_unit_test(test_part)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
