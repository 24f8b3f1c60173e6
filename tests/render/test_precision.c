/* SPDX-License-Identifier: Apache-2.0 */
/* What each precision buys: long chains of reflections and lenses of meshes; mixed precision's
 * images. */
#include "agreement.h"

#include "analysis/compare.h"

/* test_precision_slow.c sets it: all cases, of which the quick test has those that no others stand
 * for. */
#ifndef SLOW
#define SLOW 0
#endif

/* What numbers are rounded to: floats, doubles, the 48 bits that a float and its rest keep. */
static const double units[RAY_TRACERS] = {0x1p-24, 0x1p-53, 0x1p-48};

/* T4: where rays through a ball of glass, n = 1.5, R = 1, cross the axis: h/sin 2(I - I'). */
static void ball_lens(void **state) {
    (void)state;
    const double n = 1.5, start = -3;
    mcv_scene *scene = new_scene();
    const uint32_t glass = add_glass(scene, n, 0, 0);
    const mcv_solid ball = sphere(1);
    add_solid(scene, &ball, glass, glass);
    double worst[RAY_TRACERS] = {0};
    for (int by = 0; by < RAY_TRACERS; ++by)
        for (double h = 0.05; h < 0.95; h += 0.05) {
            mcv_vertex v[DEPTH + 1];
            const double outside = asin(h), inside = asin(h / n), slope = 2 * (outside - inside),
                         truth = h / sin(slope);
            off_by off = {0, units[by]};
            off = off_beyond(off, units[by], -start, -start, cos(outside), 1, 1 / n);
            off = off_beyond(off, units[by], -start, 2 * cos(inside), cos(inside), 1, n);
            assert_int_equal(trace_one(scene, by, along_z(h, 0, start), v), 3);
            worst[by] = fmax(worst[by], fabs(crossing(v + 2) - truth));
            expect_near("T4 ball lens: crossing, by precision", by, crossing(v + 2), truth,
                        (off.place + (1 + truth) * off.way) / sin(slope));
        }
    for (int by = 0; by < RAY_TRACERS; ++by)
        print_message("  crossing of the axis, %s: within %.2g\n", name_of(by), worst[by]);
    mcv_scene_free(scene);
}

/*
 * A ray that goes round in a ball of glass, totally reflected: at each reflection it turns by 2 i
 * about the centre, so that the place of the n-th is at the angle φ + n (π - 2 i). The direction
 * errs by its rounding and twice the normal's, 16 units of rounding in all, and the angle of
 * incidence is wrong by the sum of those so far: n² 16 units over n reflections at most, were they
 * all of one sign. The largest coordinate is 1, and a place rounds by 5 units once more.
 */
static void reflections_in_a_ball(void **state) {
    (void)state;
    enum { MOST = 1000 };
    static const int numbers[] = {10, 100, 1000};
    const double phi = 0.3, incidence = 0.9;
    const mcv_trace_ray ray = {
        {cos(phi) - 0.5 * cos(phi + incidence), sin(phi) - 0.5 * sin(phi + incidence), 0},
        {cos(phi + incidence), sin(phi + incidence), 0}};
    mcv_scene *scene = new_scene();
    const uint32_t glass = add_glass(scene, 1.5, 0, 0);
    const mcv_solid ball = sphere(1);
    add_solid(scene, &ball, glass, glass);
    for (int by = 0; by < RAY_TRACERS; ++by) {
        const traced t = follow_deep(scene, by, MOST, &ray, 1);
        assert_int_equal(t.count, MOST + 1);
        for (int i = 0; i < 3; ++i) {
            char what[64];
            const mcv_vertex *v = t.vertices + numbers[i];
            const double n = numbers[i], angle = phi + (n - 1) * (M_PI - 2 * incidence);
            const double off = hypot(v->position[0] - cos(angle), v->position[1] - sin(angle));
            snprintf(what, sizeof what, "place of reflection %d in a ball of radius 1", numbers[i]);
            print_message("  %s, %s: off by %.2g\n", what, name_of(by), off);
            assert_int_equal(v->event, MCV_EVENT_REFLECT);
            expect_near(what, by, off, 0, (16 * n * n + 5) * units[by]);
        }
        free(t.vertices);
    }
    mcv_scene_free(scene);
}

/*
 * A mesh's triangles are met precisely, too: a ball and a box, turned and moved so that no
 * coordinate is a float. Rays that graze a triangle or meet another one are few.
 */
static void meshes_against_reference(void **state) {
    (void)state;
    enum { RAYS = 4096 };
    static const double radius = 0.01;
    const double c = 0.8, s = 0.6, half[3] = {0.01, 0.008, 0.006};
    const mcv_transform turned = {{c, 0, s, 0, 1, 0, -s, 0, c, 0.1, -0.05, 0.02}};
    for (int box = 0; box < 2; ++box) {
        mcv_scene *scene = new_scene();
        const uint32_t glass = add_glass(scene, 1.5168, 0, 0);
        if (box)
            add_box(scene, half, glass, turned);
        else
            add_sphere(scene, radius, 32, glass, turned);
        mcv_trace_ray *rays = calloc(RAYS, sizeof *rays);
        uint64_t seed = 3 + (uint64_t)box;
        for (int i = 0; i < RAYS; ++i)
            for (int k = 0; k < 3; ++k) {
                rays[i].origin[k] =
                    turned.m[9 + k] + 0.1 * (uniform(&seed) - 0.5) + (k == 2 ? 0.1 : 0);
                rays[i].direction[k] =
                    turned.m[9 + k] + 0.009 * (uniform(&seed) - 0.5) - rays[i].origin[k];
            }
        expect_agreement(box ? "box" : "ball", scene, rays, RAYS, 0.3, radius);
        free(rays);
        mcv_scene_free(scene);
    }
}

/* --- images
 * -----------------------------------------------------------------------------------------------------
 */

/* A ball of glass as a mesh before an exact one with a bubble, a mirror behind them, a pane and a
 * floor; a panel and the sky shine. */
static mcv_scene *still_life(void) {
    mcv_scene *scene = new_scene();
    mcv_solid ball = sphere(0.2), bubble = sphere(0.08);
    ball.to_world.m[9] = bubble.to_world.m[9] = 0.25;
    ball.to_world.m[11] = bubble.to_world.m[11] = 0.3;
    const uint32_t glass = add_glass(scene, 1.5, 0.7, 0), air = add_glass(scene, 1, 0, 1);
    add_solid(scene, &ball, glass, glass);
    add_solid(scene, &bubble, air, air);
    mcv_transform beside = unmoved;
    beside.m[9] = -0.25, beside.m[11] = 0.4;
    add_sphere(scene, 0.2, 16, glass, beside);
    const double third = 1.0 / 3;
    const double across[3] = {0, -1, 0}, up[3] = {0, 0, 1};
    add_rectangle(scene, 2, 1, add_material(scene, MCV_MATERIAL_MIRROR, NULL),
                  looking((const double[3]){0, 0.5, third}, across, up));
    add_rectangle(scene, 0.4, 0.4, add_material(scene, MCV_MATERIAL_SHEET, NULL),
                  looking_up_z(0.1, -0.2, 0.7));
    add_rectangle(scene, 2, 2, add_diffuse(scene, 0.6), looking_up_z(0, 0, 0));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.5, 0.5, add_absorber(scene), looking_down_z(0, 0, 1.7)), 3,
                0);
    add_environment(scene, 0.3);
    add_pinhole(scene, 24, 0.7,
                looking((const double[3]){0.1, -1, 1.5}, (const double[3]){0, 0.6, -0.8},
                        (const double[3]){0, 0.8, 0.6}));
    return scene;
}

static mcv_film render(const mcv_scene *scene, uint32_t precision, uint32_t schedule,
                       uint32_t slice, uint32_t seed) {
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    options.replicates = 16;
    options.last = 8;
    options.precision = precision;
    options.schedule = schedule;
    options.slice = slice;
    options.seed = seed;
    BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    assert_int_equal(stats.nonfinite, 0);
    assert_int_equal(strstr(stats.features, "mixed") != NULL, precision == MCV_PRECISION_MIXED);
    return film;
}

/* The same bits by both schedules and other slices; other ones than in single precision, but the
 * same picture. */
static void images(void **state) {
    (void)state;
    mcv_scene *scene = still_life();
    mcv_film tile = render(scene, MCV_PRECISION_MIXED, MCV_SCHEDULE_TILE, 0, 1);
    mcv_film alike = render(scene, MCV_PRECISION_SINGLE, MCV_SCHEDULE_TILE, 0, 1);
    mcv_film single = render(scene, MCV_PRECISION_SINGLE, MCV_SCHEDULE_TILE, 0, 2);
    const size_t bytes =
        (size_t)tile.width * tile.height * tile.channels * tile.replicates * sizeof *tile.sums;
    mcv_comparison comparison;
    for (int stream = 0; stream < 2 * SLOW; ++stream) {
        const uint32_t schedule = stream ? MCV_SCHEDULE_STREAM : MCV_SCHEDULE_TILE;
        mcv_film other = render(scene, MCV_PRECISION_MIXED, schedule, stream ? 0 : 64, 1);
        assert_memory_equal(tile.sums, other.sums, bytes);
        mcv_film_free(&other);
    }
    assert_memory_not_equal(tile.sums, alike.sums, bytes);
    BUILD(mcv_compare_films(&tile, &single, &comparison, &builder_error));
    print_message("  mixed and single: %s\n", comparison.reason);
    if (comparison.different) fail_msg("%s", comparison.reason);
    mcv_film_free(&tile);
    mcv_film_free(&alike);
    mcv_film_free(&single);
    mcv_scene_free(scene);
}

#ifndef IMAGES
#define IMAGES SLOW
#endif

int main(void) {
    const struct CMUnitTest rays[] = {cmocka_unit_test(ball_lens),
                                      cmocka_unit_test(reflections_in_a_ball),
                                      cmocka_unit_test(meshes_against_reference)};
    const struct CMUnitTest renders[] = {cmocka_unit_test(images)};
    return IMAGES ? cmocka_run_group_tests(renders, NULL, NULL)
                  : cmocka_run_group_tests(rays, NULL, NULL);
}
