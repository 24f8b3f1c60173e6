/* SPDX-License-Identifier: Apache-2.0 */
/* Defects on exact surfaces: the body becomes a closed mesh that lies on its surfaces, and the
 * defect does to it what it does to meshes. */
#include "test.h"

#include <math.h>

#include "defect_parts.h"
#include "mcvisi/surfaces/solid.h"
#include "reference/media.h"
#include "reference/vector.h"
#include "scene/solid.h"

/* The bodies: their exact volumes, and where a defect goes on their top. */
typedef struct body {
    const char *name;
    mcv_solid solid;
    double volume, top[3];
} body;

static const double radius = 3e-3;

/* Of the ball of radius R that a plane cuts off at the height h. */
static double cap_volume(double R, double h) { return M_PI * h * h * (R - h / 3); }

static double sag(double R, double r) { return R - sqrt(R * R - r * r); }

static void fill_bodies(body bodies[4]) {
    const double r = radius, R = 20e-3, half[2] = {4e-3, 3e-3};
    bodies[0] = (body){.name = "box",
                       .solid = {.side = MCV_SIDE_BOX,
                                 .half = {half[0], half[1]},
                                 .caps = {{.z = -1e-3}, {.z = 1e-3}}},
                       .volume = 4 * half[0] * half[1] * 2e-3,
                       .top = {0, 0, 1e-3}};
    bodies[1] = (body){
        .name = "cylinder",
        .solid = {.side = MCV_SIDE_CYLINDER, .radius = r, .caps = {{.z = -1e-3}, {.z = 1e-3}}},
        .volume = M_PI * r * r * 2e-3,
        .top = {0, 0, 1e-3}};
    bodies[2] = (body){.name = "ball",
                       .solid = {.side = MCV_SIDE_SPHERE, .radius = r},
                       .volume = 4 * M_PI / 3 * r * r * r,
                       .top = {0, 0, r}};
    bodies[3] = (body){
        .name = "lens", /* biconvex; its black rim is an instance of its own */
        .solid = {.side = MCV_SIDE_CYLINDER,
                  .radius = r,
                  .caps = {{.z = -1e-3, .curvature = 1 / R}, {.z = 1e-3, .curvature = -1 / R}}},
        .volume = M_PI * r * r * (2e-3 - 2 * sag(R, r)) + 2 * cap_volume(R, sag(R, r)),
        .top = {0, 0, 1e-3}};
    for (int i = 0; i < 4; ++i) bodies[i].solid.to_world = frame_of(1);
}

static mcv_scene *scene_with(const body *b) {
    mcv_scene *scene = mcv_scene_new("(test)");
    const uint32_t glass = add_glass(scene, 1.5, 0, 0), black = add_absorber(scene);
    const bool rimmed = strcmp(b->name, "lens") == 0;
    BUILD(mcv_scene_add_solid(scene, &b->solid, "part", glass, rimmed ? black : glass,
                              &builder_error));
    BUILD(mcv_scene_add_frame(scene, "part", false, &b->solid.to_world, &builder_error));
    scene->frames[0].instances[1] = scene->instance_count;
    return scene;
}

static void make_mesh(mcv_scene *scene) {
    const mcv_json_path place = mcv_place_file("(test)");
    mcv_error error;
    if (mcv_scene_mesh_solids(scene, scene->frames[0].instances, &place, &error) != MCV_OK)
        fail_msg("%s", error.text);
}

/* Chords lie at most 50 nm inside, so the volume errs by the area times that, and by the rounding
 * of float32 vertices: 2^-24 of 3 mm is 0.2 nm. */
static void bodies_become_closed_meshes(void **state) {
    body bodies[4];
    (void)state;
    fill_bodies(bodies);
    for (int i = 0; i < 4; ++i) {
        mcv_scene *scene = scene_with(bodies + i);
        const double area = 4 * M_PI * radius * radius; /* of the largest one, the ball */
        const uint64_t told = mcv_scene_solid_triangles(scene, scene->frames[0].instances);
        make_mesh(scene);
        /* Degenerate triangles are left out, as where a lens has no rim: these have one. */
        if (told != scene->triangle_count)
            fail_msg("%s: %llu triangles were told, there are %u", bodies[i].name,
                     (unsigned long long)told, scene->triangle_count);
        assert_int_equal(scene->solid_count, 0);
        expect_closed(scene, bodies[i].name);
        const double off = volume_of(scene) - bodies[i].volume;
        if (!(fabs(off) <= 51e-9 * area))
            fail_msg("%s: the volume errs by %g of %g m³", bodies[i].name, off, bodies[i].volume);
        mcv_scene_free(scene);
    }
}

/* Between vertices a normal of a ball is interpolated: that of a plane chord, whose direction is
 * that of the point itself. The rounding of float32 is left: 2^-24 of each of three coordinates of
 * positions and normals, 4e-7 in all. */
static void normals_are_those_of_the_surface(void **state) {
    body bodies[4];
    double most = 0;
    (void)state;
    fill_bodies(bodies);
    bodies[2].solid.to_world = mcv_transform_identity();
    mcv_scene *scene = scene_with(bodies + 2);
    make_mesh(scene);
    for (uint32_t t = 0; t < scene->triangle_count; t += 17) {
        double c[3][3], n[3][3], p[3], sum[3], cross[3];
        mcv_scene_corners(scene, 0, t, c);
        mcv_scene_vertex_normals(scene, 0, t, n);
        for (int k = 0; k < 3; ++k) {
            p[k] = (c[0][k] + c[1][k] + c[2][k]) / 3;
            sum[k] = n[0][k] + n[1][k] + n[2][k];
        }
        assert_true(mcv_normalize3(p, p) && mcv_normalize3(sum, sum));
        mcv_cross3(p, sum, cross);
        most = fmax(most, hypot(hypot(cross[0], cross[1]), cross[2]));
    }
    if (!(most < 4e-7)) fail_msg("normals of a ball err by %g rad", most);
    mcv_scene_free(scene);
}

/* A cosine dent takes away what its law says, whatever it lies on: its base is curved by 15 µm of
 * sag at most over its radius of 0.3 mm, and it moves along one normal, so the base does not count.
 * The mesh of the dent is good for 1 % of its volume (docs/elements/defects: 3 % of slopes). */
static void dents_take_their_volume(void **state) {
    body bodies[4];
    (void)state;
    fill_bodies(bodies);
    for (int i = 0; i < 4; ++i) {
        mcv_scene *scene = scene_with(bodies + i);
        make_mesh(scene);
        const double before = volume_of(scene), size = 0.6e-3, depth = 60e-6;
        mcv_defect d = {.name = "d",
                        .type = MCV_DEFECT_DENT,
                        .form = MCV_SHAPE_COSINE,
                        .size = size,
                        .depth = depth};
        mcv_defect_site site = {.node = "part", .by_point = true};
        memcpy(site.at, bodies[i].top, sizeof site.at);
        apply(scene, &site, &d);
        expect_closed(scene, bodies[i].name);
        const double taken = before - volume_of(scene),
                     right = (M_PI / 8 - 1 / (2 * M_PI)) * depth * size * size;
        if (!(fabs(taken - right) < 0.01 * right))
            fail_msg("%s: a dent takes %g m³ in place of %g", bodies[i].name, taken, right);
        mcv_scene_free(scene);
    }
}

/* A chip on the rim of a lens reaches the glass and its black edge. */
static void chips_bite_rims(void **state) {
    body bodies[4];
    (void)state;
    fill_bodies(bodies);
    mcv_scene *scene = scene_with(bodies + 3);
    const double r = radius;
    make_mesh(scene);
    const double before = volume_of(scene);
    mcv_defect d = {.name = "c", .type = MCV_DEFECT_CHIP, .size = 1e-3, .depth = 0.5e-3};
    apply(scene,
          &(mcv_defect_site){.node = "part", .by_point = true, .at = {r, 0, 1e-3 - sag(20e-3, r)}},
          &d);
    expect_closed(scene, "a chipped lens");
    assert_true(before - volume_of(scene) > 0.1 * M_PI / 6 * 1e-9);
    mcv_scene_free(scene);
}

/* The reference renderer asks which bodies are around a sensor: a ray out of a lens may leave by
 * the rim, which is not glass. */
static void rims_close_their_lenses(void **state) {
    body bodies[4];
    (void)state;
    fill_bodies(bodies);
    bodies[3].solid.to_world = mcv_transform_identity();
    mcv_scene *scene = scene_with(bodies + 3);
    make_mesh(scene);
    ref_geometry geometry;
    ref_media media;
    mcv_error error;
    int winding[8];
    assert_int_equal(ref_geometry_new(scene, &geometry, &error), MCV_OK);
    for (int i = 0; i < 200; ++i) {
        /* By the golden ratio: places over the lens and about it. */
        const double x = 14e-3 * (fmod(0.618034 * i, 1) - 0.5),
                     y = 14e-3 * (fmod(0.414214 * i, 1) - 0.5), z = 4e-3 * (i / 200.0 - 0.5),
                     point[3] = {x, y, z};
        const bool inside = mcv_solid_holds(&bodies[3].solid, point);
        assert_int_equal(ref_media_at(&geometry, (ref_vec){x, y, z}, winding, &media, &error),
                         MCV_OK);
        if ((media.count > 0) != inside)
            fail_msg("(%g, %g, %g) is %s the lens, not %s", x, y, z, inside ? "inside" : "outside",
                     inside ? "outside" : "inside");
    }
    ref_geometry_free(&geometry);
    mcv_scene_free(scene);
}

/* Faces of cemented lenses have the same vertices; of different radii they would not. */
static void cemented_lenses_need_one_radius(void **state) {
    const mcv_json_path place = mcv_place_file("(test)");
    mcv_error error;
    (void)state;
    for (int differ = 0; differ < 2; ++differ) {
        mcv_solid a = {.side = MCV_SIDE_CYLINDER,
                       .radius = radius,
                       .caps = {{.z = 0, .curvature = 50}, {.z = 3e-3, .curvature = -60}},
                       .to_world = mcv_transform_identity()},
                  b = {.side = MCV_SIDE_CYLINDER,
                       .radius = radius * (differ ? 1.1 : 1),
                       .caps = {{.z = 3e-3, .curvature = -60}, {.z = 5e-3, .curvature = -20}},
                       .cemented = true,
                       .to_world = mcv_transform_identity()};
        mcv_scene *scene = mcv_scene_new("(test)");
        const uint32_t crown = add_glass(scene, 1.5, 0, 0), flint = add_glass(scene, 1.7, 0, 0);
        BUILD(mcv_scene_add_solid(scene, &a, "part", crown, crown, &builder_error));
        BUILD(mcv_scene_add_solid(scene, &b, "part", flint, flint, &builder_error));
        const uint32_t all[2] = {0, scene->instance_count};
        const mcv_result result = mcv_scene_mesh_solids(scene, all, &place, &error);
        if (differ) {
            assert_int_equal(result, MCV_BAD_INPUT);
            assert_non_null(strstr(error.text, "semi-diameters"));
        } else {
            assert_int_equal(result, MCV_OK);
            assert_int_equal(scene->solid_count, 0);
        }
        mcv_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(bodies_become_closed_meshes),
                                       cmocka_unit_test(normals_are_those_of_the_surface),
                                       cmocka_unit_test(dents_take_their_volume),
                                       cmocka_unit_test(chips_bite_rims),
                                       cmocka_unit_test(rims_close_their_lenses),
                                       cmocka_unit_test(cemented_lenses_need_one_radius)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
