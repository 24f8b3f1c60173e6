/* SPDX-License-Identifier: Apache-2.0 */
/* Rendering on the device: truths that every image must keep. */
#include "estimates.h"
#include "peer_scenes.h"

#include "render/render.h"

/* test_render_slow.c sets it: all cases, of which the quick test has those that no others stand
 * for. */
#ifndef SLOW
#define SLOW 0
#endif

/* Image mean of one channel, and its standard error over the replicates. */
typedef struct mean_value {
    double mean, error;
} mean_value;

static mean_value mean_of(const mcv_film *film, uint32_t channel) {
    const size_t pixels = (size_t)film->width * film->height;
    double sum = 0;
    double squares = 0;
    for (uint32_t r = 0; r < film->replicates; ++r) {
        double total = 0;
        for (size_t i = 0; i < pixels; ++i)
            total += film->sums[((size_t)r * film->channels + channel) * pixels + i];
        total /= (double)pixels * (double)film->samples;
        sum += total;
        squares += total * total;
    }
    const double n = film->replicates;
    return (mean_value){sum / n, n > 1 ? sqrt(fmax(0, squares / n - sum / n * sum / n) / (n - 1))
                                       : INFINITY};
}

static mcv_render_stats last_stats;

static mean_value render_mean(const mcv_scene *scene, uint32_t replicates, uint32_t samples,
                              uint32_t depth) {
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    mcv_error error = {""};
    options.replicates = replicates;
    options.last = samples;
    options.depth = depth;
    if (render_again(scene, 0, &options, &film, &last_stats, &error) != MCV_OK)
        fail_msg("%s", error.text);
    const mean_value mean = mean_of(&film, 0);
    mcv_film_free(&film);
    return mean;
}

/* Sums of exactly equal values: nothing but the rounding of one division per pixel. */
static void test_environment_alone_is_exact(void **state) {
    mcv_scene *scene = mcv_scene_new("environment");
    (void)state;
    add_environment(scene, 0.75);
    add_pinhole(scene, 12, 1, looking_down_z(0, 0, 0));
    const mean_value m = render_mean(scene, 4, 8, 4);
    assert_true(fabs(m.mean - 0.75) <= 1e-15);
    assert_int_equal(last_stats.paths, 12 * 12 * 4 * 8);
    assert_int_equal(last_stats.nonfinite, 0);
    mcv_scene_free(scene);
}

/* T15: a lossless body of any shape vanishes in a uniform surrounding; the paths that the depth
 * limit cuts are all that is missing. */
static void test_glass_furnace(void **state) {
    mcv_scene *scene = mcv_scene_new("furnace");
    (void)state;
    add_environment(scene, 1);
    add_sphere(scene, 0.5, 24, add_glass(scene, 1.5, 0, 0), mcv_transform_identity());
    add_pinhole(scene, 32, 0.5, looking_down_z(0, 0, 3));
    const mean_value m = render_mean(scene, 4, 64, 100);
    print_message("furnace: mean - 1 = %.3g, lost %.3g, unmatched %llu\n", m.mean - 1,
                  last_stats.lost_energy, (unsigned long long)last_stats.unmatched);
    /* Every finished path brings 1/n² n² of the vacuum: the mean misses just the cut paths. */
    assert_true(fabs(m.mean + last_stats.lost_energy - 1) <= 1e-6);
    assert_int_equal(last_stats.unmatched, 0);
    mcv_scene_free(scene);
}

/* A sensor inside glass sees n² L: all of a uniform surrounding, whichever way a path takes out of
 * the body. */
static void test_sensor_in_glass(void **state) {
    mcv_scene *scene = mcv_scene_new("sensor in glass");
    (void)state;
    add_environment(scene, 1);
    add_sphere(scene, 0.5, 24, add_glass(scene, 1.5, 0, 0), mcv_transform_identity());
    add_sphere(scene, 0.2, 16, add_glass(scene, 2, 0, 1), mcv_transform_identity());
    add_pinhole(scene, 16, 1.5, looking_down_z(0.05, 0.02, 0.03));
    const mean_value m = render_mean(scene, 4, 64, 1000);
    print_message("sensor in glass: mean - 4 = %.3g, lost %.3g\n", m.mean - 4,
                  last_stats.lost_energy);
    /* As above, times n² = 4 of the inner body. */
    assert_true(fabs(m.mean / 4 + last_stats.lost_energy - 1) <= 1e-6);
    assert_int_equal(last_stats.unmatched, 0);
    mcv_scene_free(scene);
}

/* T19: a closed diffuse box that emits: L = Le/(1 - ρ). */
static void test_diffuse_furnace(void **state) {
    mcv_scene *scene = mcv_scene_new("closed box");
    const double half[3] = {1, 1.5, 2};
    (void)state;
    for (int k = 0; k < 3; ++k) {
        for (int side = -1; side <= 1; side += 2) {
            double at[3] = {0, 0, 0};
            double forward[3] = {0, 0, 0};
            double up[3] = {0, 0, 0};
            at[k] = side * half[k];
            forward[k] = -side;
            up[(k + 1) % 3] = 1;
            const mcv_transform placed = looking(at, forward, up);
            /* right = forward x up lies along axis k + 2 */
            const uint32_t wall = add_rectangle(scene, 2 * half[(k + 2) % 3], 2 * half[(k + 1) % 3],
                                                add_diffuse(scene, 0.5), placed);
            add_emitter(scene, MCV_EMITTER_AREA, wall, 0.5, 0);
        }
    }
    add_pinhole(scene, 16, 1, looking_down_z(0.1, 0.2, 0.3));
    const mean_value m = render_mean(scene, 16, 64, 64);
    print_message("diffuse furnace: mean %.6f ± %.2g, expected 1\n", m.mean, m.error);
    /* 16 replicates, Student's t with 15 degrees of freedom: 6.1 standard errors happen with
     * probability 2e-5. */
    assert_true(m.error < 0.003);
    assert_true(fabs(m.mean - 1) <= 6.1 * m.error + 1e-6);
    mcv_scene_free(scene);
}

/* Same bits */

/* A scene that uses most elements: glass with absorption before a lit diffuse wall, two kinds of
 * light, a lamp that is no rectangle, a mirror, something black. */
static mcv_scene *mixed_scene(uint32_t rings) {
    mcv_scene *scene = mcv_scene_new("mixed");
    const double box[3] = {0.2, 0.15, 0.1};
    add_sphere(scene, 0.3, rings, add_glass(scene, 1.5, 2, 0), mcv_transform_identity());
    add_sphere(scene, 0.1, 8, add_glass(scene, 1, 0, 1), mcv_transform_identity());
    add_rectangle(scene, 2, 2, add_diffuse(scene, 0.6), looking_up_z(0, 0, -0.5));
    add_box(scene, box, add_material(scene, MCV_MATERIAL_MIRROR, NULL),
            looking_down_z(0.5, 0.1, -0.2));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.3, 0.3, add_absorber(scene), looking_down_z(0.4, 0.4, 1)), 3,
                0);
    add_emitter(scene, MCV_EMITTER_PARALLEL,
                add_rectangle(scene, 0.5, 0.5, add_absorber(scene), looking_down_z(-0.3, 0, 1)),
                100, 0.05);
    add_emitter(scene, MCV_EMITTER_AREA,
                add_sphere(scene, 0.1, 8, add_absorber(scene), looking_down_z(-0.4, -0.3, 0.1)), 1,
                0);
    add_box(scene, box, add_absorber(scene), looking_down_z(-0.4, 0.4, -0.3));
    add_environment(scene, 0.1);
    add_pinhole(scene, 20, 0.9, looking_down_z(0.05, 0, 1.5));
    return scene;
}

static mcv_film render_film(const mcv_scene *scene, uint32_t schedule, uint32_t slice,
                            uint32_t sampler, uint64_t first, uint64_t last) {
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    mcv_error error = {""};
    options.schedule = schedule;
    options.slice = slice;
    options.sampler = sampler;
    options.first = first;
    options.last = last;
    if (render_again(scene, 0, &options, &film, &last_stats, &error) != MCV_OK)
        fail_msg("%s", error.text);
    return film;
}

static void expect_equal_bits(const mcv_film *a, const mcv_film *b, const char *what) {
    const size_t values = (size_t)a->width * a->height * a->channels * a->replicates;
    assert_int_equal(a->samples, b->samples);
    for (size_t i = 0; i < values; ++i) {
        if (memcmp(&a->sums[i], &b->sums[i], sizeof(double)) != 0) {
            fail_msg("%s: sum %zu is %.17g against %.17g", what, i, a->sums[i], b->sums[i]);
        }
    }
}

/* Both schedules, several slice sizes, and sample ranges merged give the same bits, with blocks of
 * samples below and above MCV_BLOCK. */
static void test_same_bits(void **state) {
    mcv_scene *scene = mixed_scene(16);
    (void)state;
    for (uint32_t sampler = MCV_SAMPLER_SOBOL;
         sampler <= (SLOW ? MCV_SAMPLER_RANDOM : MCV_SAMPLER_SOBOL); ++sampler) {
        for (uint32_t samples = 16; samples <= 256; samples *= 16) {
            mcv_film tile = render_film(scene, MCV_SCHEDULE_TILE, 1024, sampler, 0, samples);
            const mcv_render_stats tile_stats = last_stats;
            static const uint32_t slices[] = {192, 64,
                                              256}; /* test_adaptive.c has one in the quick tests */
            for (int i = 0; i < (SLOW ? 3 : 0); ++i) {
                mcv_film other =
                    render_film(scene, MCV_SCHEDULE_TILE, slices[i], sampler, 0, samples);
                expect_equal_bits(&tile, &other, "slice size");
                mcv_film_free(&other);
            }
            mcv_film stream = render_film(scene, MCV_SCHEDULE_STREAM, 0, sampler, 0, samples);
            expect_equal_bits(&tile, &stream, "schedule");
            assert_int_equal(last_stats.paths, tile_stats.paths);
            assert_int_equal(last_stats.rays, tile_stats.rays);
            assert_int_equal(last_stats.shadow_rays, tile_stats.shadow_rays);
            assert_int_equal(last_stats.depth_cut, tile_stats.depth_cut);
            assert_true(last_stats.lost_energy == tile_stats.lost_energy);
            assert_int_equal(last_stats.unmatched, 0);
            assert_int_equal(last_stats.nonfinite, 0);

            mcv_film first = render_film(scene, MCV_SCHEDULE_TILE, 1024, sampler, 0, samples / 2);
            mcv_film second =
                render_film(scene, MCV_SCHEDULE_STREAM, 0, sampler, samples / 2, samples);
            BUILD(mcv_film_merge(&first, &second, &builder_error));
            expect_equal_bits(&tile, &first, "samples split in two and merged");
            mcv_film_free(&first);
            mcv_film_free(&second);
            mcv_film_free(&stream);
            mcv_film_free(&tile);
        }
    }
    mcv_scene_free(scene);
}

static void expect_same_schedules(const mcv_scene *scene, const char *what) {
    mcv_film tile = render_film(scene, MCV_SCHEDULE_TILE, 0, MCV_SAMPLER_SOBOL, 0, 64);
    mcv_film stream = render_film(scene, MCV_SCHEDULE_STREAM, 0, MCV_SAMPLER_SOBOL, 0, 64);
    expect_equal_bits(&tile, &stream, what);
    mcv_film_free(&stream);
    mcv_film_free(&tile);
}

/* What is known of few triangles, exact surfaces and instances is looked up. */
static void test_few_triangles_have_the_same_bits(void **state) {
    static const char *const names[] = {"area", "rough glass", "opening"};
    (void)state;
    for (size_t i = 0; i < (SLOW ? sizeof names / sizeof names[0] : 1); ++i) {
        mcv_scene *scene = make_peer_scene(names[i], 24, true, NULL);
        expect_same_schedules(scene, names[i]);
        mcv_scene_free(scene);
    }
}

/* Paths are sorted by many emitters, which are met one by one. */
static void test_many_lamps_have_the_same_bits(void **state) {
    mcv_scene *scene = mcv_scene_new("lamps");
    const uint32_t grey = add_diffuse(scene, 0.5), black = add_absorber(scene);
    (void)state;
    add_rectangle(scene, 2, 2, grey, looking_up_z(0, 0, 0));
    add_ball(scene, 0.2, 0.2, grey);
    for (int i = 0; i < 25; ++i) {
        const mcv_transform at =
            looking_down_z(0.3 * (i % 5) - 0.6, 0.3 * floor(i / 5.0) - 0.6, 0.9);
        add_emitter(scene, i % 2 ? MCV_EMITTER_PARALLEL : MCV_EMITTER_AREA,
                    add_rectangle(scene, 0.2, 0.1, black, at), 1 + i, 0.02);
    }
    add_pinhole(scene, 24, 0.5, looking_down_z(0, 0, 1.5));
    expect_same_schedules(scene, "many lamps");
    mcv_scene_free(scene);
}

/* However many rounds a time makes, each replicate of each pixel has the same samples, and no value
 * of them is lost. */
static void test_time_makes_whole_rounds(void **state) {
    mcv_scene *scene = mcv_scene_new("environment");
    mcv_render_options options = mcv_render_defaults();
    mcv_film film;
    (void)state;
    add_environment(scene, 0.75);
    add_pinhole(scene, 12, 1, looking_down_z(0, 0, 0));
    options.depth = 4;
    options.seconds = 1;
    BUILD(render_again(scene, 0, &options, &film, &last_stats, &builder_error));
    assert_true(film.samples > 0);
    assert_true(last_stats.paths == 12 * 12 * 4 * film.samples);
    const mean_value m = mean_of(&film, 0);
    assert_true(fabs(m.mean - 0.75) <= 1e-15);
    print_message("%llu samples in %.2f s\n", (unsigned long long)film.samples,
                  last_stats.seconds_build + last_stats.seconds_compile +
                      last_stats.seconds_render);
    mcv_film_free(&film);
    mcv_scene_free(scene);
}

static bool stop_at_once(void *user, double fraction, double seconds, double error) {
    (void)user, (void)fraction, (void)seconds, (void)error;
    return false;
}

/* A stopped render of a later range holds its first samples, with the bits that they have when
 * rendered alone. */
static void test_later_range_can_be_stopped(void **state) {
    mcv_scene *scene = mixed_scene(16);
    mcv_render_options options = mcv_render_defaults();
    mcv_film stopped;
    (void)state;
    options.first = 1 << 14;
    options.last = 1 << 15;
    options.progress = stop_at_once;
    BUILD(mcv_render(scene, 0, &options, &stopped, &last_stats, &builder_error));
    assert_true(last_stats.interrupted);
    if (stopped.samples >= 64)
        fail_msg("%llu samples were rendered after the stop", (unsigned long long)stopped.samples);
    mcv_film alone = render_film(scene, MCV_SCHEDULE_TILE, 0, MCV_SAMPLER_SOBOL, options.first,
                                 options.first + stopped.samples);
    expect_equal_bits(&alone, &stopped, "stopped range");
    mcv_film_free(&alone);
    mcv_film_free(&stopped);
    mcv_scene_free(scene);
}

/* A range that several rounds bring, of samples that adaptive sampling would not reach, up to the
 * last one of all. */
static void test_latest_ranges_are_whole(void **state) {
    static const uint64_t firsts[] = {1u << 28, 0x80000000u - 512};
    mcv_scene *scene = mixed_scene(16);
    (void)state;
    for (size_t i = 0; i < sizeof firsts / sizeof firsts[0]; ++i) {
        mcv_film film =
            render_film(scene, MCV_SCHEDULE_AUTO, 0, MCV_SAMPLER_SOBOL, firsts[i], firsts[i] + 512);
        if (film.samples != 512)
            fail_msg("from %llu: %llu samples", (unsigned long long)firsts[i],
                     (unsigned long long)film.samples);
        mcv_film_free(&film);
    }
    mcv_scene_free(scene);
}

/* Some 4 rings² triangles: rays take turns in the tile schedule, which the stream schedule never
 * lets them. */
static void test_turns_change_no_bit(void **state) {
    mcv_scene *scene = mixed_scene(240);
    (void)state;
    mcv_film stream = render_film(scene, MCV_SCHEDULE_STREAM, 0, MCV_SAMPLER_SOBOL, 0, 16);
    for (uint32_t slice = 64; slice <= (SLOW ? 256 : 64); slice *= 4) {
        mcv_film tile = render_film(scene, MCV_SCHEDULE_TILE, slice, MCV_SAMPLER_SOBOL, 0, 16);
        expect_equal_bits(&stream, &tile, "rays that take turns");
        mcv_film_free(&tile);
    }
    mcv_film_free(&stream);
    mcv_scene_free(scene);
}

/* A path ends by itself long before it meets a million surfaces: the limit must not cost the
 * launches of as many stages. */
static void test_high_depth_limit_is_cheap(void **state) {
    mcv_scene *scene = mixed_scene(16);
    mcv_film films[2];
    (void)state;
    for (int i = 0; i < 2; ++i) {
        mcv_render_options options = mcv_render_defaults();
        options.schedule = i ? MCV_SCHEDULE_STREAM : MCV_SCHEDULE_TILE;
        options.last = 1;
        options.depth = 1000000;
        BUILD(render_again(scene, 0, &options, &films[i], &last_stats, &builder_error));
    }
    expect_equal_bits(&films[0], &films[1], "schedule");
    assert_int_equal(last_stats.depth_cut, 0);
    /* One pass of some 10^2 launches; 3 x 10^6 of them take half a minute at the least. */
    print_message("depth limit 10^6: %.2f s\n", last_stats.seconds_render);
    assert_true(last_stats.seconds_render < 10);
    mcv_film_free(&films[0]);
    mcv_film_free(&films[1]);
    mcv_scene_free(scene);
}

/* What the options promise to refuse, with no image made. */
static void test_sample_ranges_are_checked(void **state) {
    static const uint64_t ranges[][2] = {{4, 0}, {4, 4}, {8, 4}, {0, 3}, {2, 6}, {0, 1ull << 32}};
    mcv_scene *scene = mcv_scene_new("ranges");
    (void)state;
    add_environment(scene, 1);
    add_pinhole(scene, 2, 1, looking_down_z(0, 0, 0));
    for (size_t i = 0; i < sizeof ranges / sizeof ranges[0]; ++i) {
        mcv_render_options options = mcv_render_defaults();
        mcv_film film;
        options.first = ranges[i][0];
        options.last = ranges[i][1];
        options.error = 0.5;
        const mcv_result result =
            mcv_render(scene, 0, &options, &film, &last_stats, &builder_error);
        if (result != MCV_USAGE || film.sums)
            fail_msg("samples %llu:%llu: result %d", (unsigned long long)ranges[i][0],
                     (unsigned long long)ranges[i][1], result);
    }
    mcv_scene_free(scene);
}

/*
 * The sum of 64 samples, which a launch adds up in pairs of floats, against those of the samples
 * alone in double: 2^-46 and the roundings of double apart. Plain floats are off by some 2^-24. A
 * ball in a uniform sky: values differ from sample to sample.
 */
static void test_sums_keep_their_digits(void **state) {
    mcv_scene *scene = mcv_scene_new("sums");
    double worst = 0, plain = 0;
    (void)state;
    add_sphere(scene, 0.3, 16, add_glass(scene, 1.5, 0, 0), mcv_transform_identity());
    add_environment(scene, 0.1);
    add_pinhole(scene, 4, 0.9, looking_down_z(0.05, 0, 1.5));
    mcv_film whole = render_film(scene, MCV_SCHEDULE_TILE, 0, MCV_SAMPLER_SOBOL, 0, 64);
    const size_t values = (size_t)whole.width * whole.height * whole.replicates;
    double *sums = calloc(values, sizeof *sums);
    float *floats = calloc(values, sizeof *floats);
    assert_non_null(sums);
    assert_non_null(floats);
    for (uint64_t first = 0; first < 64; ++first) {
        mcv_film one =
            render_film(scene, MCV_SCHEDULE_TILE, 0, MCV_SAMPLER_SOBOL, first, first + 1);
        for (size_t i = 0; i < values; ++i) sums[i] += one.sums[i], floats[i] += (float)one.sums[i];
        mcv_film_free(&one);
    }
    for (size_t i = 0; i < values; ++i) {
        worst = fmax(worst, fabs(whole.sums[i] / sums[i] - 1));
        plain = fmax(plain, fabs((double)floats[i] / sums[i] - 1));
    }
    print_message("sums of 64: off by %.2g, plain floats by %.2g\n", worst, plain);
    assert_true(worst <= 0x1p-42);
    assert_true(plain > 0x1p-26); /* else the test says nothing */
    free(sums);
    free(floats);
    mcv_film_free(&whole);
    mcv_scene_free(scene);
}

#ifndef FURNACES
#define FURNACES 0
#endif

int main(void) {
    const struct CMUnitTest furnaces[] = {
        cmocka_unit_test(test_environment_alone_is_exact),
        cmocka_unit_test(test_time_makes_whole_rounds),
        cmocka_unit_test(test_glass_furnace),
        cmocka_unit_test(test_sensor_in_glass),
        cmocka_unit_test(test_diffuse_furnace),
        cmocka_unit_test(test_sums_keep_their_digits),
    };
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_later_range_can_be_stopped),
        cmocka_unit_test(test_latest_ranges_are_whole),
        cmocka_unit_test(test_high_depth_limit_is_cheap),
        cmocka_unit_test(test_sample_ranges_are_checked),
    };
    const struct CMUnitTest long_tests[] = {
        cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_few_triangles_have_the_same_bits),
        cmocka_unit_test(test_many_lamps_have_the_same_bits),
        cmocka_unit_test(test_turns_change_no_bit),
    };
    if (FURNACES) return cmocka_run_group_tests(furnaces, NULL, NULL);
    return SLOW ? cmocka_run_group_tests(long_tests, NULL, NULL)
                : cmocka_run_group_tests(tests, NULL, NULL);
}
