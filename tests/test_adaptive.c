/* SPDX-License-Identifier: Apache-2.0 */
/* Adaptive sampling: where the samples go, that the image and its error bars stay right, and what it brings. */
#include "convergence.h"
#include "scene_builder.h"

#include "analysis/compare.h"
#include "render/adaptive.h"

enum { PIXELS = 36, SEEDS = 64, GROUP = 8, SAMPLES = 32, REPLICATES = 4 };

/* A diffuse ball under a panel, one ninth of a black picture; or a light field camera's view of a ball of glass with what it focuses. */
static mcv_scene *make_scene(bool caustic) {
    mcv_scene *scene = mcv_scene_new("adaptive");
    add_sphere(scene, 0.5, 16, caustic ? add_glass(scene, 1.5, 0, 1) : add_diffuse(scene, 0.5), looking_down_z(0.3, 0.2, 0));
    const uint32_t panel = add_rectangle(scene, 2, 2, add_absorber(scene), looking_down_z(0, 0, 4));
    if (caustic) add_rectangle(scene, 3, 3, add_diffuse(scene, 0.5), looking_down_z(0, 0, -1));
    mcv_emitter emitter = {.name = (char *)"panel", .type = MCV_EMITTER_PARALLEL, .instance = panel, .texture = MCV_NONE};
    mcv_params_set_defaults(mcv_emitter_table(MCV_EMITTER_PARALLEL), &emitter.as);
    emitter.as.parallel.halfAngle = 0.3;
    for (int c = 0; c < 3; ++c) emitter.as.parallel.radiance[c] = 1;
    BUILD(mcv_scene_add_emitter(scene, &emitter, &builder_error));
    add_pinhole(scene, PIXELS, 1, looking_down_z(0.1, 0, 3));
    return scene;
}

static mcv_render_options options_of(uint32_t seed) {
    mcv_render_options options = mcv_render_defaults();
    options.replicates = REPLICATES;
    options.last = SAMPLES;
    options.seed = seed;
    options.adaptive = true;
    return options;
}

static mcv_film render(mcv_renderer *renderer, const mcv_scene *scene, mcv_render_options options, mcv_render_stats *stats) {
    mcv_film film;
    BUILD(mcv_renderer_render(renderer, scene, 0, &options, &film, stats, &builder_error));
    return film;
}

/* --- where the samples go ----------------------------------------------------------------------------------------- */

/* A film of 4 x 3 tiles and a bit, whose replicates differ by ± the root of `variances` (of the mean, per tile). */
static mcv_film film_of(const double variances[20]) {
    mcv_film film;
    BUILD(mcv_film_new(&film, 33, 26, 1, 2, &builder_error));
    assert_int_equal(mcv_film_tiles(&film), 20);
    film.samples = 4;
    for (uint32_t r = 0; r < 2; ++r)
        for (uint32_t y = 0; y < 26; ++y)
            for (uint32_t x = 0; x < 33; ++x)
                film.sums[(r * 26 + y) * 33 + x] = 4 * (1 + (r ? 1 : -1) * sqrt(variances[y / 8 * 5 + x / 8]));
    return film;
}

static void test_flat_is_uniform(void **state) {
    double variances[20];
    signed char levels[20];
    double gain;
    (void)state;
    for (int black = 0; black < 2; ++black) {
        for (int i = 0; i < 20; ++i) variances[i] = black ? 0 : 0.01;
        mcv_film film = film_of(variances);
        BUILD(mcv_allocate_samples(&film, 1, 1, levels, &gain, &builder_error));
        for (int i = 0; i < 20; ++i)
            if (levels[i] != 0) fail_msg("tile %d of a flat film: level %d", i, levels[i]);
        if (fabs(gain - 1) > 1e-12) fail_msg("a flat film gains %.15g", gain);
        mcv_film_free(&film);
    }
}

/*
 * One tile of a hundredfold variance among quiet ones: with fall 1 it would take ten times their samples, less what the tenth of the
 * neighbours' mean takes and gives: 90 + (100 + 8)/9/10 = 91.2 of 1 far from it is 9.5 times, which is 8 or 16 in powers of two.
 */
static void test_noisy_tile(void **state) {
    double variances[20], gain;
    signed char levels[20];
    (void)state;
    for (int i = 0; i < 20; ++i) variances[i] = i == 6 ? 1 : 0.01;
    for (double budget = 0.5; budget <= 1; budget += 0.25) {
        mcv_film film = film_of(variances);
        BUILD(mcv_allocate_samples(&film, 1, budget, levels, &gain, &builder_error));
        if (levels[6] - levels[19] != 3 && levels[6] - levels[19] != 4) fail_msg("levels %d and %d", levels[6], levels[19]);
        film.levels = levels;
        const double samples = mcv_film_mean_samples(&film) / ((double)film.samples * film.replicates);
        /* All levels but those of the eight neighbours are the same: less would be less than half of what was allowed. */
        if (!(samples <= budget && samples > budget / 2)) fail_msg("%g of the samples: at most %g", samples, budget);
        if (!(gain > 1)) fail_msg("gain %g", gain);
        film.levels = NULL;
        mcv_film_free(&film);
    }
}

/* --- renders -------------------------------------------------------------------------------------------------------- */

static void test_same_bits(void **state) {
    mcv_scene *scene = make_scene(false);
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_film first = {0};
    mcv_render_stats stats;
    (void)state;
    for (int i = 0; i < 3; ++i) {
        mcv_render_options options = options_of(5);
        options.schedule = i == 2 ? MCV_SCHEDULE_STREAM : MCV_SCHEDULE_TILE;
        options.slice = i == 1 ? 64 : 0;
        mcv_film film = render(renderer, scene, options, &stats);
        const size_t values = film_values(&film) * REPLICATES;
        assert_non_null(film.levels);
        if (i > 0 && (memcmp(film.levels, first.levels, mcv_film_tiles(&film)) != 0 ||
                      memcmp(film.sums, first.sums, values * sizeof *film.sums) != 0))
            fail_msg("%s: other bits", i == 1 ? "slices of 64" : "stream");
        /* What was asked for, the film that was thrown away included: four samples of it, for SAMPLES in powers of two. */
        const double samples = mcv_film_mean_samples(&film) + 4 * REPLICATES;
        if (samples > SAMPLES * REPLICATES) fail_msg("%g samples on the average, at most %d", samples, SAMPLES * REPLICATES);
        double paths = 4 * REPLICATES * PIXELS * PIXELS;
        for (uint32_t y = 0; y < PIXELS; ++y)
            for (uint32_t x = 0; x < PIXELS; ++x) paths += mcv_film_samples_at(&film, x, y);
        if (paths != (double)stats.paths) fail_msg("%llu paths, not %.0f", (unsigned long long)stats.paths, paths);
        if (i > 0) mcv_film_free(&film);
        if (i == 0) first = film;
    }
    mcv_film_free(&first);
    mcv_renderer_free(renderer);
    mcv_scene_free(scene);
}

static double variance_of(const mcv_film *film) {
    const double error = mcv_film_relative_error(film) * mcv_film_mean(film);
    return error * error;
}

/* The mean image of each of so many seeds as one replicate of a film; what their error bars tell is added to variances[seed]. */
static mcv_film render_seeds(const mcv_scene *scene, uint32_t first, uint32_t count, bool caustic, double *variances) {
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_film means;
    BUILD(mcv_film_new(&means, PIXELS, PIXELS, mcv_scene_channels(scene), count, &builder_error));
    const size_t values = film_values(&means);
    means.samples = 1;
    for (uint32_t i = 0; i < count; ++i) {
        mcv_render_stats stats;
        mcv_film film = render(renderer, scene, options_of(first + i), &stats);
        if (!film.levels) fail_msg("seed %u: not adaptive", first + i);
        if ((strstr(stats.features, "light-tracing") != NULL) != caustic) fail_msg("features: %s", stats.features);
        for (size_t v = 0; v < values; ++v) means.sums[i * values + v] = film_value(&film, v);
        variances[i] = variance_of(&film);
        mcv_film_free(&film);
    }
    mcv_renderer_free(renderer);
    return means;
}

/* The same of one long plain render. */
static mcv_film render_plain(const mcv_scene *scene) {
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_render_options options = options_of(SEEDS);
    mcv_render_stats stats;
    options.adaptive = false;
    options.replicates = SEEDS;
    mcv_film film = render(renderer, scene, options, &stats);
    mcv_renderer_free(renderer);
    return film;
}

/* Replicates first … first + GROUP - 1 alone. */
static mcv_film group_of(const mcv_film *film, uint32_t first) {
    mcv_film group;
    const size_t values = film_values(film);
    BUILD(mcv_film_new(&group, film->width, film->height, film->channels, GROUP, &builder_error));
    memcpy(group.sums, film->sums + first * values, GROUP * values * sizeof *group.sums);
    group.samples = film->samples;
    return group;
}

/*
 * The means of many seeds are compared with a plain render. And the variance that error bars tell is that between the seeds: their
 * difference in eight groups of eight, by Student's t with 7 degrees of freedom (5.4: one in a thousand).
 */
static void check_unbiased(const char *name, bool caustic) {
    mcv_scene *scene = make_scene(caustic);
    double told[SEEDS], differences[SEEDS / GROUP], mean = 0;
    mcv_comparison comparison;
    mcv_film means = render_seeds(scene, 0, SEEDS, caustic, told);
    mcv_film plain = render_plain(scene);
    BUILD(mcv_compare_films(&means, &plain, &comparison, &builder_error));
    if (comparison.different) fail_msg("%s: %s", name, comparison.reason);
    for (uint32_t first = 0; first < SEEDS; first += GROUP) {
        mcv_film group = group_of(&means, first);
        double *difference = differences + first / GROUP;
        *difference = -variance_of(&group) * GROUP;
        for (uint32_t i = first; i < first + GROUP; ++i) *difference += told[i] / GROUP;
        for (uint32_t i = first; i < first + GROUP; ++i) mean += told[i] / SEEDS;
        mcv_film_free(&group);
    }
    const mcv_estimate difference = mcv_estimate_replicates(differences, SEEDS / GROUP);
    if (!(fabs(difference.mean) <= 5.4 * sqrt(difference.variance)))
        fail_msg("%s: the error bars' variance is off by %.3g ± %.3g of %.3g", name, difference.mean, sqrt(difference.variance), mean);
    /* Most of the picture has little noise. */
    const double alike = variance_of(&plain) * SEEDS / REPLICATES;
    printf("%s: %s; variance %.3g, without %.3g\n", name, comparison.reason, mean, alike);
    if (!(mean < alike / 2)) fail_msg("%s: variance %.3g, without %.3g", name, mean, alike);
    mcv_film_free(&means);
    mcv_film_free(&plain);
    mcv_scene_free(scene);
}

static void test_unbiased(void **state) {
    (void)state;
    check_unbiased("ball", false);
    check_unbiased("caustic", true);
}

/* To an error: stops by itself; where it does not pay, the bits are those without. */
static void test_to_an_error(void **state) {
    mcv_scene *scene = make_scene(false);
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_render_stats stats, plain_stats;
    (void)state;
    for (int easy = 0; easy < 2; ++easy) {
        mcv_render_options options = options_of(3);
        options.last = 0;
        options.error = easy ? 0.5 : 0.002;
        mcv_film film = render(renderer, scene, options, &stats);
        options.adaptive = false;
        mcv_film plain = render(renderer, scene, options, &plain_stats);
        assert_true(mcv_film_relative_error(&film) <= options.error);
        if (easy && (film.levels || memcmp(film.sums, plain.sums, film_values(&film) * REPLICATES * sizeof *film.sums) != 0))
            fail_msg("an easy error: other bits");
        if (!easy && !(film.levels && stats.paths < plain_stats.paths))
            fail_msg("%llu paths, without %llu", (unsigned long long)stats.paths, (unsigned long long)plain_stats.paths);
        mcv_film_free(&film);
        mcv_film_free(&plain);
    }
    mcv_renderer_free(renderer);
    mcv_scene_free(scene);
}

static void test_refused(void **state) {
    mcv_scene *scene = make_scene(false);
    (void)state;
    for (int i = 0; i < 2; ++i) {
        mcv_render_options options = options_of(0);
        mcv_film film;
        mcv_render_stats stats;
        mcv_error error = {""};
        if (i == 0) options.replicates = 1;
        if (i == 1) options.first = 16;
        assert_int_equal(mcv_render(scene, 0, &options, &film, &stats, &error), MCV_USAGE);
        assert_non_null(strstr(error.text, i == 0 ? "2 or more, not 1" : "whole render"));
    }
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_flat_is_uniform), cmocka_unit_test(test_noisy_tile),
                                       cmocka_unit_test(test_same_bits),       cmocka_unit_test(test_unbiased),
                                       cmocka_unit_test(test_to_an_error),     cmocka_unit_test(test_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
