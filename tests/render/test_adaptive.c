/* SPDX-License-Identifier: Apache-2.0 */
/* Adaptive sampling: where the samples go, that the image and its error bars stay right, and what
 * it brings. */
#include "convergence.h"
#include "scene_builder.h"

#include "analysis/compare.h"
#include "render/adaptive.h"
#include "scene/spectra.h"

/* test_adaptive_slow.c sets it: all cases, of which the quick test has those that no others stand
 * for. */
#ifndef SLOW
#define SLOW 0
#endif

enum { PIXELS = 36, SEEDS = 64, GROUP = 8, SAMPLES = 128, LOOK = 4, REPLICATES = 4 };

/* A diffuse ball under a panel, one ninth of a black picture; or a light field camera's view of a
 * ball of glass with what it focuses. */
static mcv_scene *make_scene(bool caustic) {
    mcv_scene *scene = mcv_scene_new("adaptive");
    add_sphere(scene, 0.5, 16, caustic ? add_glass(scene, 1.5, 0, 1) : add_diffuse(scene, 0.5),
               looking_down_z(0.3, 0.2, 0));
    const uint32_t panel = add_rectangle(scene, 2, 2, add_absorber(scene), looking_down_z(0, 0, 4));
    if (caustic) add_rectangle(scene, 3, 3, add_diffuse(scene, 0.5), looking_down_z(0, 0, -1));
    mcv_emitter emitter = {.name = (char *)"panel",
                           .type = MCV_EMITTER_PARALLEL,
                           .instance = panel,
                           .texture = MCV_NONE};
    mcv_params_set_defaults(mcv_emitter_table(MCV_EMITTER_PARALLEL), &emitter.as);
    emitter.as.parallel.halfAngle = 0.3;
    for (int c = 0; c < 3; ++c) emitter.as.parallel.radiance[c] = 1;
    BUILD(mcv_scene_add_emitter(scene, &emitter, &builder_error));
    add_pinhole(scene, PIXELS, 1, looking_down_z(0.1, 0, 3));
    return scene;
}

/* SAMPLES over all replicates, of which a look takes LOOK. */
static mcv_render_options options_of(uint32_t seed, uint32_t replicates) {
    mcv_render_options options = mcv_render_defaults();
    options.replicates = replicates;
    options.last = SAMPLES / replicates;
    options.seed = seed;
    options.adaptive = MCV_ADAPTIVE_ON;
    return options;
}

static mcv_film render(mcv_renderer *renderer, const mcv_scene *scene, mcv_render_options options,
                       mcv_render_stats *stats) {
    mcv_film film;
    BUILD(mcv_renderer_render(renderer, scene, 0, &options, &film, stats, &builder_error));
    return film;
}

/* --- where the samples go
 * ----------------------------------------------------------------------------------------- */

enum { WIDTH = 60, HEIGHT = 44, LOOKS = 8 };

typedef double variance_at(uint32_t x, uint32_t y);

/* A look whose replicates are those variances' normal noise about 1 (the sum of twelve random
 * numbers, less 6). */
static mcv_film film_of(variance_at *variance) {
    mcv_film film;
    unsigned random = 1;
    BUILD(mcv_film_new(&film, WIDTH, HEIGHT, 1, LOOKS, &builder_error));
    for (uint32_t r = 0; r < LOOKS; ++r) {
        for (uint32_t y = 0; y < HEIGHT; ++y) {
            for (uint32_t x = 0; x < WIDTH; ++x) {
                double normal = -6;
                for (int i = 0; i < 12; ++i)
                    normal += (double)((random = 1664525 * random + 1013904223) >> 8) * 0x1p-24;
                film.sums[((size_t)r * HEIGHT + y) * WIDTH + x] = 1 + sqrt(variance(x, y)) * normal;
            }
        }
    }
    return film;
}

static double black(uint32_t x, uint32_t y) { return (void)x, (void)y, 0; }
static double flat(uint32_t x, uint32_t y) { return (void)x, (void)y, 0.01; }
static double spot(uint32_t x, uint32_t y) {
    return x >= 20 && x < 32 && y >= 12 && y < 24 ? 1 : 0.01;
}
static double line(uint32_t x, uint32_t y) { return (void)y, x == 29 ? 1 : 0; }

/* Their mean in units of level 0. */
static double mean_power(const signed char *levels) {
    double sum = 0;
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; ++i) sum += ldexp(1, levels[i]);
    return sum / (WIDTH * HEIGHT);
}

/* No gain; where nothing is known, the same for all. */
static void test_flat_gains_nothing(void **state) {
    signed char levels[WIDTH * HEIGHT];
    double gain;
    (void)state;
    for (int is_flat = 0; is_flat < 2; ++is_flat) {
        mcv_film film = film_of(is_flat ? flat : black);
        BUILD(mcv_allocate_samples(&film, 1, 1, levels, &gain, &builder_error));
        for (int i = 0; i < WIDTH * HEIGHT && !is_flat; ++i)
            if (levels[i] != 0) fail_msg("pixel %d of a black film: level %d", i, levels[i]);
        /* What the noise of one half of 4 replicates makes of the largest square: shares of a
         * variance of 2/3/17²/4, half a thousandth. */
        if (!(is_flat ? fabs(gain - 1) < 0.005 : gain == 1))
            fail_msg("a flat film gains %.15g", gain);
        mcv_film_free(&film);
    }
}

/*
 * With fall 1 the spot takes ten times the samples of the others, which is 8 or 16 in powers of
 * two; so do its inner pixels whatever is blurred. In the best case the sum falls from (144 + 0.01
 * n)/p to (144 + 0.1 n)²/p², n = p - 144: 4.4 times; the blur at the spot's rim costs less than
 * half of it.
 */
static void test_spot(void **state) {
    signed char levels[WIDTH * HEIGHT];
    double gain;
    (void)state;
    mcv_film film = film_of(spot);
    for (double budget = 0.5; budget <= 1; budget += 0.125) {
        BUILD(mcv_allocate_samples(&film, 1, budget, levels, &gain, &builder_error));
        const signed char within = levels[18 * WIDTH + 26], without = levels[40 * WIDTH + 50];
        if (within - without != 3 && within - without != 4)
            fail_msg("levels %d and %d", within, without);
        /* Pixels cross a power of two one by one: what is left of the budget is less than the
         * largest of them brings. */
        const double power = mean_power(levels);
        if (!(power <= budget && power > budget - 8.0 / (WIDTH * HEIGHT) - 0.02 * budget))
            fail_msg("%g of the samples: at most %g", power, budget);
        if (!(gain > 2.2 && gain < 4.4)) fail_msg("gain %g", gain);
    }
    mcv_film_free(&film);
}

/* A line of one pixel takes the samples, and its neighbours do: where it ends within a pixel they
 * may see it, too. All keep some. */
static void test_line(void **state) {
    signed char levels[WIDTH * HEIGHT];
    double gain;
    (void)state;
    mcv_film film = film_of(line);
    BUILD(mcv_allocate_samples(&film, 1, 1, levels, &gain, &builder_error));
    for (uint32_t y = 0; y < HEIGHT; ++y) {
        for (uint32_t x = 0; x < WIDTH; ++x) {
            const signed char level = levels[y * WIDTH + x];
            if (x >= 28 && x <= 30 ? level < 2 : level > 0)
                fail_msg("pixel %u, %u: level %d", x, y, level);
        }
    }
    mcv_film_free(&film);
}

/* --- renders
 * --------------------------------------------------------------------------------------------------------
 */

static void test_same_bits(void **state) {
    mcv_scene *scene = make_scene(false);
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_film first = {0};
    mcv_render_stats stats;
    (void)state;
    for (int i = 0; i < 3; ++i) {
        mcv_render_options options = options_of(5, REPLICATES);
        options.schedule = i == 2 ? MCV_SCHEDULE_STREAM : MCV_SCHEDULE_TILE;
        options.slice = i == 1 ? 64 : 0;
        mcv_film film = render(renderer, scene, options, &stats);
        const size_t values = film_values(&film) * REPLICATES;
        assert_non_null(film.levels);
        if (i > 0 && (memcmp(film.levels, first.levels, PIXELS * PIXELS) != 0 ||
                      memcmp(film.sums, first.sums, values * sizeof *film.sums) != 0))
            fail_msg("%s: other bits", i == 1 ? "slices of 64" : "stream");
        const double samples = mcv_film_mean_samples(&film) + LOOK;
        if (samples > SAMPLES || samples < 0.95 * SAMPLES)
            fail_msg("%g samples on the average, at most %d", samples, SAMPLES);
        double paths = LOOK * PIXELS * PIXELS;
        for (uint32_t y = 0; y < PIXELS; ++y)
            for (uint32_t x = 0; x < PIXELS; ++x) paths += mcv_film_samples_at(&film, x, y);
        if (paths != (double)stats.paths)
            fail_msg("%llu paths, not %.0f", (unsigned long long)stats.paths, paths);
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

/* The mean image of each of so many seeds as one replicate of a film; what their error bars tell is
 * added to variances[seed]. */
static mcv_film render_seeds(const mcv_scene *scene, uint32_t replicates, uint32_t count,
                             bool caustic, double *variances) {
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_film means;
    BUILD(mcv_film_new(&means, PIXELS, PIXELS, mcv_scene_channels(scene), count, &builder_error));
    const size_t values = film_values(&means);
    means.samples = 1;
    for (uint32_t i = 0; i < count; ++i) {
        mcv_render_stats stats;
        mcv_film film = render(renderer, scene, options_of(i, replicates), &stats);
        if (!film.levels) fail_msg("seed %u: not adaptive", i);
        if ((strstr(stats.features, "light-tracing") != NULL) != caustic)
            fail_msg("features: %s", stats.features);
        for (size_t v = 0; v < values; ++v) means.sums[i * values + v] = film_value(&film, v);
        variances[i] = variance_of(&film);
        mcv_film_free(&film);
    }
    mcv_renderer_free(renderer);
    return means;
}

/* The same of one long plain render. */
static mcv_film render_plain(const mcv_scene *scene, uint32_t replicates) {
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_render_options options = options_of(SEEDS, replicates);
    mcv_render_stats stats;
    options.adaptive = MCV_ADAPTIVE_OFF;
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
 * The means of many seeds are compared with a plain render. And the variance that error bars tell
 * is that between the seeds: their difference in eight groups of eight, by Student's t with 7
 * degrees of freedom (5.4: one in a thousand).
 */
static void check_unbiased(const char *name, uint32_t replicates, bool caustic) {
    mcv_scene *scene = make_scene(caustic);
    double told[SEEDS], differences[SEEDS / GROUP], mean = 0;
    mcv_comparison comparison;
    mcv_film means = render_seeds(scene, replicates, SEEDS, caustic, told);
    mcv_film plain = render_plain(scene, replicates);
    BUILD(mcv_compare_films(&means, &plain, &comparison, &builder_error));
    if (comparison.different) fail_msg("%s: %s", name, comparison.reason);
    for (uint32_t first = 0; first < SEEDS; first += GROUP) {
        mcv_film group = group_of(&means, first);
        double *difference = differences + first / GROUP;
        *difference = -variance_of(&group) * GROUP;
        mean -= *difference * GROUP / SEEDS;
        for (uint32_t i = first; i < first + GROUP; ++i) *difference += told[i] / GROUP;
        mcv_film_free(&group);
    }
    const mcv_estimate difference = mcv_estimate_replicates(differences, SEEDS / GROUP);
    if (replicates > 1 && !(fabs(difference.mean) <= 5.4 * sqrt(difference.variance)))
        fail_msg("%s: the error bars' variance is off by %.3g ± %.3g of %.3g", name,
                 difference.mean, sqrt(difference.variance), mean);
    /* Most of the picture has little noise. */
    const double alike = variance_of(&plain) * SEEDS / replicates;
    printf("%s, %u replicates: %s; variance %.3g, without %.3g\n", name, replicates,
           comparison.reason, mean, alike);
    if (!(mean < alike / 2)) fail_msg("%s: variance %.3g, without %.3g", name, mean, alike);
    mcv_film_free(&means);
    mcv_film_free(&plain);
    mcv_scene_free(scene);
}

static void test_unbiased(void **state) {
    (void)state;
    if (!SLOW) check_unbiased("ball", REPLICATES, false);
    if (SLOW) check_unbiased("ball", 1, false);
    if (SLOW) check_unbiased("caustic", REPLICATES, true);
}

/* To an error: stops by itself; where it does not pay, the bits are those without. */
static void test_to_an_error(void **state) {
    mcv_scene *scene = make_scene(false);
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_render_stats stats, plain_stats;
    (void)state;
    for (int easy = 0; easy < 2; ++easy) {
        mcv_render_options options = options_of(3, REPLICATES);
        options.last = 0;
        options.error = easy ? 0.5 : SLOW ? 0.002 : 0.004;
        mcv_film film = render(renderer, scene, options, &stats);
        options.adaptive = MCV_ADAPTIVE_OFF;
        mcv_film plain = render(renderer, scene, options, &plain_stats);
        assert_true(mcv_film_relative_error(&film) <= options.error);
        if (easy &&
            (film.levels || memcmp(film.sums, plain.sums,
                                   film_values(&film) * REPLICATES * sizeof *film.sums) != 0))
            fail_msg("an easy error: other bits");
        if (!easy && !(film.levels && stats.paths < plain_stats.paths))
            fail_msg("%llu paths, without %llu", (unsigned long long)stats.paths,
                     (unsigned long long)plain_stats.paths);
        mcv_film_free(&film);
        mcv_film_free(&plain);
    }
    mcv_renderer_free(renderer);
    mcv_scene_free(scene);
}

/*
 * A ball in a ninth of a black picture takes so few samples that `auto` decides as `on` does. A
 * floor in three quarters of one takes some three quarters of the samples and more: enough for
 * `on`, which does not ask how long they take, and not for `auto`, whose bits are those without.
 */
static void test_auto(void **state) {
    mcv_renderer *renderer = mcv_renderer_new();
    (void)state;
    for (int wide = 0; wide < 2; ++wide) {
        mcv_scene *scene = make_scene(false);
        if (wide) add_rectangle(scene, 4, 8, add_diffuse(scene, 0.5), looking_up_z(-1.3, 0, 0.6));
        mcv_film films[3];
        for (uint32_t mode = MCV_ADAPTIVE_OFF; mode <= MCV_ADAPTIVE_AUTO; ++mode) {
            mcv_render_options options = options_of(3, REPLICATES);
            mcv_render_stats stats;
            options.adaptive = mode;
            films[mode] = render(renderer, scene, options, &stats);
        }
        const mcv_film *automatic = &films[MCV_ADAPTIVE_AUTO],
                       *same = &films[wide ? MCV_ADAPTIVE_OFF : MCV_ADAPTIVE_ON];
        if (films[MCV_ADAPTIVE_OFF].levels || !films[MCV_ADAPTIVE_ON].levels ||
            (automatic->levels == NULL) != wide)
            fail_msg("wide %d: off, on, auto are %s, %s, %s", wide,
                     films[MCV_ADAPTIVE_OFF].levels ? "adaptive" : "plain",
                     films[MCV_ADAPTIVE_ON].levels ? "adaptive" : "plain",
                     automatic->levels ? "adaptive" : "plain");
        assert_memory_equal(automatic->sums, same->sums,
                            film_values(same) * REPLICATES * sizeof *same->sums);
        for (int mode = 0; mode < 3; ++mode) mcv_film_free(&films[mode]);
        mcv_scene_free(scene);
    }
    mcv_renderer_free(renderer);
}

static bool stop_at_once(void *user, double fraction, double seconds, double error) {
    (void)user, (void)fraction, (void)seconds, (void)error;
    return false;
}

/* Who stops it while it looks round gets the first samples of all pixels. */
static void test_stopped_look(void **state) {
    mcv_scene *scene = make_scene(false);
    mcv_renderer *renderer = mcv_renderer_new();
    mcv_render_options options = options_of(2, 1);
    mcv_render_stats stats;
    (void)state;
    options.progress = stop_at_once;
    mcv_film film = render(renderer, scene, options, &stats);
    if (!stats.interrupted || film.levels || film.samples == 0 || film.samples >= SAMPLES)
        fail_msg("stopped at %llu samples, %s", (unsigned long long)film.samples,
                 film.levels ? "adaptive" : "plain");
    mcv_film_free(&film);
    mcv_renderer_free(renderer);
    mcv_scene_free(scene);
}

static void test_refused(void **state) {
    mcv_scene *scene = make_scene(false);
    (void)state;
    for (int i = 0; i < 2; ++i) {
        mcv_render_options options = options_of(0, 1);
        mcv_film film;
        mcv_render_stats stats;
        mcv_error error = {""};
        if (i == 0) options.last = 1u << 29;
        if (i == 1) options.first = 16;
        assert_int_equal(mcv_render(scene, 0, &options, &film, &stats, &error), MCV_USAGE);
        assert_non_null(strstr(error.text, i == 0 ? "2^28 samples" : "whole render"));
    }
    mcv_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_flat_gains_nothing),
                                       cmocka_unit_test(test_spot),
                                       cmocka_unit_test(test_line),
                                       cmocka_unit_test(test_same_bits),
                                       cmocka_unit_test(test_unbiased),
                                       cmocka_unit_test(test_to_an_error),
                                       cmocka_unit_test(test_auto),
                                       cmocka_unit_test(test_stopped_look),
                                       cmocka_unit_test(test_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
