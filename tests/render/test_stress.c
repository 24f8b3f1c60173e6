/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Scenes at the edge of what numbers hold: far away, tiny, huge, degenerate, touching, dark and
 * bright. Each has an exact answer: the same bits, or a furnace in which every path that is not cut
 * brings the same.
 */
#include "exact_builder.h"
#include "estimates.h"

#include "reference/random.h"

/* Which of the tests run: no file of them shall take long. */
enum { PART_BODIES, PART_SCALES, PART_LIGHT };
#ifndef PART
#define PART PART_BODIES
#endif

static mcv_film render_by(bool reference, const mcv_scene *scene, uint32_t samples, uint32_t depth,
                          mcv_render_stats *stats) {
    mcv_render_options options = mcv_render_defaults();
    mcv_film film = {0};
    options.last = samples;
    options.depth = depth;
    options.replicates = 4;
    BUILD((reference ? mcv_reference_render : mcv_render)(scene, 0, &options, &film, stats,
                                                          &builder_error));
    return film;
}

static bool same_bits(const mcv_film *a, const mcv_film *b) {
    const size_t values = (size_t)a->width * a->height * a->channels * a->replicates;
    return a->samples == b->samples && memcmp(a->sums, b->sums, values * sizeof *a->sums) == 0;
}

/* --- scale and place
 * -------------------------------------------------------------------------------------------- */

static mcv_transform moved(mcv_transform t, double scale, const double by[3]) {
    for (int k = 0; k < 3; ++k) t.m[9 + k] = scale * t.m[9 + k] + by[k];
    return t;
}

/* Glass with absorption, a bubble, an exact lens, a mirror, a lit diffuse floor and two kinds of
 * light, in units of `scale` metres. */
static mcv_scene *everything(double scale, const double by[3]) {
    mcv_scene *scene = mcv_scene_new("everything");
    const double box[3] = {0.25 * scale, 0.125 * scale, 0.125 * scale};
    add_sphere(scene, 0.3 * scale, 16, add_glass(scene, 1.5, 2 / scale, 0),
               moved(unmoved, scale, by));
    add_sphere(scene, 0.1 * scale, 8, add_glass(scene, 1, 0, 1), moved(unmoved, scale, by));
    mcv_solid lens = element(0.2 * scale, (mcv_cap){.z = -0.05 * scale, .curvature = 1 / scale},
                             (mcv_cap){.z = 0.05 * scale,
                                       .curvature = -0.5 / scale,
                                       .conic = -0.5,
                                       .asphere = {0.25 / pow(scale, 3)}});
    lens.to_world = moved(looking_down_z(-0.5, 0.25, 0.25), scale, by);
    const uint32_t glass = add_glass(scene, 1.75, 0, 0);
    add_solid(scene, &lens, glass, add_absorber(scene));
    add_rectangle(scene, 2 * scale, 2 * scale, add_diffuse(scene, 0.6),
                  moved(looking_up_z(0, 0, -0.5), scale, by));
    add_box(scene, box, add_material(scene, MCV_MATERIAL_MIRROR, NULL),
            moved(looking_down_z(0.5, 0.125, -0.25), scale, by));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.25 * scale, 0.25 * scale, add_absorber(scene),
                              moved(looking_down_z(0.375, 0.375, 1), scale, by)),
                3, 0);
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.5 * scale, 0.5 * scale, add_absorber(scene),
                              moved(looking_down_z(-0.25, 0, 1), scale, by)),
                100, 0.05);
    add_environment(scene, 0.1);
    mcv_sensor camera = sensor_defaults(MCV_SENSOR_THIN_LENS);
    mcv_thin_lens_params *p = &camera.as.thin_lens;
    /* No focal length is above a kilometre, no pixel above a metre. */
    p->focalLength = 0x1p-16 * scale;
    p->imageDistance = 0x1.0001p-16 * scale;
    p->lensDiameter = 0x1p-17 * scale;
    p->resolution[0] = p->resolution[1] = 20;
    p->pixelSize[0] = p->pixelSize[1] = 0x1p-16 * 0.046 * scale;
    add_sensor(scene, MCV_SENSOR_THIN_LENS, &camera,
               moved(looking_down_z(0.0625, 0, 1.5), scale, by));
    return scene;
}

static const double nowhere[3] = {0, 0, 0};

static void test_powers_of_two_change_no_bit(void **state) {
    mcv_render_stats stats;
    mcv_scene *scene = everything(1, nowhere);
    mcv_film here = render_by(false, scene, 16, 16, &stats);
    (void)state;
    mcv_scene_free(scene);
    static const double scales[] = {0x1p-20, 0x1p-1, 0x1p20};
    for (int i = 0; i < 3; ++i) {
        scene = everything(scales[i], nowhere);
        mcv_film there = render_by(false, scene, 16, 16, &stats);
        if (!same_bits(&here, &there))
            fail_msg("scaled by %g: other bits, means %g and %g", scales[i], mcv_film_mean(&here),
                     mcv_film_mean(&there));
        mcv_film_free(&there);
        mcv_scene_free(scene);
    }
    mcv_film_free(&here);
}

/* To a million metres, where float32 steps by 6 cm: the scene is centred in double. Multiples of
 * the grid on which its centre snaps. */
static void test_translations_change_no_bit(void **state) {
    static const double places[][3] = {
        {1024, 0, 0}, {-4096, 512, 0x1p16}, {0x1p20, -0x1p20, 0x1p20}};
    mcv_render_stats stats;
    mcv_scene *scene = everything(1, nowhere);
    mcv_film here = render_by(false, scene, 16, 16, &stats);
    (void)state;
    mcv_scene_free(scene);
    for (int i = 0; i < 3; ++i) {
        scene = everything(1, places[i]);
        mcv_film there = render_by(false, scene, 16, 16, &stats);
        if (!same_bits(&here, &there))
            fail_msg("moved to %g: other bits, means %g and %g", places[i][0], mcv_film_mean(&here),
                     mcv_film_mean(&there));
        mcv_film_free(&there);
        mcv_scene_free(scene);
    }
    mcv_film_free(&here);
}

/* Other factors and places round; the picture is the same. */
static void test_other_scales_and_places(void **state) {
    static const struct {
        double scale, by[3];
    } cases[] = {{1e-6, {0, 0, 0}},
                 {1e6, {0, 0, 0}},
                 {1, {148376, 1234, -223423}},
                 {1e-3, {1e3, -1e3, 1e3}}};
    mcv_film films[2];
    (void)state;
    for (int i = -1; i < 4; ++i) {
        mcv_scene *scene = i < 0 ? everything(1, nowhere) : everything(cases[i].scale, cases[i].by);
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats;
        mcv_comparison c;
        options.last = 32;
        options.replicates = REPLICATES;
        options.seed = (uint32_t)(i + 1);
        BUILD(mcv_render(scene, 0, &options, &films[i < 0 ? 0 : 1], &stats, &builder_error));
        mcv_scene_free(scene);
        assert_int_equal(stats.unmatched, 0);
        if (i < 0) continue;
        BUILD(mcv_compare_films(&films[0], &films[1], &c, &builder_error));
        if (c.different) fail_msg("%g m at %g m: %s", cases[i].scale, cases[i].by[0], c.reason);
        mcv_film_free(&films[1]);
    }
    mcv_film_free(&films[0]);
}

/* --- furnaces
 * ---------------------------------------------------------------------------------------------------
 */

/* Bodies without loss vanish in an even surrounding; what the depth cuts is counted. The share of
 * paths that may lose a medium: `lost`. */
static void expect_furnace(const char *what, mcv_scene *scene, uint32_t pixels, double width,
                           double distance, double lost) {
    add_environment(scene, 1);
    add_pinhole(scene, pixels, width, looking_down_z(0, 0, distance));
    for (int reference = 0; reference < 2; ++reference) {
        mcv_render_stats stats;
        mcv_film film = render_by(reference, scene, 16, 200, &stats);
        const double missing = mcv_film_mean(&film) + stats.lost_energy - 1;
        print_message("  %s, %s: mean + lost - 1 = %.2g, lost %.2g, %llu of %llu paths unmatched\n",
                      what, name_of(reference), missing, stats.lost_energy,
                      (unsigned long long)stats.unmatched, (unsigned long long)stats.paths);
        /* Equal terms but for float32's roundings on the way, and lost energy in steps of 2^-11 of
         * each cut path. */
        if (!(fabs(missing) <= 1e-6 + 0x1p-11 * stats.lost_energy))
            fail_msg("%s, %s: %g is missing", what, name_of(reference), missing);
        assert_int_equal(stats.nonfinite, 0);
        if (!((double)stats.unmatched <= lost * (double)stats.paths))
            fail_msg("%s, %s: %llu of %llu paths unmatched", what, name_of(reference),
                     (unsigned long long)stats.unmatched, (unsigned long long)stats.paths);
        mcv_film_free(&film);
    }
    mcv_scene_free(scene);
}

/* A small ball off the field: boxes and balls have one program. */
static void add_smooth_beside(mcv_scene *scene) {
    add_sphere(scene, 0.05, 8, add_glass(scene, 1.5, 0, 0), looking_down_z(2, 0, 0));
}

/* `n` triangles meet at each tip of a bipyramid of glass, which fills the field. */
static void expect_fan(uint32_t n, uint32_t pixels) {
    mcv_scene *scene = mcv_scene_new("fan");
    float *positions = malloc((n + 2) * 12);
    uint32_t *indices = malloc(2 * n * 12);
    char what[64];
    assert_true(positions && indices);
    for (uint32_t i = 0; i < n; ++i) {
        const double angle = 2 * M_PI * i / n;
        memcpy(positions + 3 * i,
               (float[3]){(float)(0.5 * cos(angle)), (float)(0.5 * sin(angle)),
                          (float)(0.05 * sin(3 * angle))},
               12);
        memcpy(indices + 6 * i, (uint32_t[6]){i, (i + 1) % n, n, (i + 1) % n, i, n + 1}, 24);
    }
    memcpy(positions + 3 * n, (float[6]){0.01F, 0.02F, 0.4F, -0.02F, 0.01F, -0.4F}, 24);
    add_instance(scene,
                 &(mcv_mesh){.vertex_count = n + 2,
                             .triangle_count = 2 * n,
                             .positions = positions,
                             .indices = indices},
                 add_glass(scene, 1.5, 0, 0), unmoved);
    free(positions);
    free(indices);
    add_smooth_beside(scene);
    snprintf(what, sizeof what, "fans of %u triangles", n);
    expect_furnace(what, scene, pixels, 0.2, 3, 0); /* 0.6 m wide at the rim of 1 m */
}

/*
 * The boxes of slivers overlap, so that each path meets a fixed share of all triangles: what many
 * triangles at one place break shows in a few paths, what few paths in a thousand lose shows with
 * fewer triangles.
 */
static void test_fan(void **state) {
    (void)state;
    expect_fan(100000, 2);
    expect_fan(4000, 14);
}

static void test_bodies(void **state) {
    (void)state;
    mcv_scene *scene = mcv_scene_new("bubble");
    add_sphere(scene, 0.5, 48, add_glass(scene, 1.5, 0, 0), unmoved);
    add_sphere(scene, 0.25, 48, add_glass(scene, 1, 0, 1), looking_down_z(0, 0, 0.25));
    expect_furnace("a bubble that touches the surface from inside", scene, 24, 0.5, 3, 0);
    scene = mcv_scene_new("inclusion");
    add_sphere(scene, 0.05, 48, add_glass(scene, 1.5, 0, 0), unmoved);
    add_sphere(scene, 0.5e-6, 16, add_glass(scene, 1.7, 0, 1), looking_down_z(0, 0, 0.02));
    /* Points 20 mm off the middle round by 2 nm, and origins are moved as far: at its outline a
     * path may miss one of two faces, which is told. */
    expect_furnace("an inclusion of 1 um in 100 mm", scene, 24, 2e-6 / 0.08, 0.1, 1e-3);
    scene = mcv_scene_new("step");
    add_sphere(scene, 0.5, 48, add_glass(scene, 1.5, 0, 0), unmoved);
    add_sphere(scene, 0.3, 48, add_glass(scene, 1.5 + 1e-7, 0, 1), unmoved);
    add_sphere(scene, 0.2, 48, add_glass(scene, 3.5, 0, 2), unmoved);
    expect_furnace("steps of the index of 1e-7 and 2", scene, 24, 0.5, 3, 0);
    scene = mcv_scene_new("nested");
    for (uint32_t i = 0; i < 16; ++i)
        add_sphere(scene, 0.5 - 0.03 * i, 24, add_glass(scene, 1.2 + 0.05 * i, 0, i), unmoved);
    expect_furnace("16 bodies inside each other", scene, 24, 0.5, 3, 0);
    scene = mcv_scene_new("twice");
    add_sphere(scene, 0.5, 32, add_glass(scene, 1.5, 0, 0), unmoved);
    add_sphere(scene, 0.5, 32, add_glass(scene, 1.7, 0, 1), unmoved);
    expect_furnace("two bodies in one place", scene, 24, 0.5, 3, 0);
    scene = mcv_scene_new("needles");
    for (int i = 0; i < 8; ++i) {
        const double half[3] = {0.5, 0.5 * pow(10, -i), 0.01};
        add_box(scene, half, add_glass(scene, 1.5, 0, 0), looking_down_z(0, 0, 0.03 * i));
    }
    add_smooth_beside(scene);
    expect_furnace("boxes of aspects up to 10^7", scene, 24, 0.5, 3, 0);
}

/* --- meshes
 * -----------------------------------------------------------------------------------------------------
 */

/* Points and lines are never met, whatever is behind them; of faces in one place one wins, whoever
 * asks. */
static void test_degenerate_and_double_faces(void **state) {
    mcv_film films[3];
    (void)state;
    for (int i = 0; i < 3; ++i) {
        mcv_scene *scene = mcv_scene_new("faces");
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats;
        float positions[] = {0,      0,  0.1F, 0, 0,      0.1F, 0.2F, 0.1F, 0.1F,
                             -1,     -1, 0.1F, 0, 0,      0.1F, 1,    1,    0.1F,
                             1e-20F, 0,  0.1F, 0, 1e-20F, 0.1F, 0,    0,    0.1F};
        uint32_t indices[] = {0, 1, 2, 3, 4, 5, 6, 7, 8};
        if (i > 0)
            add_instance(scene,
                         &(mcv_mesh){.vertex_count = 9,
                                     .triangle_count = 3,
                                     .positions = positions,
                                     .indices = indices},
                         add_absorber(scene), unmoved);
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 1, 1, add_absorber(scene), looking_up_z(0, 0, 0)), 1, 0);
        add_emitter(scene, MCV_EMITTER_AREA,
                    add_rectangle(scene, 1, 1, add_absorber(scene), looking_up_z(0, 0, 0)), 2, 0);
        add_environment(scene, 0.5); /* behind the lamps: one program with the tests of the film */
        add_pinhole(scene, 24, 0.3, looking_down_z(0, 0, 2));
        options.last = 16;
        options.schedule = i == 2 ? MCV_SCHEDULE_STREAM : MCV_SCHEDULE_TILE;
        BUILD(mcv_render(scene, 0, &options, &films[i], &stats, &builder_error));
        mcv_scene_free(scene);
    }
    const double mean = mcv_film_mean(&films[0]);
    if (mean != 1 && mean != 2)
        fail_msg("two faces in one place: the mean is %g, neither 1 nor 2", mean);
    if (!same_bits(&films[0], &films[1])) fail_msg("faces without area are met");
    if (!same_bits(&films[1], &films[2]))
        fail_msg("the schedules see other faces of two in one place");
    for (int i = 0; i < 3; ++i) mcv_film_free(&films[i]);
}

/* --- light
 * ------------------------------------------------------------------------------------------------------
 */

/* π L sin²β falls on what lies under a parallel emitter, from cones that no cosine in float32 knows
 * to the half space. */
static void test_cones(void **state) {
    static const double angles[] = {1e-7, 1e-5, 1e-3, 0.1, 1, M_PI / 2};
    (void)state;
    for (int i = 0; i < 6; ++i) {
        mcv_scene *scene = mcv_scene_new("cone");
        mcv_render_stats stats;
        const double truth = 0.6 * 3 * pow(sin(angles[i]), 2);
        add_rectangle(scene, 0.02, 0.02, add_diffuse(scene, 0.6), looking_up_z(0, 0, 0));
        add_emitter(scene, MCV_EMITTER_PARALLEL,
                    add_rectangle(scene, 200, 200, add_absorber(scene), looking_down_z(0, 0, 0.1)),
                    3, angles[i]);
        add_pinhole(scene, 4, 0.001, looking_down_z(0, 0, 0.05));
        mcv_render_options options = mcv_render_defaults();
        mcv_film film;
        options.replicates = REPLICATES;
        options.last = 256;
        BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
        char what[64];
        snprintf(what, sizeof what, "half-angle %g", angles[i]);
        /* Of the half space the emitter's rim at 45° lacks (0.1/100)²; float32 rounds sin(β/2) and
         * its square. */
        expect_estimate(what, image_estimate(&film), truth, 0.01,
                        2e-6 + (angles[i] > 1.5 ? 1e-6 : 0));
        assert_int_equal(stats.nonfinite, 0);
        mcv_film_free(&film);
        mcv_scene_free(scene);
    }
}

/* Angles up to grazing and about the critical one: finite, and never more light than came. */
static void test_grazing(void **state) {
    mcv_scene *scene = mcv_scene_new("grazing");
    const uint32_t glass = add_glass(scene, 1.5, 0, 0);
    mcv_solid plate = element(1e4, (mcv_cap){.z = -0.5}, (mcv_cap){.z = 0.5});
    (void)state;
    add_solid(scene, &plate, glass, glass);
    static const double outside[] = {80, 89, 89.9, 89.99, 89.999, 90 - 1e-6};
    for (int reference = 0; reference < 2; ++reference) {
        for (int i = 0; i < 6; ++i) {
            const double a = outside[i] * M_PI / 180;
            mcv_vertex v[DEPTH + 1];
            const size_t n = trace_one(
                scene, reference, (mcv_trace_ray){{0, 0, -0.5 - 1e-6}, {sin(a), 0, cos(a)}}, v);
            if (outside[i] < 89.9999) assert_true(n >= 2);
            for (size_t k = 0; k < n; ++k)
                assert_true(v[k].transmittance >= 0 && v[k].transmittance <= 1);
        }
        for (int decade = 2; decade <= 8; ++decade)
            for (int side = -1; side <= 1; side += 2) {
                const double a = asin(1 / 1.5) + side * pow(10, -decade);
                mcv_vertex v[DEPTH + 1];
                const size_t n =
                    trace_one(scene, reference, (mcv_trace_ray){{0, 0, 0}, {sin(a), 0, cos(a)}}, v);
                assert_true(n >= 2);
                assert_true(v[1].transmittance >= 0 && v[1].transmittance <= 1);
                /* Float32's directions are off by some 1e-7. */
                if (reference || decade < 7)
                    assert_int_equal(v[1].event, side < 0 ? MCV_EVENT_REFRACT : MCV_EVENT_REFLECT);
            }
    }
    mcv_scene_free(scene);
}

/* Off the rays' way: meshes and exact surfaces are traced by one program. */
static void add_exact_beside(mcv_scene *scene, uint32_t material) {
    mcv_solid ball = sphere(0.01);
    ball.to_world = looking_down_z(0.9, 0.9, 0.5);
    add_solid(scene, &ball, material, material);
}

/* 1000 total reflections between the faces of a plate, a mesh or exact: the direction drifts by
 * less than 1e-5, in double 1e-12. */
static void test_many_reflections(void **state) {
    enum { REFLECTIONS = 1000 };
    const double angle = 50 * M_PI / 180, azimuth = 0.2;
    const mcv_trace_ray ray = {{-60, -12, 0.01},
                               {sin(angle) * cos(azimuth), sin(angle) * sin(azimuth), cos(angle)}};
    (void)state;
    for (int exact = 0; exact < 2; ++exact) {
        mcv_scene *scene = mcv_scene_new("plate");
        const uint32_t glass = add_glass(scene, 1.5, 0, 0);
        const mcv_solid plate = element(100, (mcv_cap){.z = -0.05}, (mcv_cap){.z = 0.05});
        if (exact)
            add_solid(scene, &plate, glass, glass);
        else
            add_box(scene, (const double[3]){100, 100, 0.05}, glass, unmoved);
        if (!exact) add_exact_beside(scene, glass);
        for (int reference = 0; reference < 2; ++reference) {
            mcv_render_options options = mcv_render_defaults();
            mcv_vertex *v = NULL;
            size_t count = 0;
            options.depth = REFLECTIONS;
            BUILD((reference ? mcv_reference_trace : mcv_trace)(scene, &ray, 1, &options, &v,
                                                                &count, &builder_error));
            assert_int_equal(count, REFLECTIONS + 1);
            for (size_t i = 1; i < count; ++i) assert_int_equal(v[i].event, MCV_EVENT_REFLECT);
            const double *d = v[REFLECTIONS].direction; /* an even number of reflections */
            const double drift =
                sqrt(pow(d[0] - ray.direction[0], 2) + pow(d[1] - ray.direction[1], 2) +
                     pow(d[2] - ray.direction[2], 2));
            print_message("  %s plate, %s: %.2g after %d reflections\n", exact ? "exact" : "mesh",
                          name_of(reference), drift, REFLECTIONS);
            if (!(drift <= (reference ? 1e-12 : 1e-5)))
                fail_msg("%s: the direction has drifted by %g", name_of(reference), drift);
            free(v);
        }
        mcv_scene_free(scene);
    }
}

/* A body of the index around it is not there: not a bit of a direction changes. */
static void test_no_step(void **state) {
    mcv_scene *scene = mcv_scene_new("no step");
    ref_random random = {3};
    (void)state;
    const uint32_t air = add_glass(scene, 1, 0, 0);
    add_sphere(scene, 0.5, 24, air, unmoved);
    add_exact_beside(scene, air);
    mcv_trace_ray rays[100];
    for (int i = 0; i < 100; ++i)
        rays[i] = (mcv_trace_ray){
            {0.6 * ref_random_unit(&random) - 0.3, 0.6 * ref_random_unit(&random) - 0.3, -2},
            {0.1 * ref_random_unit(&random), 0.1 * ref_random_unit(&random), 1}};
    const traced t = follow(scene, false, rays, 100);
    size_t met = 0;
    for (size_t i = 1; i < t.count; ++i) {
        if (t.vertices[i].index == 0 || t.vertices[i].event == MCV_EVENT_MISS) continue;
        assert_memory_equal(t.vertices[i].direction, t.vertices[i - 1].direction,
                            sizeof t.vertices[i].direction);
        assert_true(t.vertices[i].transmittance == 1);
        ++met;
    }
    assert_true(met > 150 && met % 2 == 0); /* some pass by */
    free(t.vertices);
    mcv_scene_free(scene);
}

/* --- the film
 * ---------------------------------------------------------------------------------------------------
 */

/* 2^24 and 2^26 equal values that float32 cannot hold exactly nor add: the mean is the value, to
 * the rounding of pairs of floats. */
static void test_many_equal_samples(void **state) {
    mcv_scene *scene = mcv_scene_new("many");
    (void)state;
    add_environment(scene, 0.1);
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 1, 1, add_absorber(scene), looking_up_z(0, 0, 1)), 1,
                0); /* not seen */
    add_pinhole(scene, 1, 1, looking_down_z(0, 0, 0));
    mcv_render_stats stats;
    mcv_film film = render_by(false, scene, 1 << 20, 4, &stats);
    const double mean = mcv_film_mean(&film);
    print_message("  2^22 samples of 0.1: off by %.2g\n", mean / (double)0.1F - 1);
    assert_true(fabs(mean / (double)0.1F - 1) <= 1e-12);
    mcv_film_free(&film);
    mcv_scene_free(scene);
    /* 2^30 values 1 ± u, as blocks' sums of 64 arrive: each addition rounds by 2^-53 of the sum at
     * most, over a tree of 24 levels. */
    enum { LEVELS = 24 };
    double tree[LEVELS + 1] = {0}, block[64];
    int filled[LEVELS + 1] = {0};
    for (int i = 0; i < 64; ++i) block[i] = i % 2 ? 1 + 0x1p-24 : 1 - 0x1p-24;
    for (uint32_t b = 0; b < 1u << LEVELS; ++b) {
        double sum = mcv_tree_sum(block, 64, 1);
        int level = 0;
        for (; filled[level]; ++level) {
            sum += tree[level];
            filled[level] = 0;
        }
        tree[level] = sum;
        filled[level] = 1;
    }
    assert_true(tree[LEVELS] == 0x1p30);
}

/* A light of 1e30 in a corner spoils no other pixel by a bit, and its own stay finite. */
static void test_firefly(void **state) {
    mcv_film films[2];
    mcv_render_stats stats;
    (void)state;
    for (int i = 0; i < 2; ++i) {
        mcv_scene *scene = mcv_scene_new("firefly");
        add_environment(scene, 1);
        add_emitter(
            scene, MCV_EMITTER_AREA,
            add_rectangle(scene, 4e-3, 4e-3, add_absorber(scene), looking_up_z(0.47, 0.47, 0)),
            i ? 1e30 : 1, 0);
        add_pinhole(scene, 16, 1, looking_down_z(0, 0, 1));
        films[i] = render_by(false, scene, 1024, 4, &stats);
        assert_int_equal(stats.nonfinite, 0);
        mcv_scene_free(scene);
    }
    int larger = 0;
    for (size_t i = 0; i < (size_t)16 * 16 * 4; ++i) {
        assert_true(isfinite(films[1].sums[i]));
        larger += films[1].sums[i] != films[0].sums[i];
    }
    print_message("  a light of 1e30: %d values of %d hold it\n", larger, 16 * 16 * 4);
    assert_in_range(larger, 1, 4);
    for (int i = 0; i < 2; ++i) mcv_film_free(&films[i]);
}

/* What float32 cannot hold is told, not rendered; single values that are too large are left out and
 * counted. */
static void test_not_finite(void **state) {
    (void)state;
    for (int reference = 0; reference < 2; ++reference) {
        mcv_scene *scene = mcv_scene_new("not finite");
        mcv_render_options options = mcv_render_defaults();
        mcv_render_stats stats;
        mcv_film film;
        mcv_error error = {""};
        /* The most power there may be, from less than a hair: 3 x 10^39 W/(m² sr). */
        mcv_emitter emitter = {
            .name = (char *)"hair", .type = MCV_EMITTER_AREA, .texture = MCV_NONE};
        emitter.instance =
            add_rectangle(scene, 1e-5, 1e-5, add_absorber(scene), looking_up_z(0, 0, 0));
        mcv_params_set_defaults(mcv_emitter_table(emitter.type), &emitter.as);
        for (int k = 0; k < 3; ++k) emitter.as.area.power[k] = 1e30;
        BUILD(mcv_scene_add_emitter(scene, &emitter, &builder_error));
        add_environment(scene, 1);
        add_pinhole(scene, 8, 1e-5, looking_down_z(0, 0, 1));
        options.last = 4;
        const mcv_result result = (reference ? mcv_reference_render : mcv_render)(
            scene, 0, &options, &film, &stats, &error);
        assert_int_equal(result, MCV_FAILED);
        assert_null(film.sums);
        if (!strstr(error.text, "not finite") ||
            !strstr(error.text, "not finite, more than one in a million"))
            fail_msg("%s", error.text);
        assert_true(stats.nonfinite > 0);
        mcv_scene_free(scene);
    }
    /* One in 10^7 is counted, and the render goes on. */
    mcv_scene *scene = mcv_scene_new("few");
    const mcv_render_stats few = {.paths = 10000000, .nonfinite = 1},
                           many = {.paths = 10000000, .nonfinite = 11};
    mcv_error error = {""};
    add_pinhole(scene, 8, 1, looking_down_z(0, 0, 1));
    assert_int_equal(mcv_render_check_finite(scene, 0, &few, &error), MCV_OK);
    assert_int_equal(mcv_render_check_finite(scene, 0, &many, &error), MCV_FAILED);
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest bodies[] = {cmocka_unit_test(test_fan), cmocka_unit_test(test_bodies)};
    const struct CMUnitTest scales[] = {
        cmocka_unit_test(test_powers_of_two_change_no_bit),
        cmocka_unit_test(test_translations_change_no_bit),
        cmocka_unit_test(test_other_scales_and_places),
    };
    const struct CMUnitTest light[] = {
        cmocka_unit_test(test_degenerate_and_double_faces),
        cmocka_unit_test(test_cones),
        cmocka_unit_test(test_grazing),
        cmocka_unit_test(test_many_reflections),
        cmocka_unit_test(test_no_step),
        cmocka_unit_test(test_many_equal_samples),
        cmocka_unit_test(test_firefly),
        cmocka_unit_test(test_not_finite),
    };
    switch (PART) {
    case PART_BODIES:
        return cmocka_run_group_tests(bodies, NULL, NULL);
    case PART_SCALES:
        return cmocka_run_group_tests(scales, NULL, NULL);
    default:
        return cmocka_run_group_tests(light, NULL, NULL);
    }
}
