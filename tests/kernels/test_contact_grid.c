/* SPDX-License-Identifier: Apache-2.0 */
/* Where the grid says that surfaces of bodies come near each other. */
#include "scene_builder.h"

#include "device/pack.h"
#include "reference/random.h"

enum { POINTS = 20000 };

/* Glass boxes of half a metre: two that share a face, and one half a metre beside the second. */
static mcv_packed pack_boxes(void) {
    mcv_scene *scene = mcv_scene_new("boxes");
    const double half[3] = {0.25, 0.25, 0.25}, places[3] = {0, 0.5, 1.5};
    mcv_packed packed;
    for (int i = 0; i < 3; ++i) {
        mcv_transform to_world = mcv_transform_identity();
        to_world.m[9] = places[i];
        add_box(scene, half, add_glass(scene, 1.5, 0, i), to_world);
    }
    add_rectangle(scene, 1, 1, add_diffuse(scene, 0.5), looking_up_z(0, 0, -5));
    BUILD(mcv_pack(scene, NULL, &packed, &builder_error));
    mcv_scene_free(scene);
    return packed;
}

static uint32_t media_at(const mcv_contact_grid *grid, const float p[3]) {
    size_t cell = 0;
    for (int axis = 2; axis >= 0; --axis)
        cell = cell * MCV_CONTACT_CELLS +
               mcv_contact_cell(p[axis], grid->low[axis], grid->scale[axis]);
    return grid->media[cell];
}

/* A point uniform on the triangle. */
static void point_on(const mcv_packed *packed, uint32_t triangle, ref_random *random, float p[3]) {
    double u = ref_random_unit(random), v = ref_random_unit(random);
    const uint32_t *corners = packed->triangles + 4 * (size_t)triangle;
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    for (int axis = 0; axis < 3; ++axis)
        p[axis] = (float)((1 - u - v) * (double)packed->positions[3 * corners[0] + axis] +
                          u * (double)packed->positions[3 * corners[1] + axis] +
                          v * (double)packed->positions[3 * corners[2] + axis]);
}

/* A surface counts in all cells that it comes to within `reach`. */
static void test_all_surfaces(void **state) {
    mcv_packed packed = pack_boxes();
    const mcv_contact_grid *grid = packed.contact_grid;
    (void)state;
    assert_non_null(grid);
    assert_true(grid->reach > 0);
    ref_random random = ref_random_begin(1, 0, 0, 0);
    for (int i = 0; i < POINTS; ++i) {
        const uint32_t triangle = (uint32_t)ref_random_bits(&random) % packed.triangle_count,
                       medium = packed.instances[packed.triangles[4 * (size_t)triangle + 3]].medium;
        float p[3];
        if (medium == 0) continue; /* the floor is no body */
        point_on(&packed, triangle, &random, p);
        for (int axis = 0; axis < 3; ++axis)
            p[axis] += grid->reach * (float)(2 * ref_random_unit(&random) - 1);
        if (!(media_at(grid, p) >> (medium - 1) & 1))
            fail_msg("(%g %g %g): medium %u is near", (double)p[0], (double)p[1], (double)p[2],
                     medium);
    }
    mcv_packed_free(&packed);
}

/* The shared face has two media, the face beyond it and the third box one: a cell is 2 m / 64. */
static void test_known_places(void **state) {
    mcv_packed packed = pack_boxes();
    static const struct {
        float x;
        int media;
    } places[] = {{-0.25F, 1}, {0.25F, 2}, {0.75F, 1}, {1.25F, 1}, {1.75F, 1}, {1, 0}, {0.5F, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof places / sizeof places[0]; ++i) {
        const float p[3] = {places[i].x - (float)packed.centre[0], -(float)packed.centre[1],
                            -(float)packed.centre[2]};
        assert_int_equal(__builtin_popcount(media_at(packed.contact_grid, p)), places[i].media);
    }
    mcv_packed_free(&packed);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_all_surfaces),
                                       cmocka_unit_test(test_known_places)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
