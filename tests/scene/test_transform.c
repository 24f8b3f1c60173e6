/* SPDX-License-Identifier: Apache-2.0 */
/* Transforms against what they do to points: quaternions, composition, normals of mirrored and
 * sheared bodies. */
#include <math.h>
#include "test.h"

#include "scene/transform.h"

/* A few roundings of numbers of about 1. */
static const double rounding = 1e-14;

static void expect_vector(const double v[3], double x, double y, double z) {
    if (!(fabs(v[0] - x) < rounding && fabs(v[1] - y) < rounding && fabs(v[2] - z) < rounding))
        fail_msg("(%.17g, %.17g, %.17g) must be (%g, %g, %g)", v[0], v[1], v[2], x, y, z);
}

/* By 90° about each axis, right-handed: y goes to z, z to x, x to y; scaled first, moved last. */
static void test_rotation(void **state) {
    const double one[3] = {1, 1, 1}, nowhere[3] = {0, 0, 0}, s = sqrt(0.5);
    (void)state;
    for (int axis = 0; axis < 3; ++axis) {
        double q[4] = {0, 0, 0, s}, from[3] = {0, 0, 0}, to[3], expected[3] = {0, 0, 0};
        q[axis] = s;
        from[(axis + 1) % 3] = 1;
        expected[(axis + 2) % 3] = 1;
        const mcv_transform turn = mcv_transform_from_trs(nowhere, q, one);
        mcv_transform_vector(&turn, from, to);
        expect_vector(to, expected[0], expected[1], expected[2]);
    }
    const double place[3] = {10, 20, 30}, about_z[4] = {0, 0, s, s}, scale[3] = {2, 3, 4},
                 point[3] = {1, 1, 1};
    const mcv_transform all = mcv_transform_from_trs(place, about_z, scale);
    double at[3];
    mcv_transform_point(&all, point, at);
    expect_vector(at, 10 - 3, 20 + 2, 30 + 4);
}

/* The inner one first. */
static void test_composition(void **state) {
    const double s = sqrt(0.5), about_x[4] = {s, 0, 0, s}, about_z[4] = {0, 0, s, s};
    const mcv_transform inner =
        mcv_transform_from_trs((double[]){1, 2, 3}, about_x, (double[]){1, 2, 1});
    const mcv_transform outer =
        mcv_transform_from_trs((double[]){-4, 5, 6}, about_z, (double[]){3, 1, 1});
    const mcv_transform both = mcv_transform_compose(&outer, &inner);
    const double point[3] = {0.5, -0.25, 2};
    double within[3], expected[3], at[3];
    (void)state;
    mcv_transform_point(&inner, point, within);
    mcv_transform_point(&outer, within, expected);
    mcv_transform_point(&both, point, at);
    expect_vector(at, expected[0], expected[1], expected[2]);
}

/* A normal stays across the surface, and on the side on which it was, whether the transform mirrors
 * or not. */
static void test_normals(void **state) {
    const double n[3] = {0.6, 0, 0.8}, across[2][3] = {{0.8, 0, -0.6}, {0, 1, 0}},
                 outside[3] = {0.5, 0.7, 1};
    (void)state;
    for (int mirrored = 0; mirrored < 2; ++mirrored) {
        const mcv_transform t = {{mirrored ? -2 : 2, 0.3, 0, 0, 1, 0.5, 0.1, 0, 3, 7, 8, 9}};
        double normal[3], v[3], side = 0;
        mcv_transform_normal(&t, n, normal);
        for (int i = 0; i < 2; ++i) {
            mcv_transform_vector(&t, across[i], v);
            const double dot = normal[0] * v[0] + normal[1] * v[1] + normal[2] * v[2];
            if (!(fabs(dot) < 10 * rounding))
                fail_msg("mirrored %d: the normal leans by %g", mirrored, dot);
        }
        mcv_transform_vector(&t, outside, v);
        for (int k = 0; k < 3; ++k) side += normal[k] * v[k];
        if (!(side > 0)) fail_msg("mirrored %d: the normal is on the other side", mirrored);
        assert_true((mcv_transform_determinant(&t) < 0) == mirrored);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rotation),
        cmocka_unit_test(test_composition),
        cmocka_unit_test(test_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
