/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Error bars that are true: the standard error of a pixel covers the truth as often as Student's t with R - 1 degrees of freedom says, with
 * Sobol' points; and --error ends where it was told to.
 */
#include "scene_builder.h"

#include "analysis/statistics.h"
#include "convergence.h"

/*
 * The report's lens before a light field camera and a lit part: noise in most pixels, or in some. And a part before a backlight, which has
 * some at its edges alone: there a pixel's replicates take two or three values, each a sample more or less, and t is no law for
 * them. Its coverage is only told.
 */
static const struct {
    const char *file;
    bool lawful;
} cases[] = {{"report-clean.glb", true}, {"part-arealight.gltf", true}, {"part-backlight.gltf", false}};
enum { CASES = 3, SAMPLES = 64 }; /* per replicate */

typedef struct counts {
    int pixels, exact; /* with an error above 0; without, of them wrong */
    int wrong, covered[3];
} counts;
static const double levels[3] = {0.5, 0.9, 0.95};

static void count(const mcv_film *film, const mcv_film *truth, counts *c) {
    mcv_image mean, error;
    double quantiles[3];
    BUILD(mcv_film_develop(film, &mean, &error, &builder_error));
    for (int k = 0; k < 3; ++k) quantiles[k] = mcv_student_quantile(1 - levels[k], film->replicates - 1);
    for (size_t i = 0; i < film_values(film); ++i) {
        const double expected = film_value(truth, i), off = fabs((double)mean.pixels[i] - expected);
        if (error.pixels[i] > 0) {
            ++c->pixels;
            for (int k = 0; k < 3; ++k) c->covered[k] += off <= quantiles[k] * (double)error.pixels[i];
        } else {
            ++c->exact;
            /* Equal to float32's rounding, or missed by all samples. */
            c->wrong += off > 0x1p-20 * expected;
        }
    }
    mcv_image_free(&mean);
    mcv_image_free(&error);
}

/*
 * 3 % are allowed. Of at least 400 values with an error (fails below), a coverage of 0.95 has a standard deviation of 1.1 %, and one
 * of 0.9 of 1.5 %. The truth has 16 times as many samples per pixel as the most replicates have and more.
 */
static void test_coverage(void **state) {
    enum { SEEDS = 24 };
    (void)state;
    for (int s = 0; s < CASES; ++s) {
        mcv_scene *scene;
        mcv_film truth;
        mcv_render_stats stats;
        BUILD(load_small(cases[s].file, &scene, &builder_error));
        BUILD(render_truth(scene, 6, &truth, &stats, &builder_error));
        mcv_renderer *renderer = mcv_renderer_new();
        assert_non_null(renderer);
        for (uint32_t replicates = 4; replicates <= 16; replicates *= 2) {
            counts c = {0};
            for (uint32_t seed = 1; seed <= SEEDS; ++seed) {
                mcv_render_options options = mcv_render_defaults();
                mcv_film film;
                options.replicates = replicates;
                options.last = SAMPLES;
                options.seed = seed;
                BUILD(mcv_renderer_render(renderer, scene, 0, &options, &film, &stats, &builder_error));
                count(&film, &truth, &c);
                mcv_film_free(&film);
            }
            const double n = c.pixels;
            print_message(
                "  %s, R = %u: %d values with an error; within the t quantiles of 50, 90, 95 %%: %.1f, %.1f, %.1f %%; %d without, "
                "%d of them wrong\n",
                cases[s].file, replicates, c.pixels, 100 * c.covered[0] / n, 100 * c.covered[1] / n, 100 * c.covered[2] / n, c.exact,
                c.wrong);
            if (!cases[s].lawful) continue;
            assert_true(c.pixels > 400);
            for (int k = 1; k < 3; ++k)
                if (fabs(c.covered[k] / n - levels[k]) > 0.03)
                    fail_msg("%s, R = %u: %.1f %% of the values lie within their %.0f %% interval", cases[s].file, replicates,
                             100 * c.covered[k] / n, 100 * levels[k]);
        }
        mcv_renderer_free(renderer);
        mcv_film_free(&truth);
        mcv_scene_free(scene);
    }
}

/*
 * The true error, root mean square over the image's mean, where E was asked for: the samples are doubled until the error that is told is
 * below E, so that it ends at half of it or more where the error falls no faster than the samples grow, and told and true differ by chance.
 */
static void test_error_ends(void **state) {
    (void)state;
    for (int s = 0; s < CASES; ++s) {
        mcv_scene *scene;
        mcv_film truth;
        mcv_render_stats stats;
        BUILD(load_small(cases[s].file, &scene, &builder_error));
        BUILD(render_truth(scene, 6, &truth, &stats, &builder_error));
        for (double asked = 0.06; asked > 0.02; asked /= 2) {
            mcv_render_options options = mcv_render_defaults();
            mcv_film film;
            options.error = asked;
            options.seed = 5;
            BUILD(mcv_render(scene, 0, &options, &film, &stats, &builder_error));
            const double told = mcv_film_relative_error(&film), true_error = errors_against(&film, &truth).rmse / mcv_film_mean(&truth);
            print_message("  %s, --error %g: told %.3g of it, truly %.3g of it, %llu samples\n", cases[s].file, asked, told / asked,
                          true_error / asked, (unsigned long long)film.samples * film.replicates);
            if (!(true_error >= 0.5 * asked && true_error <= 1.1 * asked))
                fail_msg("%s, --error %g ended at %g", cases[s].file, asked, true_error);
            mcv_film_free(&film);
        }
        mcv_film_free(&truth);
        mcv_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_coverage), cmocka_unit_test(test_error_ends)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
