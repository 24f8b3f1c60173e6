/* SPDX-License-Identifier: Apache-2.0 */
/* The light field emitter: which pixel shines where and in which direction, how much, and what is
 * refused. */
#include "image_emitters.h"

#include "scene/emitters.h"

enum { M = 5, N = 4, J = 4, K = 3, SUB_J = 8, SUB_K = 6 };
static const double pitch = 4e-3, distance = 0.3, lens = 0.03, range = 0.06;

#define NAMED \
    "\"type\":\"lightField\",\"size\":[\"20mm\",\"16mm\"],\"spatialResolution\":[5,4]," \
    "\"angularResolution\":[4,3],"
/* f = 50 mm, b = 60 mm: in focus at 300 mm, scale 0.2; a macro pixel of 0.8 mm sees one of the
 * emitter's. */
#define CAMERA \
    "\"type\":\"lightField\",\"focalLength\":\"50mm\",\"imageDistance\":\"60mm\"," \
    "\"lensDiameter\":\"30mm\"," \
    "\"spatialResolution\":[5,4],\"angularResolution\":[8,6],\"pixelSize\":[1e-4,1." \
    "3333333333333334e-4]"

/* The emitter's cell of one axis for a sine, -1: out of range. `edge` is set to how far the sine is
 * from the cell's edges, in cells. */
static int cell_of(double sine, int count, double *edge) {
    const double at = (sine / range + 1) / 2 * count;
    *edge = fmin(*edge, fabs(at - round(at)));
    return at < 0 || at > count ? -1 : (int)fmin(floor(at), count - 1);
}

/*
 * The image's pixel that a camera pixel sees, if its sub-aperture lies in one angular pixel. All
 * rays of a macro pixel meet in one point of the emitter, the middle of the macro pixel opposite
 * (the camera's right is the emitter's left), so a ray's direction there follows from its place on
 * the lens. The sine d_x = w_x/|w| grows with w_x and falls with |w_y|: its extremes over a
 * rectangle lie at its corners or where w_y = 0.
 */
static bool sees_one(uint32_t camera_column, uint32_t camera_row, int *column, int *row) {
    const int m = (int)camera_column / SUB_J, n = (int)camera_row / SUB_K;
    const double q[2] = {-(m + 0.5 - M / 2.0) * pitch,
                         (N / 2.0 - n - 0.5) * pitch}; /* in the emitter's frame */
    const double u = (double)(camera_column % SUB_J) / SUB_J,
                 v = (double)(camera_row % SUB_K) / SUB_K;
    /* o_x = (2u - 1) D/2 is the camera's right, thus -x of the emitter; o_y = -(2v - 1) D/2. */
    const double x[2] = {-(2 * u - 1) * lens / 2 - q[0],
                         -(2 * (u + 1.0 / SUB_J) - 1) * lens / 2 - q[0]};
    const double y[2] = {-(2 * v - 1) * lens / 2 - q[1],
                         -(2 * (v + 1.0 / SUB_K) - 1) * lens / 2 - q[1]};
    const double xs[3] = {x[0], x[1], x[0] * x[1] < 0 ? 0 : x[0]},
                 ys[3] = {y[0], y[1], y[0] * y[1] < 0 ? 0 : y[0]};
    double edge = 1;
    int j = -2, k = -2;
    for (int i = 0; i < 9; ++i) {
        const double w[2] = {xs[i % 3], ys[i / 3]},
                     length = sqrt(w[0] * w[0] + w[1] * w[1] + distance * distance);
        const int here_j = cell_of(w[0] / length, J, &edge),
                  here_k = cell_of(-w[1] / length, K, &edge);
        if (i > 0 && (here_j != j || here_k != k)) return false;
        j = here_j;
        k = here_k;
    }
    /* Sines of float32 are known to some 4e-8, 1e-6 cells: what touches an edge may see both. */
    if (edge < 1e-5) return false;
    *column = j < 0 || k < 0 ? -1 : (M - 1 - m) * J + j;
    *row = n * K + k;
    return true;
}

static void expect_pixels(bool reference, const char *rig, const char *text) {
    mcv_scene *scene;
    BUILD(load_text("light_field.gltf", text, NULL, &scene, &builder_error));
    mcv_film film = render_by(reference, scene, 0, 4, 1);
    mcv_image mean, error;
    int compared = 0, dark = 0;
    BUILD(mcv_film_develop(&film, &mean, &error, &builder_error));
    assert_int_equal(mean.width, M * SUB_J);
    assert_int_equal(mean.height, N * SUB_K);
    for (uint32_t row = 0; row < mean.height; ++row) {
        for (uint32_t column = 0; column < mean.width; ++column) {
            int from_column, from_row;
            uint8_t rgb[3];
            if (!sees_one(column, row, &from_column, &from_row)) continue;
            ++compared;
            dark += from_column < 0;
            for (uint32_t k = 0; k < 3; ++k) {
                double expected = 0;
                if (from_column >= 0) {
                    value_of(M * J, N * K, (uint32_t)from_column, (uint32_t)from_row, rgb);
                    expected = 2 * linear(rgb[k]);
                }
                const double seen = mean.pixels[(k * mean.height + row) * mean.width + column];
                /* Four products of float32 and a sum: 1e-6. */
                if (!(fabs(seen - expected) <= 1e-6 * expected))
                    fail_msg("%s, rig {%s}: pixel (%u, %u) channel %u is %.9g, expected %.9g of "
                             "(%d, %d)",
                             reference ? "reference" : "device", rig, column, row, k, seen,
                             expected, from_column, from_row);
            }
        }
    }
    print_message("%s: %d of %u pixels see one angular pixel, %d none\n",
                  reference ? "reference" : "device", compared, mean.width * mean.height, dark);
    /* Both kinds must be there for the test to be worth anything. */
    assert_true(compared > (int)(mean.width * mean.height) / 4);
    assert_true(dark > 0 && dark < compared / 2);
    mcv_image_free(&mean);
    mcv_image_free(&error);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

static void test_face_to_face(void **state) {
    (void)state;
    write_png("light_field.png", M * J, N * K);
    for (int i = 0; i < 4; ++i) {
        const char *rig = rigs[i >> 1];
        char *text = rig_text(rig, NAMED "\"image\":0,\"angularRange\":0.06,\"radiance\":2", CAMERA,
                              distance, "light_field.png");
        expect_pixels(i & 1, rig, text);
        free(text);
    }
}

/* A range whose light falls within 0.2 m · tan asin 0.2 √2 = 59 mm of what is right before the
 * emitter, into the camera's field. */
static void test_power_arrives(void **state) {
    (void)state;
    static const double power[3] = {1, 2, 0.25};
    char *text = rig_text("", NAMED "\"image\":0,\"angularRange\":0.2,\"power\":[1,2,0.25]", CAMERA,
                          distance, "light_field.png");
    expect_power(text, power, 0.15, 0, "light field, range 0.2");
    free(text);
}

/*
 * Radiance 1 everywhere: power and solid angle are those of the directions alone, integrated here
 * by the midpoint rule in x, with the integrals over y in closed form: ∫dy = 2 y₁ and ∫dy/√(1 - x²
 * - y²) = 2 asin(y₁/√(1 - x²)), y₁ = min(a, √(1 - x²)). The integrands have a root at worst, whose
 * midpoint rule is off by less than h^1.5: 1e-7 for 10^5 steps.
 */
static void test_solid_angles(void **state) {
    (void)state;
    static const double ranges[] = {0.01, 0.3, 0.70710678118654752, 0.8, 1};
    enum { STEPS = 100000 };
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; ++i) {
        const double a = ranges[i];
        double projected = 0, solid = 0;
        mcv_emitter emitter = {.type = MCV_EMITTER_LIGHT_FIELD_EMITTER};
        emitter.as.light_field_emitter.angularRange = a;
        for (int s = 0; s < STEPS; ++s) {
            const double x = a * (2 * (s + 0.5) / STEPS - 1), circle = sqrt(1 - x * x),
                         y = fmin(a, circle);
            projected += 2 * y * 2 * a / STEPS;
            solid += 2 * asin(y / circle) * 2 * a / STEPS;
        }
        if (!(fabs(mcv_emitter_projected_solid_angle(&emitter) - projected) <= 1e-7 * projected))
            fail_msg("range %g: projected solid angle %.12g, expected %.12g", a,
                     mcv_emitter_projected_solid_angle(&emitter), projected);
        if (!(fabs(mcv_emitter_solid_angle(&emitter) - solid) <= 1e-7 * solid))
            fail_msg("range %g: solid angle %.12g, expected %.12g", a,
                     mcv_emitter_solid_angle(&emitter), solid);
    }
}

/* The image's mean weighs a pixel by its share of the unit disk, counted here on a grid of 2000 x
 * 2000 points: its edge is that fine. */
static void test_mean_of_image(void **state) {
    (void)state;
    enum { POINTS = 2000 };
    mcv_scene *scene;
    char *text =
        rig_text("", NAMED "\"image\":0,\"radiance\":1", CAMERA, distance, "light_field.png");
    BUILD(load_text("light_field.gltf", text, NULL, &scene, &builder_error));
    double sum[3] = {0, 0, 0}, inside[J * K] = {0}, total = 0, mean[3];
    for (int i = 0; i < POINTS * POINTS; ++i) {
        const int column = i % POINTS, row = i / POINTS;
        const double x = (column + 0.5) / POINTS * 2 - 1, y = (row + 0.5) / POINTS * 2 - 1;
        const int cell = row * K / POINTS * J + column * J / POINTS;
        if (x * x + y * y <= 1) inside[cell] += 1;
    }
    for (uint32_t row = 0; row < N * K; ++row) {
        for (uint32_t column = 0; column < M * J; ++column) {
            uint8_t rgb[3];
            value_of(M * J, N * K, column, row, rgb);
            for (int k = 0; k < 3; ++k) sum[k] += linear(rgb[k]) * inside[row % K * J + column % J];
            total += inside[row % K * J + column % J];
        }
    }
    mcv_emitter_image_mean(scene, &scene->emitters[0], mean);
    for (int k = 0; k < 3; ++k)
        if (!(fabs(mean[k] - sum[k] / total) <= mean[k] / POINTS))
            fail_msg("channel %d: mean %.9g, counted %.9g", k, mean[k], sum[k] / total);
    mcv_scene_free(scene);
    free(text);
}

static void test_bad_input(void **state) {
    (void)state;
    static const bad_emitter cases[] = {
        {NAMED "\"radiance\":1", "emitters/e/image: is missing"},
        {NAMED "\"image\":0,\"radiance\":1,\"angularRange\":0",
         "emitters/e/angularRange: 0 must be above 0"},
        {NAMED "\"image\":0,\"radiance\":1,\"angularRange\":1.5", "emitters/e/angularRange: "},
        {NAMED "\"image\":0,\"radiance\":1,\"halfAngle\":1",
         "emitters/e: unknown key \"halfAngle\""},
        {"\"type\":\"lightField\",\"size\":1,\"spatialResolution\":[4,5],\"angularResolution\":[4,"
         "3],\"image\":0,\"radiance\":1",
         "emitters/e/image: has 20 x 12 pixels, but must have 16 x 15"},
        {"\"type\":\"lightField\",\"size\":1,\"spatialResolution\":[65536,65536],"
         "\"angularResolution\":65536,\"image\":0,\"radiance\":1",
         "emitters/e/image: has 20 x 12 pixels, but must have 4294967296 x 4294967296"},
        {"\"type\":\"lightField\",\"size\":1,\"angularResolution\":[4,3],\"image\":0,\"radiance\":"
         "1",
         "emitters/e/spatialResolution: is missing"},
    };
    refuse_emitters(cases, sizeof cases / sizeof cases[0], "light_field.png");
    refuse_images(NAMED "\"radiance\":1,", 20, 12);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_face_to_face), cmocka_unit_test(test_power_arrives),
        cmocka_unit_test(test_solid_angles), cmocka_unit_test(test_mean_of_image),
        cmocka_unit_test(test_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
