/* SPDX-License-Identifier: Apache-2.0 */
/* The plane of light that a calibration fits. */
#include "test.h"

#include "triangulation/light_plane.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* A plane through (0.01, 0.02, 0.3) with the normal (1, 2, 3)/√14, and points of it. */
static const double at[3] = {0.01, 0.02, 0.3};

static void make_points(double points[][3], size_t count, bool line) {
    const double a[3] = {2 / sqrt(5), -1 / sqrt(5), 0},
                 b[3] = {3 / sqrt(70), 6 / sqrt(70), -5 / sqrt(70)};
    for (size_t n = 0; n < count; ++n)
        for (int i = 0; i < 3; ++i)
            points[n][i] = at[i] + 1e-3 * ((double)(n % 7) - 3) * a[i] +
                           (line ? 0 : 5e-4 * ((double)(n / 7) - 2)) * b[i];
}

/* Points of a plane give it back but for rounding. Their coordinates of 0.3 m have 3e-17 m, of
 * which 7e-4 m, the smaller spread, make 1e-13 of the normal. Sums of squares of 4e-6 m² have 1e-21
 * m²: spreads and the root that is the residual have 1e-10 m at most. */
static void test_fit(void **state) {
    (void)state;
    double points[35][3];
    mcv_light_plane plane;
    make_points(points, 35, false);
    assert_true(mcv_light_plane_fit((const double(*)[3])points, 35, &plane));
    const double sign = plane.normal[0] < 0 ? -1 : 1;
    for (int i = 0; i < 3; ++i) {
        if (!(fabs(sign * plane.normal[i] - (i + 1) / sqrt(14)) <= 1e-12))
            fail_msg("normal %d is %.12g", i, sign * plane.normal[i]);
        if (!(fabs(plane.point[i] - at[i]) <= 1e-12)) fail_msg("point %d: %g", i, plane.point[i]);
    }
    if (!(plane.residual <= 1e-10)) fail_msg("residual %g m", plane.residual);
    /* Seven places 1 mm apart spread by 2 mm, five 0.5 mm apart by √2/2 mm. */
    if (!(fabs(plane.spread[0] - 2e-3) <= 1e-10) ||
        !(fabs(plane.spread[1] - 5e-4 * M_SQRT2) <= 1e-10))
        fail_msg("spreads %g, %g m", plane.spread[0], plane.spread[1]);
}

/* A target at one place shows one line, through which many planes go. */
static void test_no_plane(void **state) {
    (void)state;
    double points[35][3];
    mcv_light_plane plane;
    make_points(points, 35, true);
    assert_false(mcv_light_plane_fit((const double(*)[3])points, 35, &plane));
    assert_false(mcv_light_plane_fit((const double(*)[3])points, 2, &plane));
}

/* A camera that is turned by 30° about x and stands aside; the node's x-z plane becomes the plane:
 * its y is the plane's normal, and its origin lies in it. */
static void test_turn(void **state) {
    (void)state;
    const double c = cos(M_PI / 6), s = sin(M_PI / 6);
    const mcv_camera_model model = {.rotation = {1, 0, 0, 0, c, -s, 0, s, c},
                                    .translation = {0.05, -0.02, 0.1}};
    const mcv_light_plane plane = {.point = {0.01, 0.02, 0.3},
                                   .normal = {1 / sqrt(14), 2 / sqrt(14), 3 / sqrt(14)}};
    const mcv_transform laser = {{1, 0, 0, 0, 1, 0, 0, 0, 1, 0.1, 0.2, 0.3}};
    mcv_transform turned;
    assert_true(mcv_light_plane_turn(&plane, &model, &laser, &turned));
    double y[3] = {0, 0, 0}, off = 0;
    for (int i = 0; i < 3; ++i) {
        double seen = model.translation[i];
        for (int k = 0; k < 3; ++k) {
            y[i] += model.rotation[3 * i + k] * turned.m[3 * k + 1];
            seen += model.rotation[3 * i + k] * turned.m[9 + k];
        }
        off += (seen - plane.point[i]) * plane.normal[i];
    }
    const double sign = y[0] < 0 ? -1 : 1;
    for (int i = 0; i < 3; ++i)
        if (!(fabs(sign * y[i] - plane.normal[i]) <= 1e-14)) fail_msg("y[%d] is %g", i, y[i]);
    if (!(fabs(off) <= 1e-15)) fail_msg("the origin is %g m off the plane", off);
    assert_true(mcv_transform_determinant(&turned) > 0.999);
}

/* Where the laser's z axis is the normal, within rounding or the other way, no axis in the plane is
 * nearest to it; 1e-6 rad beside, one is. */
static void test_no_turn(void **state) {
    (void)state;
    static const struct {
        double normal[3];
        bool turns;
    } cases[] = {{{0, 0, 1}, false},
                 {{0, 0, -1}, false},
                 {{0, 4 * DBL_EPSILON, 1}, false},
                 {{0, 1e-6, 1}, true}};
    const mcv_camera_model model = {.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    const mcv_transform laser = mcv_transform_identity();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_light_plane plane = {.point = {0, 0, 0.3}};
        mcv_transform turned;
        memcpy(plane.normal, cases[i].normal, sizeof plane.normal);
        if (mcv_light_plane_turn(&plane, &model, &laser, &turned) != cases[i].turns)
            fail_msg("case %zu: turned is %d, expected %d", i, !cases[i].turns, cases[i].turns);
        if (cases[i].turns && !(turned.m[5] < -0.999999)) fail_msg("z is %g of y", turned.m[5]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fit),
        cmocka_unit_test(test_no_plane),
        cmocka_unit_test(test_turn),
        cmocka_unit_test(test_no_turn),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
