/* SPDX-License-Identifier: Apache-2.0 */
/* The pilot that decides how many light paths there are (host/render/light_pilot.c). */
#include "estimates.h"

#include "peer_scenes.h"
#include "render/renderer.h"

/*
 * With 1/2^k of the light paths, the time to an error goes as (V_c + 2^k V_l)(T_c + T_l / 2^k),
 * which is least for 2^k = √(V_c T_l / (V_l T_c)).
 */
static void test_best_thinning(void **state) {
    (void)state;
    const struct {
        double camera_variance, light_variance, camera_time, light_time;
        uint32_t begun, best;
        const char *what;
    } cases[] = {
        {16, 1, 1, 16, 0, 4, "√256 = 2^4"},
        {16, 1, 1, 16, 4, 6, "the same on top of 2^4: 2^8, of which 2^6 is the most"},
        {1, 16, 16, 1, 6, 2, "√(1/256) = 2^-4"},
        {1, 1, 1, 1, 3, 3, "best as it is"},
        {1, 0, 1, 1, 0, 6, "light paths that bring nothing"},
        {0, 1, 1, 1, 2, 0, "light paths that bring everything"},
        {0, 0, 1, 1, 2, 2, "a black image tells nothing"},
        {1, 1, 1, 1.05, 3, 3, "too little to gain"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const uint32_t best =
            mcv_best_thinning(cases[i].camera_variance, cases[i].light_variance,
                              cases[i].camera_time, cases[i].light_time, cases[i].begun);
        if (best != cases[i].best)
            fail_msg("%s: 2^%u, expected 2^%u", cases[i].what, best, cases[i].best);
    }
}

/* A ball of glass under a sky, and a narrow cone of light that brings next to nothing. */
static mcv_film render_dim_panel(bool pilot, uint32_t seed, mcv_render_stats *stats) {
    mcv_scene *scene = new_scene();
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    add_environment(scene, 1);
    add_rectangle(scene, 4, 4, add_peer_diffuse(scene, false, 0.6), looking_up_z(0, 0, 0));
    add_ball(scene, 0.3, 1.5, add_glass(scene, 1.5, 0, 0));
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 1, 1, add_absorber(scene), looking_down_z(0, 0, 5)), 1e-3,
                M_PI / 180);
    add_pinhole(scene, 48, 0.5, looking_down_z(0, 0, 4));
    options.last = 16;
    options.seed = seed;
    options.light_pilot = pilot;
    BUILD(mcv_render(scene, 0, &options, &film, stats, &builder_error));
    assert_non_null(strstr(stats->features, "light-tracing"));
    mcv_scene_free(scene);
    return film;
}

/* There are fewer light paths, the picture is the same, and so are the bits of the same seed. */
static void test_light_paths_that_bring_little(void **state) {
    (void)state;
    mcv_render_stats by_rule, by_pilot, again;
    mcv_film rule = render_dim_panel(false, 1, &by_rule),
             pilot = render_dim_panel(true, 2, &by_pilot), twin = render_dim_panel(true, 2, &again);
    print_message("%llu rays by rule, %llu with a pilot\n", (unsigned long long)by_rule.rays,
                  (unsigned long long)by_pilot.rays);
    if (!(by_pilot.rays < by_rule.rays)) fail_msg("a pilot leaves all light paths");
    expect_same_picture("with and without a pilot", &rule, &pilot);
    assert_memory_equal(pilot.sums, twin.sums, 8 * mcv_film_values(&pilot));
    mcv_film_free(&rule);
    mcv_film_free(&pilot);
    mcv_film_free(&twin);
}

/* Light in portions of at most b has squares of at most b times its sum: n of them, b each. */
static void test_missed_squares(void **state) {
    (void)state;
    const struct {
        double missed, uncertain, brightest, squares;
    } cases[] = {{6, 0, 3, 2 * 3 * 3}, {7, 1, 3, 2 * 3 * 3}, {1, 2, 3, 0}, {-4, 1, 3, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        const double squares =
            mcv_missed_squares(cases[i].missed, cases[i].uncertain, cases[i].brightest);
        if (squares != cases[i].squares)
            fail_msg("light %g ± %g in portions of %g: squares %g, expected %g", cases[i].missed,
                     cases[i].uncertain, cases[i].brightest, squares, cases[i].squares);
    }
}

/* Brushed metal under a ring of lamps. */
static void add_metal_scene(mcv_scene *scene) {
    add_ball(scene, 0.5, 0.5, add_metal(scene, 0.45));
    for (int i = 0; i < 24; ++i)
        add_emitter(
            scene, MCV_EMITTER_AREA,
            add_rectangle(scene, 0.2, 0.2, add_absorber(scene),
                          looking_down_z(1.5 * cos(M_PI / 12 * i), 1.5 * sin(M_PI / 12 * i), 1.8)),
            30, 0);
    add_pinhole(scene, 64, 0.5, looking_down_z(0, 0, 4));
}

/* The spot that a ball of glass, which the camera does not see, makes of a small lamp. */
static void add_caustic_scene(mcv_scene *scene) {
    const double s = sqrt(0.2), at[3] = {2, 0, 1}, forward[3] = {-2 * s, 0, -s};
    add_ball(scene, 0.3, 1.2, add_glass(scene, 1.5, 0, 0));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.05, 0.05, add_absorber(scene), looking_down_z(0, 0, 3)),
                3000, 0);
    add_pinhole(scene, 64, 0.25, looking(at, forward, (const double[3]){0, 1, 0}));
}

static mcv_film render_floor(void (*add)(mcv_scene *scene), bool pilot, uint32_t seed,
                             mcv_render_stats *stats) {
    mcv_scene *scene = new_scene();
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    add_rectangle(scene, 4, 4, add_peer_diffuse(scene, false, 0.6), looking_up_z(0, 0, 0));
    add(scene);
    options.last = 32;
    options.seed = seed;
    options.light_pilot = pilot;
    BUILD(mcv_render(scene, 0, &options, &film, stats, &builder_error));
    assert_non_null(strstr(stats->features, "light-tracing"));
    mcv_scene_free(scene);
    return film;
}

/*
 * What a pilot decides does not change the picture: of rough metal, whose lamps camera paths meet
 * often enough by themselves, and of a caustic, which they find once in thousands of paths.
 */
static void test_pilot_decides(void **state) {
    (void)state;
    const struct {
        const char *what;
        void (*add)(mcv_scene *scene);
        bool pays;
    } cases[] = {{"metal under a ring of lamps", add_metal_scene, false},
                 {"a small lamp's caustic", add_caustic_scene, true}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        mcv_render_stats by_rule, by_pilot;
        mcv_film rule = render_floor(cases[i].add, false, 1, &by_rule);
        for (uint32_t seed = 2; seed < 5; ++seed) {
            mcv_film pilot = render_floor(cases[i].add, true, seed, &by_pilot);
            print_message("%s: light paths per sample %g by rule, %g with a pilot; time without "
                          "them over that with them: %g\n",
                          cases[i].what, by_rule.light_paths, by_pilot.light_paths,
                          by_pilot.light_ratio);
            if ((by_pilot.light_paths > 0) != cases[i].pays)
                fail_msg("%s: %g light paths per sample", cases[i].what, by_pilot.light_paths);
            expect_same_picture(cases[i].what, &rule, &pilot);
            mcv_film_free(&pilot);
        }
        mcv_film_free(&rule);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_best_thinning),
        cmocka_unit_test(test_missed_squares),
        cmocka_unit_test(test_pilot_decides),
        cmocka_unit_test(test_light_paths_that_bring_little),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
