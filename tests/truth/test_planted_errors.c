/* SPDX-License-Identifier: Apache-2.0 */
/* ctest: timeout 600 */
/*
 * What a comparison is for: renders with an error planted in the kernels or in the scene are
 * rejected, those of other seeds are accepted. The kernels with an error are a copy of the sources
 * in which one line is changed; tests/mutants has many more of these.
 */
#include "scene_builder.h"

#include "analysis/compare.h"
#include "analysis/statistics.h"
#include "reference/random.h"
#include "render/render.h"

#include <sys/stat.h>
#include <unistd.h>

enum { PIXELS = 32, REPLICATES = 16, DEPTH = 4 };

/* Of seeds: for each planted error, and of renders without one. test_planted_errors_slow.c has
 * more. */
#ifndef ERROR_PAIRS
#define ERROR_PAIRS 1
#define EQUAL_PAIRS 24
#endif

/*
 * A camera of wide aperture inside a block of glass looks at a floor in focus, dark and bright,
 * beside a wall; a panel and a narrow cone light it.
 */
typedef struct setup {
    double reflectance, half_angle, focal_length;
    uint32_t depth;
    uint32_t samples; /* per replicate */
} setup;
static const setup right = {0.8, 0.1, 0.05, DEPTH, 256};

static mcv_scene *make_scene(const setup *s) {
    mcv_scene *scene = mcv_scene_new("planted");
    const double block[3] = {0.2, 0.2, 0.1}, distance = 1;
    add_rectangle(scene, 1, 2, add_diffuse(scene, s->reflectance), looking_up_z(0.5002, 0, 0));
    add_rectangle(scene, 1, 2, add_diffuse(scene, 0.2), looking_up_z(-0.4998, 0, 0));
    add_rectangle(scene, 1, 2, add_diffuse(scene, s->reflectance),
                  looking((const double[3]){-0.4, 0, 0.5}, (const double[3]){1, 0, 0},
                          (const double[3]){0, 1, 0}));
    add_emitter(scene, MCV_EMITTER_AREA,
                add_rectangle(scene, 0.12, 0.2, add_absorber(scene), looking_down_z(-0.13, 0, 0.7)),
                1, 0);
    add_emitter(
        scene, MCV_EMITTER_PARALLEL,
        add_rectangle(scene, 0.4, 0.4, add_absorber(scene), looking_down_z(0.215, 0.1, 0.7)), 60,
        s->half_angle);
    add_box(scene, block, add_glass(scene, 1.5, 0, 0), looking_down_z(0, 0, distance));
    mcv_sensor camera = sensor_defaults(MCV_SENSOR_THIN_LENS);
    mcv_thin_lens_params *p = &camera.as.thin_lens;
    /* 0.1 m of glass shift the focus by 0.1 (1 - 1/n): the rest lies in focus at 1 m of air. */
    const double focus = distance - 0.1 + 0.1 / 1.5, f = right.focal_length;
    p->focalLength = s->focal_length;
    p->imageDistance = f * focus / (focus - f);
    p->lensDiameter = f;
    p->resolution[0] = p->resolution[1] = PIXELS;
    p->pixelSize[0] = p->pixelSize[1] = 0.03 * p->imageDistance / focus / PIXELS;
    add_sensor(scene, MCV_SENSOR_THIN_LENS, &camera, looking_down_z(0, 0, distance));
    return scene;
}

static mcv_film render_setup(const setup *s, uint32_t seed) {
    mcv_scene *scene = make_scene(s);
    mcv_render_options options = mcv_render_defaults();
    mcv_render_stats stats;
    mcv_film film;
    options.replicates = REPLICATES;
    options.last = s->samples;
    options.depth = s->depth;
    options.seed = seed;
    options.no_light_paths = true;
    BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
    mcv_scene_free(scene);
    return film;
}

static mcv_comparison compare(const mcv_film *x, const mcv_film *y) {
    mcv_comparison c;
    BUILD(mcv_compare_films(x, y, &c, &builder_error));
    return c;
}

static mcv_film truths[ERROR_PAIRS]; /* of the unchanged renderer */

static int render_truths(void **state) {
    (void)state;
    for (uint32_t i = 0; i < ERROR_PAIRS; ++i) truths[i] = render_setup(&right, 1 + 1000 * i);
    return 0;
}

static int free_truths(void **state) {
    (void)state;
    for (uint32_t i = 0; i < ERROR_PAIRS; ++i) mcv_film_free(&truths[i]);
    return 0;
}

/* 4 x 2.5e-4 of right pairs are rejected: with fixed seeds none of six. What the tests can see is
 * part of them. */
static void test_other_seeds_are_accepted(void **state) {
    (void)state;
    for (uint32_t seed = 2; seed < (ERROR_PAIRS > 1 ? 8 : 4); ++seed) {
        mcv_film other = render_setup(&right, seed);
        const mcv_comparison c = compare(&truths[0], &other);
        if (seed == 2) print_message("  %s\n", c.reason);
        if (c.different) fail_msg("seed %u: %s", seed, c.reason);
        if (c.detectable > 0.005 || c.detectable_tile > 0.05)
            fail_msg("seed %u: only %g of the mean and %g of a tile would be seen", seed,
                     c.detectable, c.detectable_tile);
        mcv_film_free(&other);
    }
}

static int compare_doubles(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Kolmogorov and Smirnov's D against uniform numbers; sorts. */
static double distance_from_uniform(double *values, int count) {
    double d = 0;
    qsort(values, (size_t)count, sizeof *values, compare_doubles);
    for (int i = 0; i < count; ++i)
        d = fmax(d, fmax((i + 1.0) / count - values[i], values[i] - (double)i / count));
    return d;
}

/* How often a rank test of R against R replicates has a p-value in each tenth, where all come from
 * one distribution: exactly. */
static void share_bins(double shares[MCV_COMPARE_BINS]) {
    double *table = mcv_mann_whitney(REPLICATES, REPLICATES);
    assert_non_null(table);
    for (int b = 0; b < MCV_COMPARE_BINS; ++b) shares[b] = 0;
    for (int u = 0, most = REPLICATES * REPLICATES; u <= most; ++u) {
        const int smaller = u < most - u ? u : most - u;
        const double p = 2 * smaller >= most ? 1 : fmin(1, 2 * table[smaller]);
        shares[p < 1 ? (int)(p * MCV_COMPARE_BINS) : MCV_COMPARE_BINS - 1] +=
            table[u] - (u > 0 ? table[u - 1] : 0);
    }
    free(table);
}

/*
 * Renders of other seeds, each of one pair alone. The verdict is wrong in at most 4 x 2.5e-4 of the
 * pairs, and p-values of units are at most 0.05 in at most 5 % of them; both as binomials say, to
 * 1e-3. The p-values of image means are uniform: Kolmogorov and Smirnov's D is above √(ln(2/p)/2n)
 * with a probability p (Massart 1990), 1e-3. Those of tiles, which are independent of each other,
 * fall into tenths as the rank test's do: chi² of 9 degrees of freedom is above 27.88 with a
 * probability of 1e-3.
 */
static void test_p_values_without_an_error(void **state) {
    static double means[EQUAL_PAIRS];
    double shares[MCV_COMPARE_BINS], chi2 = 0, tiles = 0;
    uint64_t histogram[MCV_COMPARE_BINS] = {0};
    int rejected = 0, small = 0;
    mcv_scene *scene = make_scene(&right);
    mcv_renderer *renderer = mcv_renderer_new();
    (void)state;
    assert_non_null(renderer);
    for (int i = 0; i < EQUAL_PAIRS; ++i) {
        mcv_film films[2];
        for (int k = 0; k < 2; ++k) {
            mcv_render_options options = mcv_render_defaults();
            mcv_render_stats stats;
            options.replicates = REPLICATES;
            options.last = 16;
            options.depth = DEPTH;
            options.seed = (uint32_t)(10000 + 2 * i + k);
            options.no_light_paths = true;
            BUILD(mcv_renderer_render(renderer, scene, 0, &options, &films[k], &stats,
                                      &builder_error));
        }
        const mcv_comparison c = compare(&films[0], &films[1]);
        rejected += c.different;
        small += c.p_unit <= 0.05;
        means[i] = c.p_image;
        tiles += (double)c.tiles;
        for (int b = 0; b < MCV_COMPARE_BINS; ++b) histogram[b] += c.histogram[b];
        for (int k = 0; k < 2; ++k) mcv_film_free(&films[k]);
    }
    mcv_renderer_free(renderer);
    mcv_scene_free(scene);
    share_bins(shares);
    print_message("  tiles' p-values by tenths:");
    for (int b = 0; b < MCV_COMPARE_BINS; ++b) {
        chi2 += pow((double)histogram[b] - tiles * shares[b], 2) / (tiles * shares[b]);
        print_message(" %llu (%.0f)", (unsigned long long)histogram[b], tiles * shares[b]);
    }
    const double d = distance_from_uniform(means, EQUAL_PAIRS),
                 allowed = sqrt(log(2 / 1e-3) / (2.0 * EQUAL_PAIRS));
    print_message("; chi2 %.1f\n  %d of %d pairs rejected; p of units <= 0.05 in %d; p of image "
                  "means %.3f from uniform, allowed %.3f\n",
                  chi2, rejected, EQUAL_PAIRS, small, d, allowed);
    if (mcv_binomial_upper((uint64_t)rejected, EQUAL_PAIRS, 4 * MCV_COMPARE_ALPHA) < 1e-3)
        fail_msg("%d of %d equal pairs are rejected", rejected, EQUAL_PAIRS);
    if (mcv_binomial_upper((uint64_t)small, EQUAL_PAIRS, 0.05) < 1e-3)
        fail_msg("p of units is at most 0.05 in %d of %d equal pairs", small, EQUAL_PAIRS);
    if (d > allowed)
        fail_msg("p-values of image means are %g from uniform ones, allowed %g", d, allowed);
    if (chi2 > 27.88) fail_msg("p-values of tiles: chi2 of %g with 9 degrees of freedom", chi2);
}

/* In at least 95 % of the pairs. */
static void expect_rejected(const setup *s, const char *what) {
    uint32_t accepted = 0;
    mcv_comparison worst = {.different = true};
    for (uint32_t i = 0; i < ERROR_PAIRS; ++i) {
        mcv_film other = render_setup(s, 100 + 1000 * i);
        const mcv_comparison c = compare(&truths[i], &other);
        accepted += !c.different;
        if (i == 0 || !c.different) worst = c;
        mcv_film_free(&other);
    }
    print_message("  %s: rejected in %u of %d; %s\n", what, ERROR_PAIRS - accepted, ERROR_PAIRS,
                  worst.reason);
    if (20 * accepted > ERROR_PAIRS)
        fail_msg("%s is accepted in %u of %d pairs: %s", what, accepted, ERROR_PAIRS, worst.reason);
}

static void test_wrong_scenes_are_rejected(void **state) {
    setup wrong = right;
    (void)state;
    wrong.reflectance *= 1.01;
    expect_rejected(&wrong, "reflectance + 1 %");
    wrong = right;
    wrong.half_angle *= 1.01;
    expect_rejected(&wrong, "half-angle + 1 %");
    wrong = right;
    wrong.focal_length *= 1.001;
    expect_rejected(&wrong, "focal length + 0.1 %");
    wrong = right;
    wrong.depth -= 1;
    expect_rejected(&wrong, "without the last bounce");
}

typedef struct planted {
    const char *what, *file, *line, *wrong;
} planted;

static char *read_text(const char *path) {
    FILE *file = fopen(path, "r");
    if (!file) fail_msg("%s: cannot be read", path);
    char *text = calloc(1, 1 << 20);
    assert_non_null(text);
    assert_true(fread(text, 1, (1 << 20) - 1, file) > 0);
    fclose(file);
    return text;
}

/* Replaces every occurrence; at least one is expected, so that a change of the sources is noticed.
 */
static void plant(const char *folder, const planted *error) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, error->file);
    char *text = read_text(path), *at = text;
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    if (!strstr(text, error->line))
        fail_msg("%s: %s has no \"%s\" any more", error->what, error->file, error->line);
    for (char *found; (found = strstr(at, error->line)); at = found + strlen(error->line)) {
        fwrite(at, 1, (size_t)(found - at), file);
        fputs(error->wrong, file);
    }
    fputs(at, file);
    assert_int_equal(fclose(file), 0);
    free(text);
}

static void test_wrong_kernels_are_rejected(void **state) {
    static const planted errors[] = {
        {"no error", "kernels/bsdf/bsdf.h", "response.density", "response.density"},
        {"no cosine of the receiver", "kernels/bsdf/bsdf.h",
         "mcv_dim(reflectance, response.density)", "mcv_dim(reflectance, 0.31830989f)"},
        {"no n^2 of the sensor's medium", "kernels/stage/accumulate_film.h",
         " * world.frame->sensor_index_squared[channel]", ""},
        {"half a pixel aside", "kernels/stage/generate_rays.h", "film.x = inside.x;",
         "film.x = inside.x + 0.5f;"},
        {"random numbers used twice", "kernels/path/sampler.h", "MCV_PAIR_CHOICE, MCV_PAIR_STRIDE",
         "MCV_PAIR_CHOICE = MCV_PAIR_EMITTER, MCV_PAIR_STRIDE"},
        {"origins moved to the wrong side", "include/mcvisi/offset.h", "< 0.0f ? -reach : reach",
         "< 0.0f ? reach : -reach"},
    };
    char folder[] = "planted.XXXXXX", command[1024];
    (void)state;
    assert_non_null(mkdtemp(folder));
    for (size_t i = 0; i < sizeof errors / sizeof errors[0]; ++i) {
        snprintf(command, sizeof command, "rm -rf %s/* && cp -r %s/kernels %s/include %s", folder,
                 MCV_SOURCE_DIR, MCV_SOURCE_DIR, folder);
        assert_int_equal(system(command), 0);
        plant(folder, &errors[i]);
        assert_int_equal(setenv("MCVISI_KERNEL_DIR", folder, 1), 0);
        if (i > 0) {
            expect_rejected(&right, errors[i].what);
        } else {
            mcv_film other = render_setup(&right, 100);
            const mcv_comparison c = compare(&truths[0], &other);
            if (c.different) fail_msg("the sources as they are: %s", c.reason);
            mcv_film_free(&other);
        }
        unsetenv("MCVISI_KERNEL_DIR");
    }
    snprintf(command, sizeof command, "rm -rf %s", folder);
    assert_int_equal(system(command), 0);
}

/*
 * A film of plain floats, of 2^25 samples between 0.6 and 0.8: above 2^23 they count as 1, above
 * 2^24 not at all. Beside it the film's own sum over a tree of pairs of floats, in blocks of 64 and
 * then in double.
 */
static void test_float_film_is_rejected(void **state) {
    enum { SAMPLES = 1 << 21 };
    static double block[64];
    mcv_film films[2];
    (void)state;
    for (int i = 0; i < 2; ++i) {
        BUILD(mcv_film_new(&films[i], 1, 1, 1, REPLICATES, &builder_error));
        films[i].samples = (uint64_t)SAMPLES * 16;
    }
    for (uint32_t r = 0; r < REPLICATES; ++r) {
        ref_random a = {r + 1}, b = {r + 100};
        float plain = 0;
        for (uint64_t s = 0; s < films[0].samples; s += 64) {
            for (int k = 0; k < 64; ++k) {
                plain += (float)(0.6 + 0.2 * ref_random_unit(&a));
                block[k] = 0.6 + 0.2 * ref_random_unit(&b);
            }
            films[1].sums[r] += mcv_pairwise_sum(block, 64, 1);
        }
        films[0].sums[r] = plain;
    }
    const mcv_comparison c = compare(&films[0], &films[1]);
    print_message("  a film of plain floats: %s\n", c.reason);
    assert_true(c.different);
    for (int i = 0; i < 2; ++i) mcv_film_free(&films[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_other_seeds_are_accepted),
        cmocka_unit_test(test_p_values_without_an_error),
        cmocka_unit_test(test_wrong_scenes_are_rejected),
    };
    const struct CMUnitTest long_tests[] = {
        cmocka_unit_test(test_other_seeds_are_accepted),
        cmocka_unit_test(test_p_values_without_an_error),
        cmocka_unit_test(test_wrong_scenes_are_rejected),
        cmocka_unit_test(test_wrong_kernels_are_rejected),
        cmocka_unit_test(test_float_film_is_rejected),
    };
    return ERROR_PAIRS > 1 ? cmocka_run_group_tests(long_tests, render_truths, free_truths)
                           : cmocka_run_group_tests(tests, render_truths, free_truths);
}
