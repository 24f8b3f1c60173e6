/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Light that a diffuse floor gets from parallel and area emitters, by next-event estimation and by
 * chance together, against closed forms. A floor of reflectance ρ under irradiance E has the
 * radiance ρ E/π.
 */
#include "estimates.h"

#include "render/render.h"
#include "uneven_panel.h"

enum { SAMPLES = 64, PIXELS = 16 };
static const double rho = 0.5;

static mcv_estimate render(const mcv_scene *scene) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    options.replicates = REPLICATES;
    options.last = SAMPLES;
    BUILD(render_again(scene, 0, &options, &film, &stats, &builder_error));
    const mcv_estimate mean = image_estimate(&film);
    mcv_film_free(&film);
    return mean;
}

/*
 * Some 15 roundings to float32 make 1e-6. In the narrowest cone chance finds the lamp too seldom to
 * show in the error, and its share of the light, at most sin²β = 1e-6 by any heuristic, is missing.
 */
static void expect(const char *what, const mcv_scene *scene, double expected) {
    expect_estimate(what, render(scene), expected, 0.01, 2e-6);
}

/* A floor of 4 m, seen in a spot of `spot` m about its centre, obliquely from 1 m away. */
static mcv_scene *floor_scene(double spot) {
    mcv_scene *scene = mcv_scene_new("floor");
    const double s = sqrt(0.5);
    add_rectangle(scene, 4, 4, add_diffuse(scene, rho), looking_up_z(0, 0, 0));
    add_pinhole(
        scene, PIXELS, spot,
        looking((const double[]){s, 0, s}, (const double[]){-s, 0, -s}, (const double[]){0, 1, 0}));
    return scene;
}

static void add_lamp(mcv_scene *scene, uint32_t type, double size, double height, double radiance,
                     double half_angle) {
    add_emitter(scene, type,
                add_rectangle(scene, size, size, add_absorber(scene), looking_down_z(0, 0, height)),
                radiance, half_angle);
}

/* Below the floor: with interpolated normals the program is that of the other tests. */
static void add_hidden_ball(mcv_scene *scene) {
    add_sphere(scene, 0.1, 16, add_absorber(scene), looking_down_z(0, 0, -2));
}

/* The lamp fills the whole cone of every receiver: E = π L sin²β. The camera is a point and hides
 * nothing. */
static void test_cone_within_the_lamp(void **state) {
    static const double half_angles[] = {1e-3, 0.1, 0.3, 0.5, 0.8};
    (void)state;
    for (size_t i = 0; i < sizeof half_angles / sizeof half_angles[0]; ++i) {
        const double beta = half_angles[i];
        char what[64];
        mcv_scene *scene = floor_scene(0.1);
        /* The spot reaches 0.1 m from the centre at most; the lamp is a metre up. */
        add_lamp(scene, MCV_EMITTER_PARALLEL, 2 * (0.2 + tan(beta)), 1, 3, beta);
        add_hidden_ball(scene);
        snprintf(what, sizeof what, "cone of %g rad within the lamp", beta);
        expect(what, scene, rho * 3 * pow(sin(beta), 2));
        mcv_scene_free(scene);
    }
}

/*
 * The receiver's cone holds the whole lamp, a square of side a at height h over the spot's centre:
 * E = L times its form factor π F, F = 4 (2 t/√(1 + t²)) atan(t/√(1 + t²)) / 2π with t = a/2h (four
 * rectangles with a corner above the receiver). A spot of 1 mm is a point: F varies by less than (1
 * mm/h)².
 */
static void test_lamp_within_the_cone(void **state) {
    static const struct {
        uint32_t type;
        double size, half_angle;
    } cases[] = {{MCV_EMITTER_PARALLEL, 0.02, 0.1},
                 {MCV_EMITTER_PARALLEL, 0.2, 0.4},
                 {MCV_EMITTER_PARALLEL, 1, 1},
                 {MCV_EMITTER_AREA, 0.02, 0},
                 {MCV_EMITTER_AREA, 1, 0}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double t = cases[i].size / 2;
        const double slope = t / sqrt(1 + t * t);
        const double form_factor = 4 * 2 * slope * atan(slope) / (2 * M_PI);
        char what[64];
        mcv_scene *scene = floor_scene(1e-3);
        add_lamp(scene, cases[i].type, cases[i].size, 1, 3, cases[i].half_angle);
        if (cases[i].type == MCV_EMITTER_PARALLEL) add_hidden_ball(scene);
        snprintf(what, sizeof what, "lamp of %g m within %s", cases[i].size,
                 cases[i].type == MCV_EMITTER_AREA ? "sight" : "the cone");
        expect(what, scene, rho * 3 * form_factor);
        mcv_scene_free(scene);
    }
}

/*
 * Light leaves a surface on the front of its triangles and by its normals: where these contradict
 * one another throughout, nowhere. Once the whole lamp, and once all but a small part of it, which
 * the lamp's cone over the spot leaves out.
 */
static void test_normals_against_their_triangles(void **state) {
    static const float positions[] = {-0.5f, -0.5f, 0,     0.5f, -0.5f, 0,    0.5f,
                                      0.5f,  0,     -0.5f, 0.5f, 0,     1,    1,
                                      0,     1.1f,  1,     0,    1,     1.1f, 0};
    static const float normals[] = {0,  0, -1, 0,  0, -1, 0,  0, -1, 0, 0,
                                    -1, 0, 0,  -1, 0, 0,  -1, 0, 0,  -1};
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3, 4, 6, 5};
    (void)state;
    for (uint32_t triangles = 2; triangles <= 3; ++triangles) {
        mcv_scene *scene = floor_scene(0.1);
        const mcv_mesh mesh = {.vertex_count = 7,
                               .triangle_count = triangles,
                               .positions = (float *)positions,
                               .normals = (float *)normals,
                               .indices = (uint32_t *)indices};
        const mcv_transform above = {{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1}};
        add_emitter(scene, MCV_EMITTER_PARALLEL,
                    add_instance(scene, &mesh, add_absorber(scene), above), 3, 0.1);
        const mcv_estimate m = render(scene);
        if (m.mean != 0)
            fail_msg("%u triangles: the spot under their backs has %g, expected 0", triangles,
                     m.mean);
        mcv_scene_free(scene);
    }
}

/*
 * A parallel panel of 100 mm whose cone has 0.5° in all (half-angle 0.25°), 100 mm over a diffuse
 * floor: the variance of independent samples, directions chosen in the cone against points chosen
 * on the panel. The panel's edge lies over x = 0: inside the light, and in the penumbra, 100 mm tan
 * 0.25° = 0.44 mm to both sides, where the cone's share on the panel falls from 1 to 0. Averaged
 * over the penumbra the variance is that of a hit or a miss within the cone, the mean of s(1 - s)
 * over shares s from 0 to 1, about 1/6; on the panel a hit has the probability p = π tan²β h²/A =
 * 6e-5 of one within the cone and 1/p times its value: the ratio is some 1/(2p)/(1/6) = 5e4 and
 * more. Inside the light only cosines and what the floor finds by chance vary.
 */
static double variance_at(double x, double width, bool even) {
    enum { SAMPLES_PER_PIXEL = 64 };
    const double beta = 0.25 * M_PI / 180;
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    mcv_scene *scene = mcv_scene_new("panel");
    add_rectangle(scene, 0.2, 0.2, add_diffuse(scene, rho), looking_up_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_panel(scene, 0.1, 0.1, even, looking_down_z(-0.05, 0, 0.1)), 3, beta);
    /* A spot of `width` seen from 50 mm above: the camera is a point. */
    add_pinhole(scene, PIXELS, width / 0.05, looking_down_z(x, 0, 0.05));
    options.sampler = MCV_SAMPLER_RANDOM;
    options.replicates = 64;
    options.last = SAMPLES_PER_PIXEL;
    BUILD(render_again(scene, 0, &options, &film, &stats, &builder_error));
    const size_t pixels = (size_t)film.width * film.height;
    double sum = 0;
    /* Of one sample of a pixel, from the spread of the replicates. */
    for (size_t i = 0; i < pixels; ++i) {
        double mean = 0, squares = 0;
        for (uint32_t r = 0; r < film.replicates; ++r)
            mean += film.sums[r * pixels + i] / film.replicates;
        for (uint32_t r = 0; r < film.replicates; ++r)
            squares += pow(film.sums[r * pixels + i] - mean, 2);
        sum += squares / (film.replicates - 1) / SAMPLES_PER_PIXEL;
    }
    mcv_film_free(&film);
    mcv_scene_free(scene);
    return sum / (double)pixels;
}

static void test_variance_of_a_narrow_panel(void **state) {
    static const struct {
        const char *what;
        double x, width, least;
    } cases[] = {{"inside the light", -0.05, 1e-3, 1e4}, {"in the penumbra", 0, 0.8e-3, 1e3}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double cone = variance_at(cases[i].x, cases[i].width, true);
        const double area = variance_at(cases[i].x, cases[i].width, false);
        print_message("%s: variance %.3g by the cone, %.3g by area, ratio %.3g\n", cases[i].what,
                      cone, area, area / cone);
        if (!(area / cone >= cases[i].least))
            fail_msg("%s: the variance falls by %g only", cases[i].what, area / cone);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cone_within_the_lamp),
                                       cmocka_unit_test(test_lamp_within_the_cone),
                                       cmocka_unit_test(test_normals_against_their_triangles),
                                       cmocka_unit_test(test_variance_of_a_narrow_panel)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
